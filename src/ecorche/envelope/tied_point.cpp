#include <ecorche/core/contract.h>
#include <ecorche/envelope/tied_point.h>
#include <gmpxx.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

// Letters: rows r are the tied fields i_0 … i_{N-1}, columns v the vertices, m another field.
//   A_rv = f_{i_r}(v) − f_m(v),   D = 1ᵀ adj(A) 1
// At the tied point λ all rows of A λ equal h = z − z_m, how far the tied fields stand above m, so
//   h = det A / D.
// D does not depend on m, nor on constants added to fields. With ε: det(A + e 1ᵀ) = det A + Σ_r e_r
// C_r, where C_r is det A with row r replaced by ones, e_r = ε_{i_r} − ε_m, and Σ_r C_r = D. So the
// coefficient of ε_m is −D ≠ 0 and the sign is always decided.

namespace ecorche::envelope {
namespace {

constexpr double kUnit = std::numeric_limits<double>::epsilon() / 2;
// Entries are differences (one rounding), products have at most four factors, sums at most 24 terms
// of which no partial sum sees more than 6 additions: 4 + 3 + 6 roundings; 32 leaves room.
constexpr double kDetBound = 32 * kUnit;
// Below this products may have lost digits to underflow: each loses at most 2⁻¹⁰⁷⁴ times its other
// factors, so entries must not be larger than kLargest for that.
constexpr double kUnderflow = 1e-290;
constexpr double kLargest = 1e6;

template <class Number, int N>
using Square = std::array<std::array<Number, N>, N>;

template <class Number, int N>
Square<Number, N - 1> minorOf(const Square<Number, N>& m, int row, int column) {
  Square<Number, N - 1> out;
  for (int r = 0, i = 0; r < N; ++r) {
    if (r == row) continue;
    for (int c = 0, j = 0; c < N; ++c) {
      if (c == column) continue;
      out[i][j++] = m[r][c];
    }
    ++i;
  }
  return out;
}

template <class Number, int N>
Number determinant(const Square<Number, N>& m) {
  if constexpr (N == 1) {
    return m[0][0];
  } else if constexpr (N == 2) {
    return m[0][0] * m[1][1] - m[0][1] * m[1][0];
  } else {
    Number sum = m[0][0] * determinant<Number, N - 1>(minorOf<Number, N>(m, 0, 0));
    for (int c = 1; c < N; ++c) {
      const Number term = m[0][c] * determinant<Number, N - 1>(minorOf<Number, N>(m, 0, c));
      if (c % 2) {
        sum -= term;
      } else {
        sum += term;
      }
    }
    return sum;
  }
}

/// Σ of the absolute values of all products in the determinant: what its error is proportional to.
template <int N>
double permanent(const Square<double, N>& m) {
  if constexpr (N == 1) {
    return std::abs(m[0][0]);
  } else {
    double sum = 0.0;
    for (int c = 0; c < N; ++c) {
      sum += std::abs(m[0][c]) * permanent<N - 1>(minorOf<double, N>(m, 0, c));
    }
    return sum;
  }
}

/// Whether a bound in kUnderflow holds for determinants of this matrix.
template <int N>
bool isModest(const Square<double, N>& m) {
  if constexpr (N == 2) return true;  // products of two factors lose 2⁻¹⁰⁷⁴ at most
  bool modest = true;
  for (const auto& row : m) {
    for (const double x : row) modest &= std::abs(x) <= kLargest;
  }
  return modest;
}

/// Sign of a determinant of rounded differences, 0 where rounding may have decided it.
template <int N>
int certainSign(const Square<double, N>& m) {
  if (!isModest<N>(m)) return 0;
  const double det = determinant<double, N>(m);
  if (std::abs(det) > kDetBound * permanent<N>(m) + kUnderflow) return det > 0 ? 1 : -1;
  return 0;
}

/// Values of fields at the vertices as integers: all times the same power of two.
template <int N>
std::vector<std::array<mpz_class, N>> asIntegers(const FieldMatrix& fields,
                                                 const std::array<std::int32_t, N>& vertices,
                                                 std::span<const std::int32_t> columns) {
  int lowest = std::numeric_limits<int>::max();
  for (const std::int32_t c : columns) {
    for (const std::int32_t v : vertices) {
      int exponent = 0;
      if (std::frexp(fields(v, c), &exponent) != 0.0) lowest = std::min(lowest, exponent - 53);
    }
  }
  std::vector<std::array<mpz_class, N>> out(columns.size());
  for (std::size_t r = 0; r < columns.size(); ++r) {
    for (int v = 0; v < N; ++v) {
      int exponent = 0;
      const double mantissa = std::frexp(fields(vertices[v], columns[r]), &exponent);
      if (mantissa == 0.0) continue;
      out[r][v] = std::ldexp(mantissa, 53);
      out[r][v] <<= static_cast<mp_bitcnt_t>(exponent - 53 - lowest);
    }
  }
  return out;
}

/// Rows of D: ones, then f_{i_r} − f_{i_0}.
template <int N>
Square<double, N> differenceRows(const FieldMatrix& fields,
                                 const std::array<std::int32_t, N>& vertices,
                                 const std::array<std::int32_t, N>& columns) {
  Square<double, N> m;
  for (int v = 0; v < N; ++v) {
    m[0][v] = 1.0;
    for (int r = 1; r < N; ++r) {
      m[r][v] = fields(vertices[v], columns[r]) - fields(vertices[v], columns[0]);
    }
  }
  return m;
}

template <int N>
Square<mpz_class, N> exactDifferenceRows(const FieldMatrix& fields,
                                         const std::array<std::int32_t, N>& vertices,
                                         const std::array<std::int32_t, N>& columns) {
  const auto values = asIntegers<N>(fields, vertices, columns);
  Square<mpz_class, N> m;
  for (int v = 0; v < N; ++v) {
    m[0][v] = 1;
    for (int r = 1; r < N; ++r) m[r][v] = values[r][v] - values[0][v];
  }
  return m;
}

}  // namespace

template <int N>
TiedPoint<N>::TiedPoint(const FieldMatrix& fields, const Indices& vertices, const Indices& columns)
    : fields_(fields),
      vertices_(vertices),
      columns_(columns),
      sign_(certainSign<N>(differenceRows<N>(fields, vertices, columns))) {
  if (sign_ == 0) {
    sign_ = sgn(determinant<mpz_class, N>(exactDifferenceRows<N>(fields, vertices, columns)));
  }
  EC_ASSERT(sign_ != 0, "fields are parallel where they should cross");
}

template <int N>
bool TiedPoint<N>::isBelow(std::int32_t column) const {
  Square<double, N> a;
  for (int r = 0; r < N; ++r) {
    for (int v = 0; v < N; ++v) {
      a[r][v] = fields_(vertices_[v], columns_[r]) - fields_(vertices_[v], column);
    }
  }
  int side = certainSign<N>(a);
  if (side == 0) side = exactSide(column);
  return side * sign_ < 0;
}

template <int N>
int TiedPoint<N>::exactSide(std::int32_t column) const {
  std::array<std::int32_t, N + 1> all;
  std::copy(columns_.begin(), columns_.end(), all.begin());
  all[N] = column;
  const auto values = asIntegers<N>(fields_, vertices_, all);
  Square<mpz_class, N> a;
  for (int r = 0; r < N; ++r) {
    for (int v = 0; v < N; ++v) a[r][v] = values[r][v] - values[N][v];
  }
  if (const int side = sgn(determinant<mpz_class, N>(a)); side != 0) return side;

  // A tie: the field with the largest ε whose coefficient is not zero decides
  std::array<int, N + 1> order;
  for (int r = 0; r <= N; ++r) order[r] = r;
  std::sort(order.begin(), order.end(),
            [&](int x, int y) { return tieRank(all[x]) < tieRank(all[y]); });
  for (const int r : order) {
    if (r == N) return -sign_;
    Square<mpz_class, N> ones = a;
    for (int v = 0; v < N; ++v) ones[r][v] = 1;
    if (const int side = sgn(determinant<mpz_class, N>(ones)); side != 0) return side;
  }
  return -sign_;
}

template <int N>
std::array<double, N> TiedPoint<N>::barycentric() const {
  // λ_v is the cofactor of the v-th one in the first row of D's matrix, over D
  const auto rows = differenceRows<N>(fields_, vertices_, columns_);
  std::array<double, N> weight;
  double sum = 0.0;
  double size = 0.0;
  for (int v = 0; v < N; ++v) {
    const auto rest = minorOf<double, N>(rows, 0, v);
    weight[v] = (v % 2 ? -1.0 : 1.0) * determinant<double, N - 1>(rest);
    sum += weight[v];
    size += permanent<N - 1>(rest);
  }
  constexpr double kAccuracy = 1e-11;
  if (isModest<N>(rows) && kDetBound * size + kUnderflow < kAccuracy * std::abs(sum)) {
    for (double& w : weight) w /= sum;
    return weight;
  }
  const auto exact = exactDifferenceRows<N>(fields_, vertices_, columns_);
  const mpz_class whole = determinant<mpz_class, N>(exact);
  for (int v = 0; v < N; ++v) {
    mpz_class part = determinant<mpz_class, N - 1>(minorOf<mpz_class, N>(exact, 0, v));
    if (v % 2) part = -part;
    mpq_class share(part, whole);
    share.canonicalize();
    weight[v] = share.get_d();
  }
  return weight;
}

int fieldsNotBelowCrossing(const FieldMatrix& fields, std::int32_t a, std::int32_t b,
                           std::int32_t i, std::int32_t j, std::int32_t first) {
  // The 2×2 case of TiedPoint for all fields at once, free of branches. D > 0 because i is on top
  // at a and j at b
  const double* fa = fields.data() + static_cast<std::ptrdiff_t>(a) * fields.cols();
  const double* fb = fields.data() + static_cast<std::ptrdiff_t>(b) * fields.cols();
  const double ia = fa[i], ib = fb[i], ja = fa[j], jb = fb[j];
  int count = 0;
  const auto columns = static_cast<std::int32_t>(fields.cols());
  for (std::int32_t k = first; k < columns; ++k) {
    const double p = (ia - fa[k]) * (jb - fb[k]);
    const double q = (ib - fb[k]) * (ja - fa[k]);
    count += !(p - q > kDetBound * (std::abs(p) + std::abs(q)) + kUnderflow);
  }
  return count;
}

template class TiedPoint<2>;
template class TiedPoint<3>;
template class TiedPoint<4>;

}  // namespace ecorche::envelope
