#include <ecorche/core/contract.h>
#include <ecorche/tissue/cross_section.h>
#include <ecorche/tissue/resolution.h>
#include <ecorche/tissue/segmentation.h>
#include <ecorche/tissue/solve_tissues.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <numbers>

namespace ecorche::tissue {

using domain::Domain;
using mesh::Vector3;

namespace {

constexpr int kSections = 200;

// Areas along the middle two thirds of the muscle's line
std::vector<double> sections(const Domain& domain, const TissueFields& fields,
                             const mesh::Spline& line) {
  const Vector3 from = line.points().front();
  const double length = line.length();
  std::vector<double> distances;
  for (int k = 0; k < kSections; ++k) {
    distances.push_back(length * (1.0 + 4.0 * (k + 0.5) / kSections) / 6.0);
  }
  const Vector3 direction = (line.points().back() - from) / length;
  return crossSectionAreas(domain.mesh, fields, kFirstMuscle, from, direction, distances);
}

}  // namespace

Result<ResolutionCase> measureResolution(const Domain& domain,
                                         const std::vector<CurveTissue>& tissues,
                                         const TissueOptions& options, RunContext& run) {
  ResolutionCase out;
  out.tets = domain.mesh.T.rows();
  out.freeVertices = std::ranges::count(domain.onSkin, 0);
  TissueOptions well = options;
  well.alpha.reset();
  const auto begin = std::chrono::steady_clock::now();
  const auto ours = solveTissues(domain, tissues, well, run);
  if (!ours) return passOn(ours);
  out.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  out.volume = tissueVolumes(domain.mesh, ours->fields);

  TissueOptions paper = options;
  paper.alpha = 5.0;
  const auto theirs = solveTissues(domain, tissues, paper, run);
  if (!theirs) return passOn(theirs);
  out.volumePaper = tissueVolumes(domain.mesh, theirs->fields);
  return out;
}

VolumeChange volumeChange(const std::vector<ResolutionCase>& cases,
                          const std::vector<CurveTissue>& tissues, bool paper, double leastVolume) {
  VolumeChange out;
  if (cases.empty()) return out;
  const auto spread = [&](const auto& volumeOf) {
    double least = std::numeric_limits<double>::infinity();
    double most = 0.0;
    for (const ResolutionCase& c : cases) {
      const double v = volumeOf(paper ? c.volumePaper : c.volume);
      least = std::min(least, v);
      most = std::max(most, v);
    }
    return std::pair(least, least > 0.0 ? most / least - 1.0 : 0.0);
  };
  out.total = spread([&](const std::vector<double>& v) {
                double sum = 0.0;
                for (std::size_t i = 0; i < tissues.size(); ++i)
                  sum += tissues[i].filler ? 0.0 : v[i + 1];
                return sum;
              }).second;
  for (std::size_t i = 0; i < tissues.size(); ++i) {
    if (tissues[i].filler) continue;
    const auto [least, change] = spread([&](const std::vector<double>& v) { return v[i + 1]; });
    if (least < leastVolume || change <= out.largest) continue;
    out.largest = change;
    out.tissue = i;
  }
  return out;
}

Result<Smoothness> measureSmoothness(const Domain& coarse, const Domain& fine,
                                     const CurveTissue& muscle, const TissueOptions& options,
                                     RunContext& run) {
  EC_REQUIRE_EQ(muscle.curves.size(), std::size_t{1});
  EC_REQUIRE_EQ(muscle.curves[0].spline.points().size(), std::size_t{2});
  const mesh::Spline& line = muscle.curves[0].spline;
  const auto rough = solveTissues(coarse, {muscle}, options, run);
  if (!rough) return passOn(rough);
  const auto good = solveTissues(fine, {muscle}, options, run);
  if (!good) return passOn(good);

  const std::vector<double> a = sections(coarse, rough->fields, line);
  const std::vector<double> b = sections(fine, good->fields, line);
  Eigen::ArrayXd ratio(kSections);
  double meanArea = 0.0;
  for (int k = 0; k < kSections; ++k) {
    const auto i = static_cast<std::size_t>(k);
    ratio[k] = a[i] / b[i];
    meanArea += b[i] / kSections;
  }
  const Eigen::VectorXd edges = mesh::meanEdgeLengths(coarse.mesh);
  double edge = 0.0;
  double length = 0.0;
  for (const CoreSample& s : rough->cores.samples) {
    edge += s.length * edges[s.tet];
    length += s.length;
  }
  Smoothness out;
  out.across = 2.0 * std::sqrt(meanArea / std::numbers::pi) / (edge / length);
  out.meanRatio = ratio.mean();
  out.deviation = std::sqrt((ratio - out.meanRatio).square().mean()) / out.meanRatio;
  return out;
}

}  // namespace ecorche::tissue
