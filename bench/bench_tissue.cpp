// Benchmarks of the tissue room: `bench_tissue [smoothness|calibration|fields]…`, all of them
// without arguments. Prints one JSON object; docs/algorithms/tissue_fields.md quotes its figures.

#include <cblas.h>
#include <ecorche/core/parallel.h>
#include <ecorche/tissue/cross_section.h>
#include <ecorche/tissue/curve_trace.h>
#include <ecorche/tissue/resolution.h>
#include <ecorche/tissue/segmentation.h>
#include <ecorche/tissue/tissue_solver.h>
#include <ecorche/tissue/well.h>
#include <ecorche/tissue/well_radius.h>
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <numbers>
#include <random>

#include "support/generated_domain.h"

using namespace ecorche;
using namespace ecorche::tissue;
using domain::Domain;
using mesh::Vector3;
using Json = nlohmann::ordered_json;

namespace {

double now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

CurveTissue muscle(std::vector<Vector3> points) {
  CurveTissue out;
  out.name = "muscle";
  const std::size_t count = points.size();
  out.curves.push_back({"", mesh::Spline(std::move(points)), std::vector<double>(count, 1.0)});
  return out;
}

template <class T>
T must(Result<T> result) {
  if (result) return std::move(*result);
  fmt::print(stderr, "{}\n", result.error().text());
  std::exit(1);
}

// Every row as the mean edge alone would weigh it: what we do better than
void weighByMeanEdge(const Domain& domain, double rho, double c, CoreSamples& cores) {
  const Eigen::VectorXd h = mesh::meanEdgeLengths(domain.mesh);
  for (CoreSample& s : cores.samples) s.weight = s.length * wellWeight(rho, c * h[s.tet]);
}

// A straight muscle at a general position and direction in a cylinder of fat, its cross-sections
// against a mesh with eight times the tets
Json smoothness() {
  Json cases = Json::array();
  constexpr double kLength = 1.6;
  const std::vector<std::pair<Vector3, Vector3>> lines = {
      {{-0.11, 0.07, -0.01}, {0.13, -0.05, kLength + 0.01}},
      {{0.20, 0.10, -0.01}, {0.02, 0.21, kLength + 0.01}},
      {{-0.10, -0.30, -0.01}, {0.25, -0.05, kLength + 0.01}}};
  TissueOptions options;
  options.coreRadius = 0.01;
  for (const int cells : {17, 30}) {
    for (std::uint64_t seed = 1; seed <= lines.size(); ++seed) {
      const auto& [from, to] = lines[seed - 1];
      const Domain coarse = test::cylinderDomain(1.0, kLength, cells, seed);
      const Domain fine = test::cylinderDomain(1.0, kLength, 2 * cells, seed + 10);
      RunContext run;
      const Smoothness s = must(measureSmoothness(coarse, fine, muscle({from, to}), options, run));
      cases.push_back(
          {{"name", fmt::format("smoothness, {} cells, line {}", cells, seed)},
           {"tets", coarse.mesh.T.rows()},
           {"muscles", 1},
           {"threads", threadCount()},
           {"metrics", {{"tets_across", s.across}}},
           {"errors", {{"section_deviation", s.deviation}, {"section_mean", s.meanRatio - 1.0}}}});
    }
  }
  return cases;
}

// Flux of a line parallel to the axis against the exact logarithm, and the well radii that rows
// find
Json calibration() {
  Json cases = Json::array();
  constexpr double kLength = 0.8;
  constexpr double kE = 0.23;
  for (const double rho : {0.01, 0.03, 0.06}) {
    const double exact = 1.0 / (1.0 / (std::numbers::pi * kWellBeta) +
                                std::log((1.0 - kE * kE) / rho) / (2.0 * std::numbers::pi));
    for (const int cells : {16, 29, 58}) {
      for (const std::uint64_t seed : {0U, 1U, 2U}) {
        const Domain domain = test::cylinderDomain(1.0, kLength, cells, seed);
        const Eigen::VectorXd h = mesh::meanEdgeLengths(domain.mesh);
        const double angle = 0.6 + static_cast<double>(seed);
        const Vector3 at(kE * std::cos(angle), kE * std::sin(angle), 0.0);
        const std::vector<CurveTissue> one{
            muscle({at - 0.1 * Vector3::UnitZ(), at + (kLength + 0.1) * Vector3::UnitZ()})};
        TissueOptions options;
        options.coreRadius = rho;
        RunContext run;
        const auto fluxError = [&](const CoreSamples& cores) {
          const TissueFields f = must(solveTissueFields(domain, cores, one, options, run));
          double flux = 0.0;
          for (const CoreSample& s : cores.samples) {
            double reads = 0.0;
            for (int k = 0; k < 4; ++k)
              reads += s.barycentric[k] * f.values(domain.mesh.T(s.tet, k), 1);
            flux += s.weight * (1.0 - reads);
          }
          return flux / kLength / exact - 1.0;
        };
        const WellSolver wells(domain);
        CoreSamples cores = must(traceCurves(domain, one, options, run));
        const double ours = fluxError(cores);
        double mean = 0.0;
        double square = 0.0;
        double edge = 0.0;
        for (const CoreSample& s : cores.samples) {
          const Vector3 p = one[0].curves[0].spline.at(s.u);
          const WellPoint point{p, s.tet};
          const double r = wells.radius({&point, 1}, s.tangent, h[s.tet]) / h[s.tet];
          mean += r * s.length / kLength;
          square += r * r * s.length / kLength;
          edge += h[s.tet] * s.length / kLength;
        }
        Json errors = {{"flux", ours}};
        if (edge > 3.0 * rho) {  // one row per tet: the mean edge can be tried
          weighByMeanEdge(domain, rho, 0.4, cores);
          errors["flux_c_0.4"] = fluxError(cores);
        }
        cases.push_back(
            {{"name", fmt::format("calibration, rho {}, {} cells, seed {}", rho, cells, seed)},
             {"tets", domain.mesh.T.rows()},
             {"muscles", 1},
             {"threads", threadCount()},
             {"metrics",
              {{"edge_over_rho", edge / rho},
               {"well_radius_over_edge", mean},
               {"well_radius_deviation", std::sqrt(std::max(0.0, square - mean * mean))}}},
             {"errors", errors}});
      }
    }
  }
  return cases;
}

// Times of the whole room on a limb of many muscles
Json fields() {
  Json cases = Json::array();
  for (const auto& [cells, muscles] : std::vector<std::pair<int, int>>{{30, 25}, {45, 39}}) {
    const Domain domain = test::cylinderDomain(1.0, 2.4, cells, 1);
    std::mt19937_64 random(3);
    const auto between = [&](double lo, double hi) {
      return lo + (hi - lo) * static_cast<double>(random() >> 11) * 0x1p-53;
    };
    std::vector<CurveTissue> tissues;
    for (int i = 0; i < muscles; ++i) {
      const Vector3 at(between(-0.6, 0.6), between(-0.6, 0.6), 0.0);
      std::vector<Vector3> points;
      for (const double z : {0.1, 0.9, 1.7, 2.3}) {
        points.push_back(at + Vector3(between(-0.06, 0.06), between(-0.06, 0.06), z));
      }
      tissues.push_back(muscle(points));
    }
    TissueOptions options;
    options.coreRadius = 0.005;
    RunContext run;
    const double start = now();
    const CoreSamples cores = must(traceCurves(domain, tissues, options, run));
    const double traced = now();
    const TissueSolver solver = must(TissueSolver::create(domain, run));
    const double analysed = now();
    const TissueFields f = must(solver.solve(cores, tissues, options, run));
    const double solved = now();
    cases.push_back({{"name", fmt::format("fields, {} cells", cells)},
                     {"tets", domain.mesh.T.rows()},
                     {"free_vertices", std::ranges::count(domain.onSkin, 0)},
                     {"muscles", muscles},
                     {"threads", threadCount()},
                     {"metrics",
                      {{"total_ms", 1e3 * (solved - start)},
                       {"curves_ms", 1e3 * (traced - start)},
                       {"analysis_ms", 1e3 * (analysed - traced)},
                       {"solve_ms", 1e3 * (solved - analysed)},
                       {"rows", cores.samples.size()},
                       {"factor_entries", solver.factorEntries()}}},
                     {"errors", {{"undershoot", f.undershoot}, {"overshoot", f.overshoot}}}});
  }
  return cases;
}

}  // namespace

int main(int argc, char** argv) {
  std::vector<std::string> names(argv + 1, argv + argc);
  if (names.empty()) names = {"smoothness", "calibration", "fields"};
  Json out;
  out["bench"] = "tissue";
  out["machine"] = {{"threads", threadCount()}, {"blas", openblas_get_config()}};
  out["cases"] = Json::array();
  for (const std::string& name : names) {
    const Json cases = name == "smoothness"    ? smoothness()
                       : name == "calibration" ? calibration()
                       : name == "fields"      ? fields()
                                               : Json();
    if (cases.is_null()) {
      fmt::print(stderr, "no benchmark \"{}\"; there are smoothness, calibration and fields\n",
                 name);
      return 2;
    }
    for (const Json& c : cases) out["cases"].push_back(c);
  }
  fmt::print("{}\n", out.dump(2));
}
