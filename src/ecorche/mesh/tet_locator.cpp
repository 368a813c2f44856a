#include <ecorche/core/parallel.h>
#include <ecorche/mesh/operators.h>
#include <ecorche/mesh/tet_locator.h>

#include <algorithm>
#include <cmath>

namespace ecorche::mesh {

namespace {
constexpr double kInside = -1e-10;

struct CellRange {
  Eigen::Array3i lo;
  Eigen::Array3i hi;
};
}  // namespace

TetLocator::TetLocator(const TetMesh& mesh) : mesh_(mesh), box_(boundingBox(mesh.V)) {
  if (mesh.T.rows() == 0) return;

  // About two cells per tet of the box's share: bodies fill a small part of their box
  const Vector3 extent = (box_.hi - box_.lo).cwiseMax(1e-9 * box_.diagonal());
  const double cell = std::cbrt(extent.prod() / (0.5 * static_cast<double>(mesh.T.rows())));
  size_ = (extent.array() / cell).ceil().cast<int>().cwiseMax(1).cwiseMin(1024);
  perCell_ = size_.cast<double>() / extent.array();

  const auto tetCount = static_cast<std::size_t>(mesh.T.rows());
  std::vector<CellRange> ranges(tetCount);
  parallelFor(mesh.T.rows(), [&](std::int64_t t) {
    Box box;
    for (int k = 0; k < 4; ++k) box.add(mesh.V.row(mesh.T(t, k)).transpose());
    ranges[static_cast<std::size_t>(t)] = {cellOf(box.lo), cellOf(box.hi)};
  });

  // Count, add up, fill: tets come ascending
  first_.assign(static_cast<std::size_t>(size_.cast<std::int64_t>().prod()) + 1, 0);
  const auto forCells = [&](std::size_t t, const auto& visit) {
    const CellRange& r = ranges[t];
    for (int z = r.lo.z(); z <= r.hi.z(); ++z) {
      for (int y = r.lo.y(); y <= r.hi.y(); ++y) {
        for (int x = r.lo.x(); x <= r.hi.x(); ++x) visit(flat(x, y, z));
      }
    }
  };
  for (std::size_t t = 0; t < tetCount; ++t) forCells(t, [&](std::size_t c) { ++first_[c + 1]; });
  for (std::size_t c = 1; c < first_.size(); ++c) first_[c] += first_[c - 1];
  tet_.resize(static_cast<std::size_t>(first_.back()));
  std::vector<std::int64_t> next(first_.begin(), first_.end() - 1);
  for (std::size_t t = 0; t < tetCount; ++t) {
    forCells(t, [&](std::size_t c) {
      tet_[static_cast<std::size_t>(next[c]++)] = static_cast<std::int32_t>(t);
    });
  }
}

Eigen::Array3i TetLocator::cellOf(const Vector3& p) const {
  const Eigen::Array3d where = ((p - box_.lo).array() * perCell_.array()).floor();
  const Eigen::Array3d last = size_.cast<double>() - 1.0;
  return where.max(0.0).min(last).cast<int>();
}

std::size_t TetLocator::flat(int x, int y, int z) const {
  return (static_cast<std::size_t>(z) * static_cast<std::size_t>(size_.y()) +
          static_cast<std::size_t>(y)) *
             static_cast<std::size_t>(size_.x()) +
         static_cast<std::size_t>(x);
}

std::int32_t TetLocator::locate(const Vector3& p) const {
  if (tet_.empty() || !p.allFinite()) return -1;
  const Eigen::Array3i c = cellOf(p);
  const std::size_t cell = flat(c.x(), c.y(), c.z());
  std::int32_t best = -1;
  double deepest = kInside;
  for (std::int64_t i = first_[cell]; i < first_[cell + 1]; ++i) {
    const std::int32_t t = tet_[static_cast<std::size_t>(i)];
    const double depth = barycentric(mesh_, t, p).minCoeff();
    if (depth > deepest) {
      deepest = depth;
      best = t;
    }
  }
  return best;
}

}  // namespace ecorche::mesh
