#include <ecorche/envelope/tied_point.h>
#include <gmpxx.h>

#include <catch2/catch.hpp>
#include <random>

using namespace ecorche;
using envelope::TiedPoint;

namespace {

/// Whether column m is above the point at which the tied fields are equal, by solving the equations
/// with rational numbers and ε_i = 2^(−64·rank), far below every difference that is not 0 here.
template <int N>
std::optional<bool> belowByRationals(const tissue::FieldMatrix& fields,
                                     const std::array<std::int32_t, N>& vertices,
                                     const std::array<std::int32_t, N>& columns, std::int32_t m) {
  const auto value = [&](int v, std::int32_t column) -> mpq_class {
    const auto last = static_cast<std::int32_t>(fields.cols());
    const std::int32_t rank = column == 0 ? last : column;
    mpq_class epsilon(1);
    mpq_div_2exp(epsilon.get_mpq_t(), epsilon.get_mpq_t(), static_cast<mp_bitcnt_t>(64 * rank));
    return mpq_class(fields(vertices[static_cast<std::size_t>(v)], column)) + epsilon;
  };
  // Unknowns λ_0 … λ_{N−1}, z: Σ λ_v f_r(v) − z = 0, Σ λ = 1
  mpq_class a[N + 1][N + 2];
  for (int r = 0; r < N; ++r) {
    for (int v = 0; v < N; ++v) a[r][v] = value(v, columns[static_cast<std::size_t>(r)]);
    a[r][N] = -1;
    a[r][N + 1] = 0;
  }
  for (int v = 0; v < N; ++v) a[N][v] = 1;
  a[N][N] = 0;
  a[N][N + 1] = 1;
  for (int c = 0; c <= N; ++c) {
    int pivot = c;
    while (pivot <= N && a[pivot][c] == 0) ++pivot;
    if (pivot > N) return std::nullopt;  // parallel: no such point
    for (int k = 0; k < N + 2; ++k) std::swap(a[c][k], a[pivot][k]);
    for (int r = 0; r <= N; ++r) {
      if (r == c || a[r][c] == 0) continue;
      const mpq_class factor = a[r][c] / a[c][c];
      for (int k = c; k < N + 2; ++k) a[r][k] -= factor * a[c][k];
    }
  }
  mpq_class other = 0;
  for (int v = 0; v < N; ++v) other += a[v][N + 1] / a[v][v] * value(v, m);
  const mpq_class z = a[N][N + 1] / a[N][N];
  REQUIRE(other != z);
  return other > z;
}

template <int N>
void compare(int steps) {
  std::mt19937_64 random(static_cast<std::uint64_t>(100 * N + steps));
  int compared = 0;
  for (int trial = 0; trial < 400; ++trial) {
    tissue::FieldMatrix fields(N, 6);
    for (Eigen::Index i = 0; i < fields.size(); ++i) {
      fields.data()[i] =
          static_cast<double>(random() % static_cast<std::uint64_t>(steps + 1)) / steps;
    }
    std::array<std::int32_t, 6> order{0, 1, 2, 3, 4, 5};
    std::shuffle(order.begin(), order.end(), random);
    std::array<std::int32_t, N> vertices;
    std::array<std::int32_t, N> columns;
    for (int k = 0; k < N; ++k) {
      vertices[static_cast<std::size_t>(k)] = k;
      columns[static_cast<std::size_t>(k)] = order[static_cast<std::size_t>(k)];
    }
    const auto expected = belowByRationals<N>(fields, vertices, columns, order[5]);
    if (!expected) continue;
    ++compared;
    INFO("trial " << trial << " steps " << steps);
    CHECK(TiedPoint<N>(fields, vertices, columns).isBelow(order[5]) == *expected);
  }
  CHECK(compared > 50);
}

}  // namespace

TEST_CASE("signs at tied points agree with rational arithmetic and real, tiny perturbations") {
  for (const int steps : {2, 4, 16, 1 << 20}) {
    compare<2>(steps);
    compare<3>(steps);
    compare<4>(steps);
  }
}

TEST_CASE("places of tied points make the fields equal") {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  for (int trial = 0; trial < 100; ++trial) {
    tissue::FieldMatrix fields(4, 4);
    for (Eigen::Index i = 0; i < fields.size(); ++i) fields.data()[i] = uniform(random);
    const auto weight = TiedPoint<4>(fields, {0, 1, 2, 3}, {0, 1, 2, 3}).barycentric();
    const Eigen::RowVector4d at =
        Eigen::RowVector4d(weight[0], weight[1], weight[2], weight[3]) * fields;
    CHECK(weight[0] + weight[1] + weight[2] + weight[3] == Approx(1.0));
    double size = 0.0;
    for (const double w : weight) size = std::max(size, std::abs(w));
    CHECK(at.maxCoeff() - at.minCoeff() <= 1e-10 * size);
  }
}
