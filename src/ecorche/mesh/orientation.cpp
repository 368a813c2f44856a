#include <ecorche/mesh/orientation.h>

#include <cmath>
#include <limits>
#include <vector>

namespace ecorche::mesh {

namespace {

// A sum of doubles that do not overlap, smallest first: the last one has the sign of the whole.
class Expansion {
 public:
  Expansion() = default;
  // a − b without rounding
  static Expansion difference(double a, double b) {
    Expansion e;
    e.add(a);
    e.add(-b);
    return e;
  }
  // Grow-expansion: the sum stays exact, zeros are dropped
  void add(double b) {
    std::size_t kept = 0;
    for (const double part : parts_) {
      const double sum = b + part;
      const double partOfSum = sum - b;
      const double error = (b - (sum - partOfSum)) + (part - partOfSum);
      if (error != 0.0) parts_[kept++] = error;
      b = sum;
    }
    parts_.resize(kept);
    if (b != 0.0) parts_.push_back(b);
  }
  void add(const Expansion& other, double sign) {
    for (const double part : other.parts_) add(sign * part);
  }
  [[nodiscard]] Expansion times(const Expansion& other) const {
    Expansion product;
    for (const double x : parts_) {
      for (const double y : other.parts_) {
        const double high = x * y;
        product.add(std::fma(x, y, -high));
        product.add(high);
      }
    }
    return product;
  }
  [[nodiscard]] int sign() const { return parts_.empty() ? 0 : parts_.back() > 0.0 ? 1 : -1; }

 private:
  std::vector<double> parts_;
};

int exactOrientation(const Vector3& a, const Vector3& b, const Vector3& c, const Vector3& d) {
  Expansion u[3];
  Expansion v[3];
  Expansion w[3];
  for (int k = 0; k < 3; ++k) {
    u[k] = Expansion::difference(b[k], a[k]);
    v[k] = Expansion::difference(c[k], a[k]);
    w[k] = Expansion::difference(d[k], a[k]);
  }
  Expansion determinant;
  for (int k = 0; k < 3; ++k) {
    const int l = (k + 1) % 3;
    const int m = (k + 2) % 3;
    Expansion minor = u[l].times(v[m]);
    minor.add(u[m].times(v[l]), -1.0);
    determinant.add(minor.times(w[k]), 1.0);
  }
  return determinant.sign();
}

}  // namespace

int orientation(const Vector3& a, const Vector3& b, const Vector3& c, const Vector3& d) {
  const Vector3 u = b - a;
  const Vector3 v = c - a;
  const Vector3 w = d - a;
  double determinant = 0.0;
  double permanent = 0.0;
  for (int k = 0; k < 3; ++k) {
    const int l = (k + 1) % 3;
    const int m = (k + 2) % 3;
    determinant += (u[l] * v[m] - u[m] * v[l]) * w[k];
    permanent += (std::abs(u[l] * v[m]) + std::abs(u[m] * v[l])) * std::abs(w[k]);
  }
  // Shewchuk's bound for this expression, (7 + 56ε)ε with ε half the machine's, rounded up
  constexpr double kBound = 8.0 * 0.5 * std::numeric_limits<double>::epsilon();
  if (determinant > kBound * permanent) return 1;
  if (determinant < -kBound * permanent) return -1;
  return exactOrientation(a, b, c, d);
}

int orientation(const TetMesh& mesh, Eigen::Index t) {
  return orientation(mesh.V.row(mesh.T(t, 0)).transpose(), mesh.V.row(mesh.T(t, 1)).transpose(),
                     mesh.V.row(mesh.T(t, 2)).transpose(), mesh.V.row(mesh.T(t, 3)).transpose());
}

}  // namespace ecorche::mesh
