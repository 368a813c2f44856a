#include <ecorche/tissue/drag_ground.h>

#include <numeric>

namespace ecorche::tissue {

void addRows(const domain::Domain& domain, const mesh::StiffnessPattern& pattern,
             const std::vector<CoreSample>& samples, double times, std::vector<double>& K) {
  for (const CoreSample& s : samples) {
    const double w = times * s.weight;
    for (int k = 0; k < 4; ++k) {
      const std::int32_t r = pattern.row[static_cast<std::size_t>(domain.mesh.T(s.tet, k))];
      if (r >= 0)
        K[static_cast<std::size_t>(pattern.diagonal(r))] += w * s.barycentric[k] * s.barycentric[k];
    }
    for (std::size_t e = 0; e < 6; ++e) {
      const std::int32_t slot = pattern.edgeSlot[static_cast<std::size_t>(s.tet)][e];
      if (slot >= 0)
        K[static_cast<std::size_t>(slot)] +=
            w * s.barycentric[mesh::kTetEdge[e][0]] * s.barycentric[mesh::kTetEdge[e][1]];
    }
  }
}

DragGround::DragGround(std::shared_ptr<const TissueSolver> theSolver,
                       const TissueSolver::Factor& factor, const CoreSamples& cores)
    : solver(std::move(theSolver)), tree(factor), K(solver->stiffness()) {
  const mesh::StiffnessPattern& pattern = solver->pattern();
  addRows(solver->domain(), pattern, cores.samples, 1.0, K);
  const auto n = static_cast<std::size_t>(pattern.rowCount());
  const auto entries = [&](std::size_t c) {
    return std::pair(static_cast<std::size_t>(pattern.first[c]) + 1,  // the diagonal comes first
                     static_cast<std::size_t>(pattern.first[c + 1]));
  };
  first.assign(n + 1, 0);
  for (std::size_t c = 0; c < n; ++c) {
    const auto [begin, end] = entries(c);
    first[c + 1] += static_cast<std::int32_t>(end - begin);
    for (std::size_t i = begin; i < end; ++i)
      ++first[static_cast<std::size_t>(pattern.index[i]) + 1];
  }
  std::partial_sum(first.begin(), first.end(), first.begin());
  neighbour.resize(static_cast<std::size_t>(first.back()));
  slot.resize(neighbour.size());
  std::vector<std::int32_t> next(first.begin(), first.end() - 1);
  for (std::size_t c = 0; c < n; ++c) {
    const auto [begin, end] = entries(c);
    for (std::size_t i = begin; i < end; ++i) {
      const auto r = static_cast<std::size_t>(pattern.index[i]);
      for (const auto& [from, to] : {std::pair(r, c), std::pair(c, r)}) {
        const auto at = static_cast<std::size_t>(next[from]++);
        neighbour[at] = static_cast<std::int32_t>(to);
        slot[at] = static_cast<std::int32_t>(i);
      }
    }
  }
}

}  // namespace ecorche::tissue
