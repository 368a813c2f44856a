#include <ecorche/tissue/drag_ground.h>

namespace ecorche::tissue {

void addRows(const mesh::TetMesh& mesh, const mesh::StiffnessPattern& pattern,
             const std::vector<CoreSample>& samples, double times, std::vector<double>& K) {
  for (const CoreSample& s : samples) {
    const double w = times * s.weight;
    for (int k = 0; k < 4; ++k) {
      const std::int32_t r = pattern.row[static_cast<std::size_t>(mesh.T(s.tet, k))];
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

DragGround::DragGround(const std::shared_ptr<const TissueSolver>& solver,
                       const TissueSolver::Factor& factor, const CoreSamples& cores)
    : pattern(solver, &solver->pattern()),
      symbolic(solver, solver->symbolic()),
      tree(factor),
      K(solver->stiffness()),
      rows(std::make_shared<const mesh::NeighbourRows>(mesh::neighbourRows(*pattern))) {
  addRows(solver->domain().mesh, *pattern, cores.samples, 1.0, K);
}

DragGround::DragGround(std::shared_ptr<const mesh::StiffnessPattern> of,
                       std::shared_ptr<const mesh::SymbolicCholesky> analysed,
                       mesh::TreeSolver<float> solver, std::vector<double> matrix,
                       std::shared_ptr<const mesh::NeighbourRows> both)
    : pattern(std::move(of)),
      symbolic(std::move(analysed)),
      tree(std::move(solver)),
      K(std::move(matrix)),
      rows(std::move(both)) {}

}  // namespace ecorche::tissue
