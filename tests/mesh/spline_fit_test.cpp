#include <ecorche/core/contract.h>
#include <ecorche/mesh/spline_fit.h>

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>

using namespace ecorche::mesh;

namespace {

/// A muscle-like curve: advances steadily, sways gently.
std::vector<Vector3> wanderingPoints(int count, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> sway(-0.3, 0.3);
  std::vector<Vector3> points;
  for (int p = 0; p < count; ++p) {
    points.emplace_back(p + 0.5 * sway(random), sway(random), sway(random));
  }
  return points;
}

double rms(const Spline& a, const Spline& b) {
  double sum = 0.0;
  for (int k = 0; k <= 100; ++k) {
    sum += (a.at(a.parameterAt(a.length() * k / 100)) - b.at(b.parameterAt(b.length() * k / 100)))
               .squaredNorm();
  }
  return std::sqrt(sum / 101);
}

}  // namespace

TEST_CASE("with its knots a spline is the basis times its points") {
  for (int count = 2; count <= 6; ++count) {
    const auto points = wanderingPoints(count, 7);
    const Spline s(points);
    for (double u = 0.0; u <= s.lastParameter(); u += 0.0625) {
      const Eigen::VectorXd weights = s.basis(u);
      REQUIRE(weights.size() == count);
      CHECK(weights.sum() == Approx(1.0).epsilon(1e-13));
      Vector3 sum = Vector3::Zero();
      for (int p = 0; p < count; ++p) sum += weights[p] * points[static_cast<std::size_t>(p)];
      CHECK((sum - s.at(u)).norm() < 1e-13);
    }
  }
}

TEST_CASE("a stroke drawn along a spline gives that spline back") {
  for (int count = 2; count <= 8; ++count) {
    for (unsigned seed = 0; seed < 5; ++seed) {
      INFO("points " << count << ", seed " << seed);
      const Spline truth(wanderingPoints(count, seed));
      const auto fitted = fitSpline(truth.sample(truth.length() / 400).point, count);
      REQUIRE(static_cast<int>(fitted.size()) == count);
      CHECK(fitted.front() == truth.points().front());
      CHECK(fitted.back() == truth.points().back());
      CHECK(rms(Spline(fitted), truth) < 2e-4 * truth.length());
    }
  }
}

TEST_CASE("a fit through a trembling hand stays below the tremble") {
  const Spline truth(wanderingPoints(4, 3));
  std::mt19937 random(1);
  std::normal_distribution<double> tremble(0.0, 0.02);
  auto stroke = truth.sample(truth.length() / 300).point;
  for (std::size_t k = 1; k + 1 < stroke.size(); ++k) {
    stroke[k] += Vector3(tremble(random), tremble(random), tremble(random));
  }
  CHECK(rms(Spline(fitSpline(stroke, 4)), truth) < 0.02);
}

TEST_CASE("where the hand was slow counts no more than where it was quick") {
  const Spline truth({{0, 0, 0}, {1, 0.5, 0}, {2, -0.5, 0}, {3, 0, 0}, {4, 1, 0}});
  std::vector<Vector3> even, uneven;
  for (int k = 0; k <= 600; ++k) {
    const double share = k / 600.0;
    even.push_back(truth.at(truth.parameterAt(truth.length() * share)));
    uneven.push_back(truth.at(truth.parameterAt(truth.length() * share * share)));
  }
  CHECK(rms(Spline(fitSpline(even, 4)), Spline(fitSpline(uneven, 4))) < 2e-3);
}

TEST_CASE("a straight stroke stays straight for any number of points") {
  std::vector<Vector3> stroke;
  for (int k = 0; k <= 40; ++k) stroke.emplace_back(0.1 * k * k, 0.0, 0.0);
  for (int count = 2; count <= 8; ++count) {
    const auto fitted = fitSpline(stroke, count);
    REQUIRE(static_cast<int>(fitted.size()) == count);
    CHECK(Spline(fitted).length() == Approx(160.0).epsilon(1e-12));
    for (const Vector3& p : fitted) CHECK(p.tail<2>().norm() < 1e-12);
  }
}

TEST_CASE("the fit turns, moves and scales with the stroke") {
  const auto stroke = Spline(wanderingPoints(6, 11)).sample(0.05).point;
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(0.7, Vector3(1, 2, -1).normalized()).toRotationMatrix();
  std::vector<Vector3> moved;
  for (const Vector3& p : stroke) moved.push_back(1e-3 * (turn * p) + Vector3(5, -2, 1));
  const auto a = fitSpline(stroke, 4);
  const auto b = fitSpline(moved, 4);
  for (std::size_t p = 0; p < a.size(); ++p) {
    CHECK((1e-3 * (turn * a[p]) + Vector3(5, -2, 1) - b[p]).norm() < 1e-8);
  }
}

TEST_CASE("odd strokes give something that a spline can be made of") {
  const std::vector<std::vector<Vector3>> strokes = {
      {{0, 0, 0}, {1, 0, 0}},
      {{0, 0, 0}, {0, 0, 0}, {1, 0, 0}, {1, 0, 0}},
      {{0, 0, 0}, {1, 0, 0}, {0, 0, 0}},                                    // there and back
      {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 0}},              // closed
      {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {1, 0, 0}, {0, 0, 0}, {-1, 0, 0}},  // over itself
      {{0, 0, 0}, {1e-9, 0, 0}, {2e-9, 1e-9, 0}, {1, 0, 0}, {1, 1e-9, 0}},  // jitter at the ends
  };
  for (const auto& stroke : strokes) {
    for (int count = 2; count <= 5; ++count) {
      const auto fitted = fitSpline(stroke, count);
      CHECK(fitted.front() == stroke.front());
      CHECK(fitted.back() == stroke.back());
      CHECK(std::isfinite(Spline(fitted).length()));
    }
  }
  CHECK_THROWS_AS(fitSpline({{1, 1, 1}, {1, 1, 1}}, 4), ecorche::ContractError);
}
