#include <ecorche/core/parallel.h>
#include <ecorche/domain/interior_points.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <set>

namespace ecorche::domain {

using mesh::Vector3;

namespace {

// A body-centred cell of side a has edges a and a·√3/2; their mean over a tet is about 0.92 a
constexpr double kMeanEdgeOfCell = 0.92;
constexpr double kTetsPerCell = 12.0;

double halton(std::int64_t i, int base) {
  double f = 1.0;
  double r = 0.0;
  for (; i > 0; i /= base) {
    f /= base;
    r += f * static_cast<double>(i % base);
  }
  return r;
}

}  // namespace

TetEstimate::TetEstimate(const mesh::SurfaceQuery& walls, const SizingField& sizing) {
  constexpr std::int64_t kSamples = 40000;
  std::vector<double> density(kSamples, 0.0);
  const Vector3 size = sizing.box().hi - sizing.box().lo;
  parallelFor(
      kSamples,
      [&](std::int64_t i) {
        const Vector3 p =
            sizing.box().lo +
            size.cwiseProduct(Vector3(halton(i + 1, 2), halton(i + 1, 3), halton(i + 1, 5)));
        if (!walls.inside(p)) return;
        const double cell = sizing.at(p) / kMeanEdgeOfCell;
        density[static_cast<std::size_t>(i)] = kTetsPerCell / (cell * cell * cell);
      },
      256);
  double sum = 0.0;
  for (const double d : density) sum += d;
  perCubedScale_ = sum / static_cast<double>(kSamples) * size.prod();
}

double TetEstimate::tets(double scale) const { return perCubedScale_ / (scale * scale * scale); }

double TetEstimate::scaleFor(double tets) const { return std::cbrt(perCubedScale_ / tets); }

mesh::Positions interiorPoints(const mesh::SurfaceQuery& walls, const SizingField& sizing,
                               double scale) {
  // Octree over the box; coordinates in half-cells of the finest level, so that shared corners are
  // one point
  constexpr int kDeepest = 12;
  const Vector3 lo = sizing.box().lo;
  const double root = (sizing.box().hi - lo).maxCoeff() * 1.0001;
  const double unit = root / static_cast<double>(1 << (kDeepest + 1));
  struct Node {
    std::array<std::int32_t, 3> at;  // lower corner [units]
    int level;
  };
  std::vector<Node> stack{{{0, 0, 0}, 0}};
  std::set<std::array<std::int32_t, 3>> points;
  while (!stack.empty()) {
    const Node node = stack.back();
    stack.pop_back();
    const std::int32_t side = 1 << (kDeepest + 1 - node.level);
    const Vector3 low = lo + unit * Vector3(node.at[0], node.at[1], node.at[2]);
    if ((low.array() > sizing.box().hi.array()).any()) continue;
    const Vector3 centre = low + 0.5 * side * unit * Vector3::Ones();
    const double wanted = scale * sizing.at(centre) / kMeanEdgeOfCell;
    // Cells come in powers of two: √2 above and below the wanted length even out
    if (side * unit > std::numbers::sqrt2 * wanted && node.level < kDeepest) {
      const std::int32_t half = side / 2;
      for (int c = 0; c < 8; ++c) {
        stack.push_back({{node.at[0] + (c & 1) * half, node.at[1] + (c >> 1 & 1) * half,
                          node.at[2] + (c >> 2 & 1) * half},
                         node.level + 1});
      }
      continue;
    }
    for (int c = 0; c < 8; ++c) {
      points.insert({node.at[0] + (c & 1) * side, node.at[1] + (c >> 1 & 1) * side,
                     node.at[2] + (c >> 2 & 1) * side});
    }
    points.insert({node.at[0] + side / 2, node.at[1] + side / 2, node.at[2] + side / 2});
  }

  const std::vector<std::array<std::int32_t, 3>> all(points.begin(), points.end());
  std::vector<std::uint8_t> keep(all.size(), 0);
  const auto place = [&](std::size_t i) {
    return Vector3(lo + unit * Vector3(all[i][0], all[i][1], all[i][2]));
  };
  parallelFor(
      static_cast<std::int64_t>(all.size()),
      [&](std::int64_t i) {
        const Vector3 p = place(static_cast<std::size_t>(i));
        if ((p.array() > sizing.box().hi.array()).any()) return;
        if (walls.distance(p) < 0.55 * scale * sizing.at(p)) return;
        keep[static_cast<std::size_t>(i)] = walls.inside(p) ? 1 : 0;
      },
      256);
  mesh::Positions out(std::count(keep.begin(), keep.end(), 1), 3);
  Eigen::Index row = 0;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (keep[i] != 0) out.row(row++) = place(i).transpose();
  }
  return out;
}

}  // namespace ecorche::domain
