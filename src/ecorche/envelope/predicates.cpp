#include <CGAL/MP_Float.h>
#include <ecorche/core/contract.h>
#include <ecorche/envelope/predicates.h>

#include <cmath>

namespace ecorche::envelope {

namespace {

// n×n determinant by expansion along the first row, n ≤ 4; rows are given by pointers so that one
// can be swapped
template <class Number>
Number determinant(const std::array<const Number*, 4>& rows, int n, int first, unsigned used) {
  if (n == 0) return Number(1);
  Number sum(0);
  bool plus = true;
  for (int c = 0; c < 4; ++c) {
    if ((used >> c & 1U) != 0U) continue;
    const Number& a = rows[static_cast<std::size_t>(first)][c];
    if (!(a == Number(0))) {
      const Number minor = determinant<Number>(rows, n - 1, first + 1, used | 1U << c);
      if (plus) {
        sum = sum + a * minor;
      } else {
        sum = sum - a * minor;
      }
    }
    plus = !plus;
  }
  return sum;
}

// The same with all signs plus, over absolute values: bounds the rounding error of the double
// determinant
double permanent(const std::array<const double*, 4>& rows, int n, int first, unsigned used) {
  if (n == 0) return 1.0;
  double sum = 0.0;
  for (int c = 0; c < 4; ++c) {
    if ((used >> c & 1U) != 0U) continue;
    const double a = std::abs(rows[static_cast<std::size_t>(first)][c]);
    if (a != 0.0) sum += a * permanent(rows, n - 1, first + 1, used | 1U << c);
  }
  return sum;
}

// Rows g, D_1 … D_{k}, and a row of ones, as doubles (each entry rounded once) and, on demand,
// exactly.
class Rows {
 public:
  Rows(const CornerFields& f, const MeetingPoint& p, std::int32_t m) : f_(f), p_(p), m_(m) {
    n_ = p.count;
    fill(0, m);
    for (int r = 1; r < n_; ++r) fill(r, p.fields[static_cast<std::size_t>(r)]);
    for (int c = 0; c < n_; ++c) entry_[4][c] = 1.0;
    unused_ = 0xFU & ~((1U << n_) - 1U);
  }

  // Sign of the determinant of the given rows (4: ones), exact
  [[nodiscard]] int sign(const std::array<int, 4>& which) {
    std::array<const double*, 4> rows{};
    for (int r = 0; r < n_; ++r)
      rows[static_cast<std::size_t>(r)] = entry_[which[static_cast<std::size_t>(r)]];
    const double bound = permanent(rows, n_, 0, unused_);
    if (bound == 0.0)
      return 0;  // a row of exact zeros, or no full transversal: products all vanish exactly
    const double d = determinant<double>(rows, n_, 0, unused_);
    // Each entry carries one rounding, each product at most three, each sum at most three: 32 u is
    // ample
    constexpr double kError = 32.0 * 1.1102230246251565e-16;
    if (bound > 1e-250 && std::abs(d) > kError * bound) return d > 0.0 ? 1 : -1;
    return exactSign(which);
  }

 private:
  const CornerFields& f_;
  const MeetingPoint& p_;
  std::int32_t m_;
  int n_ = 0;
  unsigned unused_ = 0;
  double entry_[5][4]{};

  void fill(int r, std::int32_t column) {
    for (int c = 0; c < n_; ++c) {
      const int corner = p_.corners[static_cast<std::size_t>(c)];
      entry_[r][c] = f_.value(corner, column) - f_.value(corner, p_.fields[0]);
    }
  }

  [[nodiscard]] int exactSign(const std::array<int, 4>& which) const {
    using Exact = CGAL::MP_Float;
    Exact entry[5][4];
    for (int r = 0; r < n_; ++r) {
      const std::int32_t column = r == 0 ? m_ : p_.fields[static_cast<std::size_t>(r)];
      for (int c = 0; c < n_; ++c) {
        const int corner = p_.corners[static_cast<std::size_t>(c)];
        entry[r][c] = Exact(f_.value(corner, column)) - Exact(f_.value(corner, p_.fields[0]));
      }
    }
    for (int c = 0; c < n_; ++c) entry[4][c] = Exact(1);
    std::array<const Exact*, 4> rows{};
    for (int r = 0; r < n_; ++r)
      rows[static_cast<std::size_t>(r)] = entry[which[static_cast<std::size_t>(r)]];
    const Exact d = determinant<Exact>(rows, n_, 0, unused_);
    return static_cast<int>(CGAL::sign(d));
  }
};

}  // namespace

int signAbove(const CornerFields& f, const MeetingPoint& point, std::int32_t m) {
  const int n = point.count;
  if (n == 1) {
    const double a = f.value(point.corners[0], m);
    const double b = f.value(point.corners[0], point.fields[0]);
    if (a != b) return a > b ? 1 : -1;
    return comesFirst(m, point.fields[0]) ? 1 : -1;
  }

  Rows rows(f, point, m);
  std::array<int, 4> which{0, 1, 2, 3};
  std::array<int, 4> ones = which;
  ones[0] = 4;
  const int scale = rows.sign(ones);  // det[1; D]
  EC_ASSERT(scale != 0, "fields that meet nowhere");
  if (const int raw = rows.sign(which); raw != 0) return raw * scale;

  // A tie: the ε of highest priority whose coefficient is not zero. Those of g and of the rows are
  // signs of single determinants; that of f_0 is minus the sum of all of them, which is the sum of
  // all rows' replacements.
  std::array<std::int32_t, 5> order{};
  for (int r = 0; r < n; ++r)
    order[static_cast<std::size_t>(r)] = point.fields[static_cast<std::size_t>(r)];
  order[static_cast<std::size_t>(n)] = m;
  for (int a = 1; a <= n; ++a) {  // insertion sort by priority
    for (int b = a; b > 0 && comesFirst(order[static_cast<std::size_t>(b)],
                                        order[static_cast<std::size_t>(b - 1)]);
         --b) {
      std::swap(order[static_cast<std::size_t>(b)], order[static_cast<std::size_t>(b - 1)]);
    }
  }
  for (int k = 0; k <= n; ++k) {
    const std::int32_t field = order[static_cast<std::size_t>(k)];
    if (field == m) return 1;  // coefficient det[1; D]: its sign times scale
    // Coefficient of ε_field is minus the barycentric-like weight of that field in g's affine
    // combination. Taking field as the base of the differences makes it det[g'; D'] with the base's
    // own ε: the weights w of f_m − f = Σ w_i f_i with Σ w = 0 are the cofactors of the column of
    // ones.
    std::array<int, 4> replaced = which;
    int sign = 0;
    if (field != point.fields[0]) {
      for (int r = 1; r < n; ++r) {
        if (point.fields[static_cast<std::size_t>(r)] == field)
          replaced[static_cast<std::size_t>(r)] = 4;
      }
      sign = rows.sign(replaced);
    } else {
      // Swap the base: differences to another field of the meeting point leave the determinant as
      // it is but for sign
      MeetingPoint rotated = point;
      std::swap(rotated.fields[0], rotated.fields[1]);
      Rows other(f, rotated, m);
      std::array<int, 4> inOther{0, 4, 2, 3};
      std::array<int, 4> onesOther{4, 1, 2, 3};
      const int scaleOther = other.sign(onesOther);
      sign = other.sign(inOther) * scaleOther * scale;
    }
    if (sign != 0) return sign * scale;
  }
  return 1;  // not reached: the coefficient of m is det[1; D], which is not zero
}

std::array<double, 4> meetingWeights(const CornerFields& f, const MeetingPoint& point) {
  const int n = point.count;
  std::array<double, 4> w{};
  if (n == 1) {
    w[0] = 1.0;
    return w;
  }
  double D[3][4]{};
  for (int r = 1; r < n; ++r) {
    for (int c = 0; c < n; ++c) {
      const int corner = point.corners[static_cast<std::size_t>(c)];
      D[r - 1][c] = f.value(corner, point.fields[static_cast<std::size_t>(r)]) -
                    f.value(corner, point.fields[0]);
    }
  }
  double sum = 0.0;
  for (int v = 0; v < n; ++v) {
    std::array<const double*, 4> rows{};
    for (int r = 0; r + 1 < n; ++r) rows[static_cast<std::size_t>(r)] = D[r];
    const unsigned used = (0xFU & ~((1U << n) - 1U)) | 1U << v;
    const double minor = determinant<double>(rows, n - 1, 0, used);
    w[static_cast<std::size_t>(v)] = v % 2 == 0 ? minor : -minor;
    sum += w[static_cast<std::size_t>(v)];
  }
  if (sum == 0.0 || !std::isfinite(sum)) return {};
  for (double& x : w) x /= sum;
  return w;
}

}  // namespace ecorche::envelope
