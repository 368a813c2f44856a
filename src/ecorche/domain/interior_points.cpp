#include <ecorche/core/parallel.h>
#include <ecorche/domain/interior_points.h>
#include <ecorche/domain/point_grid.h>
#include <ecorche/domain/triangle_tree.h>
#include <ecorche/mesh/surface_query.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>

namespace ecorche::domain {

using mesh::Vector3;

namespace {

// A body-centred cell of side a has edges a and a·√3/2; their mean over a tet is about 0.92 a
constexpr double kMeanEdgeOfCell = 0.92;
constexpr double kTetsPerCell = 12.0;
// Measured on an arm and a hind limb of 60 k, 200 k and 640 k tets: the lattice keeps away from
// walls, and walls stay finer than asked for where they bend
constexpr double kShareOfVolume = 0.73;
constexpr double kTetsPerWallArea = 4.6;  // in squares of the wanted length
constexpr double kTetsPerPoint = 6.1;
constexpr double kTetsPerWallFace = 2.1;
constexpr double kClaim = 0.72;      // of the cell: no two points nearer (the lattice's own: 0.866)
constexpr double kFromWalls = 0.5;   // of the cell: no point nearer to a wall
constexpr double kFirstLayer = 0.7;  // of the cell: seeds start this far from the wall

double halton(std::int64_t i, int base) {
  double f = 1.0;
  double r = 0.0;
  for (; i > 0; i /= base) {
    f /= base;
    r += f * static_cast<double>(i % base);
  }
  return r;
}

class Growth {
 public:
  Growth(const TaggedSurface& walls, const SizingField& sizing, double scale)
      : walls_(walls),
        sizing_(sizing),
        scale_(scale),
        box_(mesh::boundingBox(walls.V)),
        tree_(walls.V, walls.F),
        grid_(1 << 16) {
    for (int k = 0; k < 8; ++k) {
      steps_.push_back(0.5 * Vector3((k & 1) ? 1 : -1, (k & 2) ? 1 : -1, (k & 4) ? 1 : -1));
    }
    for (int k = 0; k < 3; ++k) {
      steps_.push_back(Vector3::Unit(k));
      steps_.push_back(-Vector3::Unit(k));
    }
    claimWalls();
  }

  mesh::Positions operator()() {
    for (const Eigen::Index f : facesBySize()) {
      seedFrom(f);
      // Breadth first: the lattice stays whole around its seed
      for (; next_ < points_.size(); ++next_) {
        const Vector3 p = points_[next_];
        const double a = cell(p);
        for (const Vector3& step : steps_) propose(p, p + a * step);
      }
    }
    mesh::Positions out(static_cast<Eigen::Index>(points_.size()), 3);
    for (std::size_t i = 0; i < points_.size(); ++i) {
      out.row(static_cast<Eigen::Index>(i)) = points_[i].transpose();
    }
    return out;
  }

 private:
  double cell(const Vector3& p) const { return scale_ * sizing_.at(p) / kMeanEdgeOfCell; }
  Vector3 corner(Eigen::Index f, int k) const { return walls_.V.row(walls_.F(f, k)).transpose(); }

  void claimWalls() {
    for (Eigen::Index v = 0; v < walls_.V.rows(); ++v) {
      const Vector3 p = walls_.V.row(v).transpose();
      grid_.add(p, kClaim * cell(p));
    }
  }

  /// Coarse places first: the lattice is largest and most regular there.
  std::vector<Eigen::Index> facesBySize() const {
    std::vector<Eigen::Index> order(static_cast<std::size_t>(walls_.F.rows()));
    std::iota(order.begin(), order.end(), Eigen::Index{0});
    std::vector<double> size(order.size());
    for (const Eigen::Index f : order) size[static_cast<std::size_t>(f)] = cell(corner(f, 0));
    std::ranges::stable_sort(order, [&](Eigen::Index f, Eigen::Index g) {
      return size[static_cast<std::size_t>(f)] > size[static_cast<std::size_t>(g)];
    });
    return order;
  }

  void seedFrom(Eigen::Index f) {
    const Vector3 n = (corner(f, 1) - corner(f, 0)).cross(corner(f, 2) - corner(f, 0));
    if (!(n.norm() > 0.0)) return;
    const Vector3 middle = (corner(f, 0) + corner(f, 1) + corner(f, 2)) / 3.0;
    const Vector3 inward = -n.normalized();
    const double depth = kFirstLayer * cell(middle);
    // Off the face itself, which the ray starts on
    propose(middle + 1e-3 * depth * inward, middle + depth * inward);
  }

  void propose(const Vector3& from, const Vector3& p) {
    // Where walls cross the lattice may leak; it must not fill all of space then
    if ((p.array() < box_.lo.array()).any() || (p.array() > box_.hi.array()).any()) return;
    const double a = cell(p);
    if (grid_.taken(p, kClaim * a) || tree_.within(p, kFromWalls * a)) return;
    // From inside to here without crossing a wall: inside
    if (tree_.firstHit(from, p - from, 0.0, 1.0)) return;
    grid_.add(p, kClaim * a);
    points_.push_back(p);
  }

  const TaggedSurface& walls_;
  const SizingField& sizing_;
  double scale_;
  mesh::Box box_;
  TriangleTree tree_;
  PointGrid grid_;
  std::vector<Vector3> steps_;  // to the fourteen neighbours, in cells
  std::vector<Vector3> points_;
  std::size_t next_ = 0;
};

}  // namespace

TetEstimate::TetEstimate(const TaggedSurface& surface, const SizingField& sizing) {
  constexpr std::int64_t kSamples = 40000;
  const mesh::SurfaceQuery walls(surface.V, surface.F);
  std::vector<double> density(kSamples, 0.0);
  const Vector3 size = sizing.box().hi - sizing.box().lo;
  parallelFor(
      kSamples,
      [&](std::int64_t i) {
        const Vector3 p =
            sizing.box().lo +
            size.cwiseProduct(Vector3(halton(i + 1, 2), halton(i + 1, 3), halton(i + 1, 5)));
        if (!walls.inside(p)) return;
        density[static_cast<std::size_t>(i)] = 1.0 / latticeTetVolume(sizing.at(p));
      },
      256);
  double sum = 0.0;
  for (const double d : density) sum += d;
  perVolume_ = kShareOfVolume * sum / static_cast<double>(kSamples) * size.prod();
  for (Eigen::Index f = 0; f < surface.F.rows(); ++f) {
    const Vector3 a = surface.V.row(surface.F(f, 0)).transpose();
    const Vector3 b = surface.V.row(surface.F(f, 1)).transpose();
    const Vector3 c = surface.V.row(surface.F(f, 2)).transpose();
    const double length = sizing.at((a + b + c) / 3.0);
    perArea_ += kTetsPerWallArea * 0.5 * (b - a).cross(c - a).norm() / (length * length);
  }
}

double TetEstimate::tets(double scale) const {
  return perVolume_ / (scale * scale * scale) + perArea_ / (scale * scale);
}

double TetEstimate::scaleFor(double tets) const {
  // Falls with the scale: halve the bracket
  double lo = 0.0;
  double hi = std::cbrt(perVolume_ / tets) + std::sqrt(perArea_ / tets);
  for (int step = 0; step < 60; ++step) {
    const double middle = 0.5 * (lo + hi);
    (this->tets(middle) > tets ? lo : hi) = middle;
  }
  return hi;
}

double latticeTetVolume(double edge) {
  const double cell = edge / kMeanEdgeOfCell;
  return cell * cell * cell / kTetsPerCell;
}

double tetsOf(std::int64_t points, std::int64_t wallFaces) {
  return kTetsPerPoint * static_cast<double>(points) +
         kTetsPerWallFace * static_cast<double>(wallFaces);
}

mesh::Positions interiorPoints(const TaggedSurface& walls, const SizingField& sizing,
                               double scale) {
  return Growth(walls, sizing, scale)();
}

}  // namespace ecorche::domain
