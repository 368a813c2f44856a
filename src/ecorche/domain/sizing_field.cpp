#include <ecorche/core/parallel.h>
#include <ecorche/domain/sizing_field.h>
#include <ecorche/domain/triangle_tree.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace ecorche::domain {

using mesh::Vector3;

SizingField::SizingField(const mesh::Box& box, const std::vector<WantedLength>& sources,
                         double coarsest, double gradation)
    : box_(box) {
  constexpr double kCellsAlong = 144.0;
  cell_ = (box.hi - box.lo).maxCoeff() / kCellsAlong;
  count_ = ((box.hi - box.lo) / cell_).array().ceil().cast<int>() + 2;
  value_.assign(static_cast<std::size_t>(count_.cast<std::int64_t>().prod()), coarsest);

  // Each source speaks for the eight grid points around it, its distance to them counted
  for (const WantedLength& source : sources) {
    const Eigen::Array3d at = (source.point - box_.lo).array() / cell_;
    const Eigen::Array3i low = at.floor().cast<int>().max(0).min(count_ - 2);
    for (int corner = 0; corner < 8; ++corner) {
      const Eigen::Array3i p = low + Eigen::Array3i(corner & 1, corner >> 1 & 1, corner >> 2 & 1);
      const double far = ((p.cast<double>() - at).matrix().norm()) * cell_;
      double& value = value_[slot(p.x(), p.y(), p.z())];
      // Within half a cell the source's own length holds: the grid cannot tell such places apart
      value = std::min(value, source.length + gradation * std::max(0.0, far - cell_));
    }
  }
  spread(gradation);
}

// Chamfer sweeps in both directions: lengths may grow by the gradation per metre
void SizingField::spread(double gradation) {
  struct Step {
    int x, y, z;
    double rise;
  };
  std::vector<Step> steps;
  for (int z = -1; z <= 0; ++z) {
    for (int y = -1; y <= 1; ++y) {
      for (int x = -1; x <= 1; ++x) {
        const bool before = z < 0 || (z == 0 && (y < 0 || (y == 0 && x < 0)));
        if (before)
          steps.push_back({x, y, z, gradation * cell_ * std::sqrt(x * x + y * y + z * z)});
      }
    }
  }
  const auto visit = [&](int x, int y, int z, int sign) {
    double& here = value_[slot(x, y, z)];
    for (const Step& s : steps) {
      const int a = x + sign * s.x;
      const int b = y + sign * s.y;
      const int c = z + sign * s.z;
      if (a < 0 || b < 0 || c < 0 || a >= count_.x() || b >= count_.y() || c >= count_.z())
        continue;
      here = std::min(here, value_[slot(a, b, c)] + s.rise);
    }
  };
  for (int z = 0; z < count_.z(); ++z) {
    for (int y = 0; y < count_.y(); ++y) {
      for (int x = 0; x < count_.x(); ++x) visit(x, y, z, 1);
    }
  }
  for (int z = count_.z() - 1; z >= 0; --z) {
    for (int y = count_.y() - 1; y >= 0; --y) {
      for (int x = count_.x() - 1; x >= 0; --x) visit(x, y, z, -1);
    }
  }
}

double SizingField::at(const Vector3& p) const {
  const Eigen::Array3d q =
      ((p - box_.lo).array() / cell_).max(0.0).min((count_ - 1).cast<double>() - 1e-9);
  const Eigen::Array3i low = q.floor().cast<int>().min(count_ - 2);
  const Eigen::Array3d t = q - low.cast<double>();
  double sum = 0.0;
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Array3i bit(corner & 1, corner >> 1 & 1, corner >> 2 & 1);
    const Eigen::Array3i c = low + bit;
    double weight = 1.0;
    for (int k = 0; k < 3; ++k) weight *= bit[k] != 0 ? t[k] : 1.0 - t[k];
    sum += weight * value_[slot(c.x(), c.y(), c.z())];
  }
  return sum;
}

void SizingField::write(ByteWriter& out) const {
  out.matrix(box_.lo);
  out.matrix(box_.hi);
  out.matrix(count_);
  out.value(cell_);
  out.matrix(
      Eigen::Map<const Eigen::VectorXd>(value_.data(), static_cast<Eigen::Index>(value_.size())));
}

SizingField SizingField::read(ByteReader& in) {
  SizingField field;
  field.box_.lo = in.matrix<Vector3>();
  field.box_.hi = in.matrix<Vector3>();
  field.count_ = in.matrix<Eigen::Array3i>();
  field.cell_ = in.value<double>();
  const auto values = in.matrix<Eigen::VectorXd>();
  field.value_.assign(values.data(), values.data() + values.size());
  const bool sane = field.box_.lo.allFinite() && field.box_.hi.allFinite() &&
                    std::isfinite(field.cell_) && (field.count_ >= 2).all() &&
                    (field.count_ < (1 << 20)).all() &&
                    field.count_.cast<std::int64_t>().prod() == values.size() && field.cell_ > 0.0;
  if (!sane) in.reject();
  return field;
}

std::vector<WantedLength> lengthsInGaps(const TaggedSurface& walls, double finest,
                                        double coarsest) {
  // From every wall straight in to the next wall
  const TriangleTree tree(walls.V, walls.F);
  std::vector<WantedLength> gaps(static_cast<std::size_t>(walls.F.rows()));
  parallelFor(
      walls.F.rows(),
      [&](std::int64_t f) {
        const Vector3 a = walls.V.row(walls.F(f, 0)).transpose();
        const Vector3 b = walls.V.row(walls.F(f, 1)).transpose();
        const Vector3 c = walls.V.row(walls.F(f, 2)).transpose();
        const Vector3 n = (b - a).cross(c - a);
        const double twice = n.norm();
        if (!(twice > 0.0)) return;
        const Vector3 from = (a + b + c) / 3.0;
        const Vector3 inward = -n / twice;
        const auto hit = tree.firstHit(from, inward, 1e-3 * finest, 3.0 * coarsest);
        // Three tets from wall to wall
        if (hit && *hit < 3.0 * coarsest) {
          gaps[static_cast<std::size_t>(f)] = {from + 0.5 * *hit * inward,
                                               std::clamp(*hit / 3.0, finest, coarsest)};
        }
      },
      256);
  std::erase_if(gaps, [](const WantedLength& gap) { return !(gap.length > 0.0); });
  return gaps;
}

}  // namespace ecorche::domain
