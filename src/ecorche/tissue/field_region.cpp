#include <ecorche/core/contract.h>
#include <ecorche/tissue/field_region.h>

#include <algorithm>

namespace ecorche::tissue {

FieldRegion::FieldRegion(const TissueSolver& solver, const std::vector<std::uint8_t>& inside) {
  const mesh::TetMesh& all = solver.domain().mesh;
  const mesh::StiffnessPattern& of = solver.pattern();
  EC_REQUIRE_EQ(std::ssize(inside), of.rowCount());
  EC_REQUIRE(solver.symbolic() != nullptr);
  const auto rowAt = [&](Eigen::Index t, int k) {
    return of.row[static_cast<std::size_t>(all.T(t, k))];
  };
  const auto isInside = [&](std::int32_t r) {
    return r >= 0 && inside[static_cast<std::size_t>(r)] != 0;
  };

  // Tets with a corner inside, and those with nothing but skin around them, which no row sees but
  // curves may cross; vertices in their old order
  std::vector<std::int32_t> chosen;
  std::vector<std::int32_t> here(static_cast<std::size_t>(all.V.rows()), -1);
  std::vector<std::uint8_t> onRim(inside.size(), 0);
  tet.assign(static_cast<std::size_t>(all.T.rows()), -1);
  for (Eigen::Index t = 0; t < all.T.rows(); ++t) {
    bool in = false;
    bool out = false;
    for (int k = 0; k < 4; ++k) {
      const std::int32_t r = rowAt(t, k);
      (isInside(r) ? in : out) |= r >= 0;
    }
    if (!in && out) continue;
    tet[static_cast<std::size_t>(t)] = static_cast<std::int32_t>(chosen.size());
    chosen.push_back(static_cast<std::int32_t>(t));
    for (int k = 0; k < 4; ++k) {
      here[static_cast<std::size_t>(all.T(t, k))] = 0;
      if (out && isInside(rowAt(t, k))) onRim[static_cast<std::size_t>(rowAt(t, k))] = 1;
    }
  }
  std::vector<std::uint8_t> fixed;
  for (std::size_t v = 0; v < here.size(); ++v) {
    if (here[v] < 0) continue;
    here[v] = static_cast<std::int32_t>(vertex.size());
    vertex.push_back(static_cast<std::int32_t>(v));
    fixed.push_back(isInside(of.row[v]) ? 0 : 1);
  }
  EC_REQUIRE(std::ranges::find(inside, 1) != inside.end());
  mesh.V = all.V(vertex, Eigen::all);
  mesh.T.resize(std::ssize(chosen), 4);
  for (std::size_t t = 0; t < chosen.size(); ++t) {
    for (int k = 0; k < 4; ++k)
      mesh.T(static_cast<Eigen::Index>(t), k) = here[static_cast<std::size_t>(all.T(chosen[t], k))];
  }

  auto own = std::make_shared<mesh::StiffnessPattern>(mesh::stiffnessPattern(mesh, fixed));
  std::vector<std::int32_t> rowHere(inside.size(), -1);
  for (std::int32_t r = 0; r < own->rowCount(); ++r) {
    const std::int32_t v =
        vertex[static_cast<std::size_t>(own->vertex[static_cast<std::size_t>(r)])];
    row.push_back(of.row[static_cast<std::size_t>(v)]);
    rowHere[static_cast<std::size_t>(row.back())] = r;
    if (onRim[static_cast<std::size_t>(row.back())] != 0) rim.push_back(r);
  }
  // Rows keep their order, so that entries of a column do, too
  for (std::size_t r = 0; r < row.size(); ++r) {
    auto e = static_cast<std::size_t>(of.first[static_cast<std::size_t>(row[r])]);
    for (auto i = static_cast<std::size_t>(own->first[r]);
         i < static_cast<std::size_t>(own->first[r + 1]); ++i) {
      const std::int32_t wanted = row[static_cast<std::size_t>(own->index[i])];
      while (of.index[e] != wanted) ++e;
      slot.push_back(static_cast<std::int32_t>(e));
    }
  }
  whole_ = row.size() == inside.size();
  if (whole_) {
    symbolic = std::make_shared<const mesh::SymbolicCholesky>(*solver.symbolic());
  } else {
    std::vector<std::int32_t> order;
    for (const std::int32_t r : solver.symbolic()->order()) {
      if (rowHere[static_cast<std::size_t>(r)] >= 0)
        order.push_back(rowHere[static_cast<std::size_t>(r)]);
    }
    symbolic = std::make_shared<const mesh::SymbolicCholesky>(*own, order);
  }
  neighbours = std::make_shared<const mesh::NeighbourRows>(mesh::neighbourRows(*own));
  pattern = std::move(own);
}

std::vector<CoreSample> FieldRegion::within(const std::vector<CoreSample>& samples) const {
  std::vector<CoreSample> out;
  for (const CoreSample& s : samples) {
    const std::int32_t t = tet[static_cast<std::size_t>(s.tet)];
    if (t < 0) continue;
    out.push_back(s);
    out.back().tet = t;
  }
  return out;
}

std::vector<double> FieldRegion::gather(const std::vector<double>& values) const {
  std::vector<double> out;
  out.reserve(slot.size());
  for (const std::int32_t s : slot) out.push_back(values[static_cast<std::size_t>(s)]);
  return out;
}

}  // namespace ecorche::tissue
