#include <ecorche/tissue/curve_trace.h>
#include <ecorche/tissue/segmentation.h>
#include <ecorche/tissue/tissue_solver.h>
#include <ecorche/tissue/well.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "support/generated_domain.h"
#include "tissue/curves.h"

using namespace ecorche;
using namespace ecorche::tissue;
using domain::Domain;
using mesh::Vector3;
using test::muscle;

namespace {

constexpr double kPi = std::numbers::pi;

TissueFields solved(const Domain& domain, const std::vector<CurveTissue>& tissues,
                    const TissueOptions& options) {
  RunContext run;
  const auto cores = traceCurves(domain, tissues, options, run);
  REQUIRE(cores.has_value());
  auto fields = solveTissueFields(domain, *cores, tissues, options, run);
  REQUIRE(fields.has_value());
  return std::move(*fields);
}

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
  const LineInCylinder exact{1.0, 0.01, 0.2};
  for (const int cells : {12, 20, 32}) {
    for (const std::uint64_t seed : {0U, 5U}) {
      const Domain domain = test::cylinderDomain(exact.R, 0.8, cells, seed);
      TissueOptions options;
      options.coreRadius = exact.rho;
      const auto fields = solved(domain, {muscle("m", {{0.2, 0, -0.1}, {0.2, 0, 0.9}})}, options);
      const double h = 2.0 / cells;
      double scale = 0.0;
      double worst = 0.0;
      double mean = 0.0;
      int count = 0;
      for (Eigen::Index v = 0; v < domain.mesh.V.rows(); ++v) {
        const double x = domain.mesh.V(v, 0);
        const double y = domain.mesh.V(v, 1);
        if (std::hypot(x - 0.2, y) < 2.0 * h) continue;
        const double f = exact.field(x, y);
        scale = std::max(scale, f);
        worst = std::max(worst, std::abs(fields.values(v, 1) - f));
        mean += fields.values(v, 1) - f;
        ++count;
      }
      INFO(cells << " cells, seed " << seed << ", worst " << worst / scale << ", mean "
                 << mean / count / scale);
      CHECK(worst / scale < 0.16);
      CHECK(std::abs(mean / count) / scale < 0.035);
    }
  }
}

TEST_CASE(
    "refinement keeps a muscle's volume with well weights and shrinks it with the paper's rows") {
  TissueOptions well;
  well.coreRadius = 0.01;
  TissueOptions paper;
  paper.alpha = 5.0;
  const CurveTissue m = muscle("m", {{-0.11, 0.07, 0.2}, {0.13, -0.05, 1.4}});
  std::vector<double> wells;
  std::vector<double> papers;
  for (const int cells : {16, 28}) {
    const Domain domain = test::cylinderDomain(1.0, 1.6, cells, 3);
    wells.push_back(tissueVolumes(domain.mesh, solved(domain, {m}, well))[1]);
    papers.push_back(tissueVolumes(domain.mesh, solved(domain, {m}, paper))[1]);
  }
  INFO(wells[0] << " " << wells[1] << " against " << papers[0] << " " << papers[1]);
  CHECK(std::abs(wells[1] / wells[0] - 1.0) < 0.06);
  CHECK(papers[1] / papers[0] < 0.9);
}

TEST_CASE(
    "fat between spheres is d_fat everywhere without a muscle's pull, and less near a curve") {
  const Domain shell = test::shellDomain(0.4, 1.0, 8);
  const auto fields = solved(shell, {muscle("m", {{0.7, 0, 0}, {0.6, 0.3, 0.1}})}, {});
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
