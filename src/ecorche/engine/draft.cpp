#include <ecorche/core/parallel.h>
#include <ecorche/engine/draft.h>
#include <ecorche/engine/inputs.h>
#include <ecorche/envelope/envelope.h>
#include <ecorche/envelope/tissue_surface.h>
#include <ecorche/tissue/solve_tissues.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>

namespace ecorche::engine {

namespace {

using domain::WantedLength;
using mesh::Vector3;

// A draft has fewer tets than the domain, but enough to tell thick muscles from thin ones
constexpr std::int64_t kEnoughTets = 80000;
constexpr double kLargeShare = 0.25;  // of a domain so large that many muscles must be in it
constexpr std::int64_t kLeastTets = 5000;
constexpr double kShareOfTets = 2.0 / 3.0;
constexpr double kTolerance = 2.0;  // of the domain's own
constexpr double kLargestTolerance = 0.09;

// Measured on the hind limb at 120 k tets against 1.5 M (docs/decisions.md)
constexpr double kShare = 0.25;  // of the thickness; the domain scales all lengths to its budget
constexpr double kBesideFat = 0.75;  // fat has no curve of its own that errs the same way
constexpr double kTaper = 1.5;       // of the distance to the curve, where a muscle is thin ...
constexpr double kThinnest = 0.4;    // ... but no less than this share

constexpr double kCubesAlong = 512.0;  // the skin's diagonal
constexpr double kStepsPerOctave = 8.0;

std::vector<Vector3> alongCurves(const tissue::CurveTissue& tissue) {
  std::vector<Vector3> out;
  for (const tissue::TissueCurve& curve : tissue.curves) {
    const auto line = curve.spline.sample(curve.spline.length() / 100).point;
    out.insert(out.end(), line.begin(), line.end());
  }
  return out;
}

double distanceTo(const std::vector<Vector3>& points, const Vector3& p) {
  double best = std::numeric_limits<double>::infinity();
  for (const Vector3& q : points) best = std::min(best, (q - p).squaredNorm());
  return std::sqrt(best);
}

// What a muscle's surface asks for at its vertices
std::vector<double> lengthsOn(const envelope::TissueSurface& surface, double volume,
                              const std::vector<Vector3>& core) {
  const mesh::SurfaceMesh& m = surface.mesh;
  const double thickness = 2.0 * volume / mesh::surfaceArea(m.V, m.F);
  std::vector<double> out(static_cast<std::size_t>(m.V.rows()), kShare * thickness);
  for (Eigen::Index f = 0; f < m.F.rows(); ++f) {
    if (surface.beyond[static_cast<std::size_t>(f)].tissue != kFat) continue;
    for (int k = 0; k < 3; ++k)
      out[static_cast<std::size_t>(m.F(f, k))] = kBesideFat * kShare * thickness;
  }
  parallelFor(
      m.V.rows(),
      [&](std::int64_t v) {
        const double away = distanceTo(core, m.V.row(v).transpose());
        out[static_cast<std::size_t>(v)] *= std::clamp(kTaper * away / thickness, kThinnest, 1.0);
      },
      256);
  return out;
}

}  // namespace

std::vector<WantedLength> lengthsWhereTissuesMeet(const envelope::Anatomy& anatomy,
                                                  const std::vector<tissue::CurveTissue>& tissues,
                                                  double diagonal) {
  const auto names = fieldNames(tissues);
  const auto surfaces = envelope::tissueSurfaces(anatomy, names);
  const auto measures = envelope::measureTissues(anatomy, names.size());

  const double cube = diagonal / kCubesAlong;
  std::map<std::array<int, 3>, double> wanted;
  for (std::size_t i = 0; i < tissues.size(); ++i) {
    const mesh::SurfaceMesh& surface = surfaces[i + 1].mesh;
    if (tissues[i].filler || surface.empty()) continue;
    const std::vector<double> lengths =
        lengthsOn(surfaces[i + 1], measures[i + 1].volume, alongCurves(tissues[i]));
    for (Eigen::Index v = 0; v < surface.V.rows(); ++v) {
      const double length = lengths[static_cast<std::size_t>(v)];
      const Eigen::Array3i at = (surface.V.row(v).transpose() / cube).array().floor().cast<int>();
      const auto [cell, fresh] = wanted.try_emplace({at.x(), at.y(), at.z()}, length);
      if (!fresh) cell->second = std::min(cell->second, length);
    }
  }
  std::vector<WantedLength> out;
  for (const auto& [at, length] : wanted) {
    const Vector3 centre = (Eigen::Array3i(at[0], at[1], at[2]).cast<double>() + 0.5) * cube;
    const double steps = std::round(kStepsPerOctave * std::log2(length / diagonal));
    out.push_back({centre, diagonal * std::exp2(steps / kStepsPerOctave)});
  }
  return out;
}

Result<std::vector<WantedLength>> lengthsFromDraft(const domain::DomainInput& input,
                                                   const domain::DomainOptions& options,
                                                   const std::vector<tissue::CurveTissue>& tissues,
                                                   const tissue::TissueOptions& how,
                                                   RunContext& run) {
  const Stage stage(run, "draft");
  domain::DomainOptions coarse = options;
  coarse.edgeLength.reset();
  const std::int64_t tets = options.tets.value_or(kEnoughTets);
  const auto share = [&](double s) {
    return static_cast<std::int64_t>(s * static_cast<double>(tets));
  };
  coarse.tets =
      std::clamp(share(kShareOfTets), kLeastTets, std::max(kEnoughTets, share(kLargeShare)));
  coarse.surfaceToleranceRel =
      std::max(options.surfaceToleranceRel,
               std::min(kTolerance * options.surfaceToleranceRel, kLargestTolerance));
  auto built = domain::buildDomain(input, coarse, run);
  if (!built) return passOn(built);
  auto solved = tissue::solveTissues(built->domain, tissues, how, run);
  if (!solved) return passOn(solved);
  auto anatomy = envelope::buildAnatomy(built->domain, solved->fields, solved->cores, {}, run);
  if (!anatomy) return passOn(anatomy);
  return lengthsWhereTissuesMeet(anatomy->anatomy, tissues, built->domain.skinDiagonal);
}

}  // namespace ecorche::engine
