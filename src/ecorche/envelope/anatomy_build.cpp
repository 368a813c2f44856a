#include <ecorche/core/contract.h>
#include <ecorche/core/index.h>
#include <ecorche/envelope/children.h>
#include <ecorche/envelope/envelope.h>
#include <ecorche/envelope/islands.h>
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>

namespace ecorche::envelope {
namespace {

std::map<domain::BoundaryTag, double> areaByTag(const mesh::Positions& V, const mesh::Triangles& F,
                                                const std::vector<domain::BoundaryTag>& tag) {
  std::map<domain::BoundaryTag, double> area;
  for (Eigen::Index f = 0; f < F.rows(); ++f) {
    const mesh::Vector3 a = V.row(F(f, 0)).transpose();
    const mesh::Vector3 b = V.row(F(f, 1)).transpose();
    const mesh::Vector3 c = V.row(F(f, 2)).transpose();
    area[tag[toIndex(f)]] += 0.5 * (b - a).cross(c - a).norm();
  }
  return area;
}

/// Boundary faces of the subdivision in the order of the domain's, with the tags of the faces they
/// are part of.
/// @return how many boundary faces belong to none of the domain's
std::int64_t carryBoundary(const domain::Domain& domain, const Envelope& envelope, Anatomy& out) {
  const Ancestry ancestry(domain.mesh.T, static_cast<std::int32_t>(domain.mesh.V.rows()),
                          envelope.origin);
  std::vector<Face> faces;
  for (Eigen::Index b = 0; b < domain.boundaryF.rows(); ++b) {
    const std::int32_t parent = domain.boundaryTet[toIndex(b)];
    Face own{domain.boundaryF(b, 0), domain.boundaryF(b, 1), domain.boundaryF(b, 2)};
    std::ranges::sort(own);
    int across = 0;
    while (across < 4 && sortedFace(domain.mesh.T, parent, across) != own) ++across;
    EC_REQUIRE(across < 4);
    for (std::int32_t c = envelope.firstChild[toIndex(parent)];
         c < envelope.firstChild[toIndex(parent) + 1]; ++c) {
      for (int k = 0; k < 4; ++k) {
        if (envelope.neighbours(c, k) >= 0) continue;
        if (ancestry.face(parent, sortedFace(envelope.mesh.T, c, k)) != across) continue;
        const auto& f = mesh::kTetFace[k];
        faces.push_back(
            {envelope.mesh.T(c, f[0]), envelope.mesh.T(c, f[1]), envelope.mesh.T(c, f[2])});
        out.boundaryTet.push_back(c);
        out.boundaryTag.push_back(domain.boundaryTag[toIndex(b)]);
      }
    }
  }
  out.boundaryF.resize(static_cast<Eigen::Index>(faces.size()), 3);
  for (std::size_t f = 0; f < faces.size(); ++f) {
    for (int c = 0; c < 3; ++c)
      out.boundaryF(static_cast<Eigen::Index>(f), c) = faces[f][toIndex(c)];
  }
  return (envelope.neighbours.array() < 0).count() - static_cast<std::int64_t>(faces.size());
}

/// The first promise that does not hold, in words; empty if all do.
std::string brokenPromise(const domain::Domain& domain, const AnatomyBuild& build,
                          std::int64_t strayFaces) {
  const Anatomy& anatomy = build.anatomy;
  constexpr double kRelative = 1e-9;
  if (build.stats.unmatchedFaces + strayFaces > 0) {
    return fmt::format("{} faces are neither shared by two tets nor on the boundary",
                       build.stats.unmatchedFaces + strayFaces);
  }
  const double before = mesh::signedVolumes(domain.mesh).sum();
  const double after = mesh::signedVolumes(anatomy.mesh).sum();
  if (std::abs(after - before) > kRelative * before) {
    return fmt::format("tets add up to {} m³, the domain to {} m³", after, before);
  }
  const auto areas = areaByTag(domain.mesh.V, domain.boundaryF, domain.boundaryTag);
  const auto areasNow = areaByTag(anatomy.mesh.V, anatomy.boundaryF, anatomy.boundaryTag);
  for (const auto& [tag, area] : areas) {
    const auto now = areasNow.find(tag);
    // Relative to all of the boundary: a speck of a face has no digits of its own to keep
    const double difference = now == areasNow.end() ? area : std::abs(now->second - area);
    if (difference > kRelative * std::max(area, domain.skinDiagonal * domain.skinDiagonal * 1e-3)) {
      return fmt::format("the boundary of kind {} and index {} changed its area by {} m²",
                         static_cast<int>(tag.kind), tag.index, difference);
    }
  }
  return {};
}

}  // namespace

Result<AnatomyBuild> buildAnatomy(const domain::Domain& domain, const tissue::TissueFields& fields,
                                  const tissue::CoreSamples& cores, const EnvelopeOptions& options,
                                  RunContext& run) {
  const Stage stage(run, "envelope");
  EnvelopeOptions own = options;
  own.fatIsCandidate = options.fatIsCandidate && fields.fatIsCandidate;
  const auto seeds = curveTets(cores);
  own.seeds.insert(own.seeds.end(), seeds.begin(), seeds.end());

  auto envelope = computeEnvelope(domain.mesh, domain.neighbours, fields.values, own, run);
  if (!envelope) return passOn(envelope);
  AnatomyBuild out;
  const std::int64_t strayFaces = carryBoundary(domain, *envelope, out.anatomy);
  out.anatomy.mesh = std::move(envelope->mesh);
  out.anatomy.neighbours = std::move(envelope->neighbours);
  out.anatomy.label = std::move(envelope->label);
  out.anatomy.parentTet = std::move(envelope->parentTet);
  out.anatomy.origin = std::move(envelope->origin);
  out.stats = std::move(envelope->stats);
  if (const std::string broken = brokenPromise(domain, out, strayFaces); !broken.empty()) {
    return fail(ErrorCode::CheckFailed, "envelope: " + broken + "; please report this project");
  }
  return out;
}

}  // namespace ecorche::envelope
