#include <ecorche/core/contract.h>
#include <ecorche/core/index.h>
#include <ecorche/envelope/islands.h>
#include <ecorche/envelope/placing.h>
#include <ecorche/envelope/splitting.h>
#include <ecorche/mesh/disjoint_sets.h>
#include <fmt/format.h>

#include <algorithm>
#include <set>

namespace ecorche::envelope {
namespace {

/// Cells as nodes: one per tet and owner, linked across faces on which the owner shows.
class CellGraph {
 public:
  CellGraph(const mesh::Tets& T, const mesh::TetNeighbours& neighbours, const Diagram& d);

  [[nodiscard]] std::int32_t nodeOf(std::int32_t tet, std::int32_t column) const {
    for (std::int32_t n = first_[toIndex(tet)]; n < first_[toIndex(tet) + 1]; ++n) {
      if (column_[toIndex(n)] == column) return n;
    }
    return -1;
  }

  struct Component {
    std::int32_t column = -1;
    std::vector<std::int32_t> tets;
    bool seeded = false;
  };
  /// In order of their first cell.
  [[nodiscard]] std::vector<Component> components(std::span<const TissueInTet> seeds);

 private:
  std::vector<std::int32_t> first_;  ///< #T + 1
  std::vector<std::int32_t> column_;
  mesh::DisjointSets sets_{0};
};

CellGraph::CellGraph(const mesh::Tets& T, const mesh::TetNeighbours& neighbours, const Diagram& d) {
  const auto complexOwners = ownersOfComplexTets(d);
  std::vector<std::int32_t> mixedOf(toIndex(T.rows()), -1);
  for (std::size_t m = 0; m < d.mixed.size(); ++m)
    mixedOf[toIndex(d.mixed[m])] = static_cast<std::int32_t>(m);

  first_.reserve(toIndex(T.rows()) + 1);
  for (Eigen::Index t = 0; t < T.rows(); ++t) {
    first_.push_back(static_cast<std::int32_t>(column_.size()));
    const std::int32_t m = mixedOf[toIndex(t)];
    if (m >= 0 && d.complexOf[toIndex(m)] >= 0) {
      const auto& owners = complexOwners[toIndex(d.complexOf[toIndex(m)])];
      column_.insert(column_.end(), owners.begin(), owners.end());
      continue;
    }
    const std::int32_t own = d.owner[toIndex(T(t, 0))];
    column_.push_back(own);
    for (int c = 1; m >= 0 && c < 4; ++c) {
      const std::int32_t other = d.owner[toIndex(T(t, c))];
      if (other == own) continue;
      column_.push_back(other);
      break;
    }
  }
  first_.push_back(static_cast<std::int32_t>(column_.size()));

  sets_ = mesh::DisjointSets(column_.size());
  const auto unite = [&](std::int32_t t, std::int32_t u, std::int32_t column) {
    const std::int32_t a = nodeOf(t, column);
    const std::int32_t b = nodeOf(u, column);
    if (a >= 0 && b >= 0)
      sets_.unite(a, b);  // struck on one side only: a conflict, settled elsewhere
  };
  for (std::int32_t t = 0; t < T.rows(); ++t) {
    for (int k = 0; k < 4; ++k) {
      const std::int32_t u = neighbours(t, k);
      if (u <= t) continue;
      const std::int32_t m = mixedOf[toIndex(t)];
      if (m < 0 || mixedOf[toIndex(u)] < 0) {
        unite(t, u, d.owner[toIndex(T(t, mesh::kTetFace[k][0]))]);
      } else {
        for (const std::int32_t column : ownersOnFace(T, d, m, k)) unite(t, u, column);
      }
    }
  }
}

std::vector<CellGraph::Component> CellGraph::components(std::span<const TissueInTet> seeds) {
  std::vector<std::int32_t> label;
  std::vector<Component> all(toIndex(sets_.label(label)));
  for (std::int32_t t = 0; t + 1 < static_cast<std::int32_t>(first_.size()); ++t) {
    for (std::int32_t n = first_[toIndex(t)]; n < first_[toIndex(t) + 1]; ++n) {
      all[toIndex(label[toIndex(n)])].column = column_[toIndex(n)];
      all[toIndex(label[toIndex(n)])].tets.push_back(t);
    }
  }
  for (const TissueInTet& seed : seeds) {
    const std::int32_t n = nodeOf(seed.tet, seed.tissue.value - kFat.value);
    if (n >= 0) all[toIndex(label[toIndex(n)])].seeded = true;
  }
  return all;
}

/// Volume of the cells of a component. Tets with a conflict have no cells yet and count nothing.
double volumeOf(const mesh::TetMesh& mesh, const Diagram& d, const Placement& placement,
                const CellGraph::Component& component) {
  const auto place = [&](std::int32_t v) -> mesh::Vector3 {
    if (v < d.vertexCount()) return mesh.V.row(v).transpose();
    const Anatomy::Origin& o = placement.origin[toIndex(v - d.vertexCount())];
    mesh::Vector3 p = mesh::Vector3::Zero();
    for (std::size_t c = 0; c < 4; ++c) {
      if (o.corner[c] >= 0) p += o.weight[c] * mesh.V.row(o.corner[c]).transpose();
    }
    return p;
  };
  double volume = 0.0;
  std::vector<SubTet> children;
  for (const std::int32_t t : component.tets) {
    const auto conflict = std::ranges::lower_bound(d.conflicts, TissueInTet{t, TissueId(0)});
    if (conflict != d.conflicts.end() && conflict->tet == t) continue;
    const auto m = std::ranges::lower_bound(d.mixed, t);
    if (m == d.mixed.end() || *m != t) {
      volume += mesh::signedVolume(mesh, t);
      continue;
    }
    const auto i = static_cast<std::int32_t>(m - d.mixed.begin());
    children.clear();
    if (d.complexOf[toIndex(i)] >= 0) {
      splitCells(mesh.T, d, d.complexOf[toIndex(i)], children);
    } else {
      splitTwoOwners(mesh.T, d, i, children);
    }
    for (const SubTet& child : children) {
      if (child.column != component.column) continue;
      volume += mesh::signedVolume(place(child.vertex[0]), place(child.vertex[1]),
                                   place(child.vertex[2]), place(child.vertex[3]));
    }
  }
  return volume;
}

/// What is struck so far, and what was admitted again.
class Strikes {
 public:
  Strikes(const mesh::TetMesh& mesh, const mesh::TetNeighbours& neighbours, std::int32_t fieldCount,
          bool fatIsCandidate)
      : mesh_(mesh), neighbours_(neighbours), candidates_(fieldCount - (fatIsCandidate ? 0 : 1)) {}

  [[nodiscard]] std::vector<TissueInTet> list() const { return {struck_.begin(), struck_.end()}; }

  /// False, and nothing done, where some tet would be left without any tissue, or the tissue is
  /// admitted there for good.
  bool strike(std::int32_t column, std::span<const std::int32_t> tets) {
    const TissueId tissue(column + kFat.value);
    for (const std::int32_t t : tets) {
      if (struck_.contains({t, tissue})) continue;
      if (pinned_.contains({t, tissue})) return false;
      const auto begin = struck_.lower_bound({t, TissueId(0)});
      const auto end = struck_.lower_bound({t + 1, TissueId(0)});
      if (std::distance(begin, end) + 1 >= candidates_) return false;
    }
    for (const std::int32_t t : tets) struck_.insert({t, tissue});
    return true;
  }

  /// Every (tet, tissue) is admitted again once, with all that hangs together with it; then struck
  /// around for good, or admitted for good where that cannot be. So this comes to an end.
  void settle(const TissueInTet& conflict) {
    if (!struck_.contains(conflict)) return;  // with another conflict
    if (!readmitted_.contains(conflict)) {
      readmit(conflict);
    } else if (!strike(conflict.tissue.value - kFat.value, tetsAround(conflict.tet))) {
      struck_.erase(conflict);
      pinned_.insert(conflict);
    }
  }

 private:
  void readmit(const TissueInTet& first) {
    std::vector<TissueInTet> front{first};
    while (!front.empty()) {
      const TissueInTet here = front.back();
      front.pop_back();
      if (!struck_.contains(here) || !readmitted_.insert(here).second) continue;
      struck_.erase(here);
      for (int k = 0; k < 4; ++k) {
        if (const std::int32_t u = neighbours_(here.tet, k); u >= 0)
          front.push_back({u, here.tissue});
      }
    }
  }

  std::vector<std::int32_t> tetsAround(std::int32_t tet) {
    if (around_.first.empty()) around_ = mesh::vertexTets(mesh_.T, mesh_.V.rows());
    std::vector<std::int32_t> tets;
    for (int c = 0; c < 4; ++c) {
      const std::size_t v = toIndex(mesh_.T(tet, c));
      tets.insert(tets.end(), around_.tet.begin() + around_.first[v],
                  around_.tet.begin() + around_.first[v + 1]);
    }
    return tets;
  }

  const mesh::TetMesh& mesh_;
  const mesh::TetNeighbours& neighbours_;
  std::int32_t candidates_;
  std::set<TissueInTet> struck_;
  std::set<TissueInTet> readmitted_;
  std::set<TissueInTet> pinned_;  ///< admitted for good
  mesh::VertexTets around_;       ///< made when it is first asked for
};

}  // namespace

std::vector<TissueInTet> curveTets(const tissue::CoreSamples& cores) {
  std::vector<TissueInTet> seeds;
  for (const tissue::CoreSample& sample : cores.samples)
    seeds.push_back({sample.tet, sample.tissue});
  std::ranges::sort(seeds);
  seeds.erase(std::unique(seeds.begin(), seeds.end()), seeds.end());
  return seeds;
}

Result<Islands> strikeIslands(const mesh::TetMesh& mesh, const mesh::TetNeighbours& neighbours,
                              const tissue::FieldMatrix& fields, bool fatIsCandidate,
                              std::span<const TissueInTet> seeds, RunContext& run) {
  const auto fieldCount = static_cast<std::int32_t>(fields.cols());
  Islands out;
  out.volume.assign(toIndex(fieldCount) + 1, 0.0);
  Strikes strikes(mesh, neighbours, fieldCount, fatIsCandidate);
  std::vector<std::uint8_t> shown(toIndex(fieldCount), 0);  // owned something at first
  constexpr int kRounds = 1000;
  for (int round = 0; round < kRounds; ++round) {
    out.struck = strikes.list();
    auto diagram = computeDiagram(mesh.T, fields,
                                  Candidates(mesh.T, fieldCount, fatIsCandidate, out.struck), run);
    if (!diagram) return passOn(diagram);

    const auto components = CellGraph(mesh.T, neighbours, *diagram).components(seeds);
    std::int64_t fatParts = 0;
    std::int64_t kept = 0;
    std::int64_t struckNow = 0;
    std::vector<std::uint8_t> left(toIndex(fieldCount), 0);
    std::optional<Placement> placement;
    for (const auto& component : components) {
      shown[toIndex(component.column)] = 1;
      fatParts += component.column == 0;
      if (component.column == 0 || component.seeded) {
        left[toIndex(component.column)] = 1;
      } else if (strikes.strike(component.column, component.tets)) {
        if (!placement) placement = placeNames(mesh.T, fields, *diagram, std::nullopt);
        out.volume[toIndex(component.column) + 1] +=
            volumeOf(mesh, *diagram, *placement, component);
        ++struckNow;
      } else {
        ++kept;
        left[toIndex(component.column)] = 1;
      }
    }
    out.count += struckNow;
    if (struckNow > 0) continue;
    if (!diagram->conflicts.empty()) {
      for (const TissueInTet& conflict : diagram->conflicts) strikes.settle(conflict);
      continue;
    }

    out.fatPockets = std::max<std::int64_t>(0, fatParts - 1);
    out.kept = kept;
    for (std::int32_t column = 1; column < fieldCount; ++column) {
      if (shown[toIndex(column)] && !left[toIndex(column)])
        out.lost.emplace_back(column + kFat.value);
    }
    out.diagram = std::move(*diagram);
    return out;
  }
  return fail(ErrorCode::Internal, "islands: no end of them; please report this project");
}

}  // namespace ecorche::envelope
