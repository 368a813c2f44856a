#include <ecorche/mesh/tips.h>

#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <numeric>
#include <vector>

namespace ecorche::mesh {

namespace {

constexpr double kShare = 0.05;  // of the shortest edge

struct Around {
  Vector3 edges = Vector3::Zero();  // their sum
  double shortest = std::numeric_limits<double>::infinity();
  int count = 0;
};

/// Vertices that share their place with another.
std::vector<std::int32_t> coincident(const Positions& V) {
  std::vector<std::int32_t> order(static_cast<std::size_t>(V.rows()));
  std::iota(order.begin(), order.end(), 0);
  const auto place = [&](std::int32_t v) { return std::array{V(v, 0), V(v, 1), V(v, 2)}; };
  std::ranges::sort(order, {}, place);
  std::vector<std::int32_t> out;
  for (std::size_t i = 0; i < order.size(); ++i) {
    const bool before = i > 0 && place(order[i - 1]) == place(order[i]);
    const bool after = i + 1 < order.size() && place(order[i + 1]) == place(order[i]);
    if (before || after) out.push_back(order[i]);
  }
  return out;
}

}  // namespace

Eigen::Index drawTipsApart(Positions& V, const Triangles& F) {
  std::map<std::int32_t, Around> tips;
  for (const std::int32_t v : coincident(V)) tips.try_emplace(v);
  if (tips.empty()) return 0;
  for (Eigen::Index f = 0; f < F.rows(); ++f) {
    for (int k = 0; k < 3; ++k) {
      const auto tip = tips.find(F(f, k));
      if (tip == tips.end()) continue;
      // Each neighbour follows the tip in one face
      const Vector3 edge = (V.row(F(f, (k + 1) % 3)) - V.row(F(f, k))).transpose();
      tip->second.edges += edge;
      tip->second.shortest = std::min(tip->second.shortest, edge.norm());
      ++tip->second.count;
    }
  }
  for (const auto& [v, around] : tips) {
    const double length = around.edges.norm();
    if (around.count == 0 || !(length > 0.0)) continue;
    V.row(v) += kShare * around.shortest / length * around.edges.transpose();
  }
  return static_cast<Eigen::Index>(tips.size());
}

}  // namespace ecorche::mesh
