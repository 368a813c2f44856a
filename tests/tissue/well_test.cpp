#include <ecorche/tissue/curve_trace.h>
#include <ecorche/tissue/resolution.h>
#include <ecorche/tissue/segmentation.h>
#include <ecorche/tissue/tissue_solver.h>
#include <ecorche/tissue/well.h>
#include <ecorche/tissue/well_radius.h>

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <random>

#include "support/generated_domain.h"
#include "tissue/curves.h"

using namespace ecorche;
using namespace ecorche::tissue;
using domain::Domain;
using mesh::Vector3;
using test::muscle;

namespace {

constexpr double kPi = std::numbers::pi;

// A core of radius ρ at distance e from the axis of a cylinder of radius R, f = 0 on its side: the
// image of the line in the side's circle gives the field, the resistance 1/(πβ) and the logarithm
// its strength.
struct LineInCylinder {
  double R, rho, e;
  [[nodiscard]] double flux() const {
    return 1.0 / (1.0 / (kPi * kWellBeta) + std::log((R * R - e * e) / (R * rho)) / (2.0 * kPi));
  }
  [[nodiscard]] double field(double x, double y) const {
    const double toLine = std::hypot(x - e, y);
    const double toImage = std::hypot(x * e / R - R, y * e / R);
    return flux() / (2.0 * kPi) * std::log(toImage / toLine);
  }
};

}  // namespace

TEST_CASE("a curve in a cylinder has the field of the exact logarithm, on coarse and fine tets") {
  // Along planes of the grid and at an angle to them; finer than the tets, and resolved by the
  // finest of them
  for (const double angle : {0.0, 0.6}) {
    for (const double rho : {0.01, 0.06}) {
      const LineInCylinder exact{1.0, rho, 0.23};
      for (const int cells : {12, 20, 32}) {
        for (const std::uint64_t seed : {0U, 5U}) {
          const Domain domain = test::cylinderDomain(exact.R, 0.8, cells, seed);
          TissueOptions options;
          options.coreRadius = exact.rho;
          const Eigen::Vector2d at = exact.e * Eigen::Vector2d(std::cos(angle), std::sin(angle));
          const auto fields = test::solved(
              domain, {muscle("m", {{at.x(), at.y(), -0.1}, {at.x(), at.y(), 0.9}})}, options);
          double scale = 0.0;
          double worst = 0.0;
          double mean = 0.0;
          int count = 0;
          for (Eigen::Index v = 0; v < domain.mesh.V.rows(); ++v) {
            const Eigen::Vector2d p =
                Eigen::Rotation2Dd(-angle) * domain.mesh.V.row(v).head<2>().transpose();
            if (std::hypot(p.x() - exact.e, p.y()) < std::max(4.0 / cells, 1.5 * rho)) continue;
            const double f = exact.field(p.x(), p.y());
            scale = std::max(scale, f);
            worst = std::max(worst, std::abs(fields.values(v, 1) - f));
            mean += fields.values(v, 1) - f;
            ++count;
          }
          INFO("angle " << angle << ", rho " << rho << ", " << cells << " cells, seed " << seed
                        << ", worst " << worst / scale << ", mean " << mean / count / scale);
          CHECK(worst / scale < 0.07);
          CHECK(std::abs(mean / count) / scale < 0.012);
        }
      }
    }
  }
}

TEST_CASE("vertices beside a curve have the line's own field, which linear functions miss") {
  const LineInCylinder exact{1.0, 0.01, 0.23};
  for (const int cells : {12, 20}) {
    const double h = 2.0 / cells;
    // Relative, root mean square over vertices within an edge of the line, away from its ends
    double raw = 0.0;
    double corrected = 0.0;
    int count = 0;
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
      const Domain domain = test::cylinderDomain(exact.R, 0.8, cells, seed);
      TissueOptions options;
      options.coreRadius = exact.rho;
      const std::vector<CurveTissue> one{muscle("m", {{exact.e, 0.0, -0.1}, {exact.e, 0.0, 0.9}})};
      RunContext run;
      auto cores = traceCurves(domain, one, options, run);
      REQUIRE(cores.has_value());
      const auto with = solveTissueFields(domain, *cores, one, options, run);
      cores->nearCurves.clear();
      const auto without = solveTissueFields(domain, *cores, one, options, run);
      REQUIRE(with.has_value());
      REQUIRE(without.has_value());
      for (Eigen::Index v = 0; v < domain.mesh.V.rows(); ++v) {
        const Vector3 p = domain.mesh.V.row(v).transpose();
        const double r = std::hypot(p.x() - exact.e, p.y());
        if (r < 0.2 * h || r > 0.9 * h || p.z() < h || p.z() > 0.8 - h) continue;
        const double f = exact.field(p.x(), p.y());
        raw += std::pow(without->values(v, 1) / f - 1.0, 2);
        corrected += std::pow(with->values(v, 1) / f - 1.0, 2);
        ++count;
      }
    }
    raw = std::sqrt(raw / count);
    corrected = std::sqrt(corrected / count);
    REQUIRE(count > 20);
    INFO(cells << " cells: " << raw << " raw, " << corrected << " corrected");
    CHECK(raw > 0.03);
    CHECK(corrected < 0.35 * raw);
  }
}

TEST_CASE(
    "where curves run within one tet of each other no vertex is taken past what they ask for") {
  const Domain domain = test::cylinderDomain(1.0, 0.8, 12, 4);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> within(-1.0, 1.0);
  const auto beside = [&](double x, double y, double z) {
    return Vector3(x + 0.02 * within(random), y + 0.02 * within(random), z);
  };
  std::vector<CurveTissue> bundle;
  for (int i = 0; i < 12; ++i)
    bundle.push_back(muscle("m" + std::to_string(i),
                            {beside(0.1 * within(random), 0.1, -0.1), beside(0.1, 0.05, 0.4),
                             beside(0.1, 0.3 * within(random), 0.9)}));
  TissueOptions options;
  options.coreRadius = 0.003;
  RunContext run;
  auto cores = traceCurves(domain, bundle, options, run);
  REQUIRE(cores.has_value());
  const auto with = solveTissueFields(domain, *cores, bundle, options, run);
  cores->nearCurves.clear();
  const auto without = solveTissueFields(domain, *cores, bundle, options, run);
  REQUIRE(with.has_value());
  REQUIRE(without.has_value());
  Eigen::Index moved = 0;
  for (Eigen::Index v = 0; v < domain.mesh.V.rows(); ++v) {
    for (Eigen::Index j = 1; j < with->values.cols(); ++j) {
      const double before = without->values(v, j);
      const double after = with->values(v, j);
      moved += before != after;
      CHECK(after >= std::min(0.0, before));
      CHECK(after <= std::max(1.0, before));
    }
  }
  CHECK(moved > 100);
}

TEST_CASE(
    "refinement keeps a muscle's volume with well weights and shrinks it with the paper's rows") {
  TissueOptions well;
  well.coreRadius = 0.01;
  const std::vector<CurveTissue> one{muscle("m", {{-0.11, 0.07, 0.2}, {0.13, -0.05, 1.4}})};
  std::vector<ResolutionCase> cases;
  for (const int cells : {16, 22, 30}) {
    RunContext run;
    const auto measured =
        measureResolution(test::cylinderDomain(1.0, 1.6, cells, 3), one, well, run);
    REQUIRE(measured.has_value());
    cases.push_back(*measured);
  }
  CHECK(volumeChange(cases, one, false, 0.0).total < 0.02);
  CHECK(volumeChange(cases, one, true, 0.0).total > 0.1);
  CHECK(cases.back().volumePaper[1] < cases.front().volumePaper[1]);
  CHECK(cases[0].volume[0] + cases[0].volume[1] ==
        Approx(cases[0].volumePaper[0] + cases[0].volumePaper[1]));
}

TEST_CASE("a straight muscle is smooth: its cross-section hardly varies at five tets across") {
  const CurveTissue m = muscle("m", {{-0.11, 0.07, -0.01}, {0.13, -0.05, 1.21}});
  TissueOptions options;
  options.coreRadius = 0.01;
  RunContext run;
  const Domain fine = test::cylinderDomain(1.0, 1.2, 32, 9);
  for (const std::uint64_t seed : {1U, 2U}) {
    const auto five =
        measureSmoothness(test::cylinderDomain(1.0, 1.2, 19, seed), fine, m, options, run);
    REQUIRE(five.has_value());
    INFO(five->across << " tets across, " << five->deviation << ", mean " << five->meanRatio);
    CHECK(five->across == Approx(5.0).margin(0.6));
    CHECK(five->deviation < 0.012);
    CHECK(five->meanRatio == Approx(1.0).margin(0.015));
  }
}

TEST_CASE("the well radius of a row knows where in its tet the line runs, and no units") {
  const Domain domain = test::cylinderDomain(1.0, 1.0, 14, 4);
  const Vector3 tangent = Vector3(0.2, -0.3, 1.0).normalized();
  const Eigen::VectorXd h = mesh::meanEdgeLengths(domain.mesh);
  const Eigen::Matrix3d R =
      Eigen::AngleAxisd(0.9, Vector3(2, 1, -1).normalized()).toRotationMatrix();
  const Domain turned = test::moved(domain, R, 1024.0, Vector3::Zero());
  const WellSolver wells(domain);
  const WellSolver turnedWells(turned);
  double mean = 0.0;
  int count = 0;
  for (Eigen::Index t = 0; t < domain.mesh.T.rows(); t += 7) {
    const Vector3 p = domain.mesh.V(domain.mesh.T.row(t), Eigen::all).colwise().mean().transpose();
    const WellPoint point{p, std::int32_t(t)};
    const double r = wells.radius({&point, 1}, tangent, h[t]);
    REQUIRE(r >= kLeastWell * kWellC * h[t]);
    REQUIRE(r <= kWellC * h[t] / kLeastWell);
    const WellPoint there{1024.0 * (R * p), std::int32_t(t)};
    REQUIRE(turnedWells.radius({&there, 1}, R * tangent, 1024.0 * h[t]) ==
            Approx(1024.0 * r).epsilon(1e-9));
    mean += r / h[t];
    ++count;
  }
  CHECK(mean / count == Approx(kWellC).margin(0.05));
}

TEST_CASE("a line in the faces of a grid has one well radius, whichever tet it is asked in") {
  const Domain domain = test::cylinderDomain(1.0, 1.0, 16, 0);
  const Vector3 p(0.21, 0.0, 0.43);
  const WellSolver wells(domain);
  const mesh::TetLocator locator(domain.mesh);
  const auto radiusIn = [&](const Vector3& towards) {
    const WellPoint point{p, locator.locate(p + towards)};
    return wells.radius({&point, 1}, Vector3::UnitZ(), 0.15);
  };
  const double a = radiusIn(Vector3(0, -1e-9, 0));
  const double b = radiusIn(Vector3(0, 1e-9, 0));
  CHECK(a == Approx(b).epsilon(1e-3));
}

TEST_CASE("the rim of a core reads the line's field at its own radius once tets are fine") {
  CHECK(rimPointCount(1.0, 2.5) == 6);
  CHECK(rimPointCount(1.0, 0.5) == 13);
  CHECK(rimRadius(1.0, 0.01, 24) == Approx(1.0).epsilon(0.1));
  CHECK(rimRadius(1.0, 0.1, 24) == Approx(1.0).epsilon(0.1));
  // n points of a circle: their distances multiply to n
  CHECK(rimRadius(1.0, 1e-6, 12) == Approx(std::pow(12.0 * 1e-6, 1.0 / 12.0)).epsilon(1e-6));
  CHECK(wellWeight(0.01, 0.01) == Approx(std::numbers::pi * kWellBeta));
  CHECK(wellWeight(0.01, 0.05) < wellWeight(0.01, 0.02));
}

TEST_CASE(
    "fat between spheres is d_fat everywhere without a muscle's pull, and less near a curve") {
  const Domain shell = test::shellDomain(0.4, 1.0, 8);
  const auto fields = test::solved(shell, {muscle("m", {{0.7, 0, 0}, {0.6, 0.3, 0.1}})}, {});
  CHECK(fields.values.col(0).maxCoeff() <= 0.3 * (1.0 + 1e-9));
  for (Eigen::Index v = 0; v < shell.mesh.V.rows(); ++v) {
    if (shell.onSkin[std::size_t(v)] != 0) {
      REQUIRE(fields.values(v, 0) == 0.3);
      REQUIRE(fields.values(v, 1) == 0.0);
    }
    // One curve of value 1: fat is exactly what it leaves
    REQUIRE(fields.values(v, 0) == Approx(0.3 * (1.0 - fields.values(v, 1))).margin(1e-12));
  }
}
