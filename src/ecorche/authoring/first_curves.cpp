#include <ecorche/authoring/first_curves.h>
#include <ecorche/authoring/names.h>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <unordered_map>

namespace ecorche::authoring {

using mesh::Vector3;
using model::Attachment;
using model::Support;

namespace {

// How far the middle of a curve stays from bone and skin, and how near a site must be to a bone to
// be on it.
constexpr double kClearanceRel = 0.003;
constexpr double kReachRel = 0.03;

// The push that takes x out of bone or back under the skin, zero where it is well placed.
Vector3 pushOut(const Vector3& x, double clearance, const Surroundings& around) {
  Vector3 push = Vector3::Zero();
  for (const BoneSurface& bone : around.bones) {
    const Vector3 beyond = (bone.box.lo - x).cwiseMax(x - bone.box.hi).cwiseMax(Vector3::Zero());
    if (bone.surface->empty() || beyond.norm() > clearance) continue;
    const auto closest = bone.surface->closest(x);
    if (closest.distance == 0.0) continue;
    const Vector3 outward = (x - closest.point) / closest.distance;
    if (bone.closed && bone.surface->inside(x)) {
      push -= outward * (closest.distance + clearance);
    } else if (closest.distance < clearance) {
      push += outward * (clearance - closest.distance);
    }
  }
  const auto closest = around.skin.closest(x);
  if (closest.distance > 0.0) {
    const Vector3 inward = (x - closest.point) / closest.distance;
    if (!around.skin.inside(x)) {
      push -= inward * (closest.distance + clearance);
    } else if (closest.distance < clearance) {
      push += inward * (clearance - closest.distance);
    }
  }
  return push;
}

struct End {
  Vector3 at;
  Support support;
};

double heightOver(const model::CutPlane& plane, const Vector3& p) {
  return (p - plane.point).dot(plane.normal);
}

// A millionth of the body is as fine as a first guess can be meant, and reads better in a file.
Vector3 rounded(const Vector3& p, double diagonal) {
  const double perStep = std::pow(10.0, -std::floor(std::log10(1e-6 * diagonal)));
  return (p * perStep).array().round() / perStep;
}

double shareOutside(const std::vector<Vector3>& points, const mesh::SurfaceQuery& skin) {
  const mesh::Spline curve(points);
  constexpr int kSamples = 64;
  int outside = 0;
  for (int k = 1; k < kSamples; ++k) {
    if (!skin.inside(curve.at(curve.parameterAt(curve.length() * k / kSamples)))) ++outside;
  }
  return static_cast<double>(outside) / kSamples;
}

// The bone that the table names where it is near enough, else the nearest one, else free.
End seated(const AttachmentSite& site, const Surroundings& around) {
  const double reach = kReachRel * around.diagonal;
  const std::string wanted = bareName(site.bone);
  for (const BoneSurface& bone : around.bones) {
    if (wanted.empty() || bareName(bone.name) != wanted || bone.surface->empty()) continue;
    const auto closest = bone.surface->closest(site.at);
    if (closest.distance <= reach) return {closest.point, {Support::On::Bone, bone.name}};
  }
  if (const auto snap = snapToBone(site.at, around.bones, reach)) return {snap->at, snap->support};
  return {site.at, {}};
}

// The pair of sites farthest apart; of opposite roles where the table tells any. Origin first.
std::optional<std::pair<std::size_t, std::size_t>> farthestPair(
    const std::vector<AttachmentSite>& sites, const std::vector<End>& ends, const Vector3& centre) {
  const auto any = [&](Attachment::Role role) {
    return std::ranges::find(sites, role, &AttachmentSite::role) != sites.end();
  };
  const bool roles = any(Attachment::Role::Origin) && any(Attachment::Role::Insertion);
  std::optional<std::pair<std::size_t, std::size_t>> best;
  double longest = 0.0;
  for (std::size_t a = 0; a < ends.size(); ++a) {
    for (std::size_t b = 0; b < ends.size(); ++b) {
      const bool fits = roles ? sites[a].role == Attachment::Role::Origin &&
                                    sites[b].role == Attachment::Role::Insertion
                              : (ends[a].at - centre).norm() <= (ends[b].at - centre).norm();
      const double distance = (ends[a].at - ends[b].at).norm();
      if (a == b || !fits || distance <= longest) continue;
      longest = distance;
      best = {a, b};
    }
  }
  return best;
}

}  // namespace

namespace {

// One attempt with so many control points; how much of the curve is still badly placed comes with
// it.
struct Bent {
  std::vector<Vector3> points;
  double astray = 0.0;  // mean push that is still wanted [m]
};

Bent bend(const Vector3& from, const Vector3& to, const Surroundings& around, int count) {
  std::vector<Vector3> points;
  for (int p = 0; p < count; ++p) points.push_back(from + (to - from) * p / (count - 1));
  points.back() = to;
  const double length = (to - from).norm();
  Bent best{points, std::numeric_limits<double>::infinity()};

  // Push samples of the curve, hand the pushes to the control points by their share in each sample
  constexpr int kRounds = 40;
  constexpr int kSamples = 32;
  const double clearance = std::min(kClearanceRel * around.diagonal, 0.05 * length);
  for (int round = 0; round < kRounds; ++round) {
    const mesh::Spline curve(points);
    std::vector<Vector3> move(points.size(), Vector3::Zero());
    std::vector<double> share(points.size(), 1e-12);
    double astray = 0.0;
    for (int k = 1; k < kSamples; ++k) {
      const double way = static_cast<double>(k) / kSamples;
      const double u = curve.parameterAt(way * curve.length());
      // Near the ends the curve has to touch the bone it comes from
      const double slope = std::min(1.0, 5.0 * std::min(way, 1.0 - way));
      const Vector3 push = pushOut(curve.at(u), clearance * slope, around);
      astray += slope * push.norm() / kSamples;
      if (push.isZero(0.0)) continue;
      const Eigen::VectorXd basis = curve.basis(u);
      for (std::size_t p = 1; p + 1 < points.size(); ++p) {
        const double weight = std::max(0.0, basis[static_cast<Eigen::Index>(p)]) * slope;
        move[p] += weight * push;
        share[p] += weight;
      }
    }
    if (astray < best.astray) best = {points, astray};
    if (astray < 0.02 * clearance) break;
    for (std::size_t p = 1; p + 1 < points.size(); ++p) points[p] += move[p] / share[p];

    // A detour this long is no bend, and points this close make loops: the artist knows better
    double way = 0.0, shortest = length;
    for (std::size_t p = 1; p < points.size(); ++p) {
      const double step = (points[p] - points[p - 1]).norm();
      way += step;
      shortest = std::min(shortest, step);
    }
    if (!(way < 1.6 * length) || shortest < 0.1 * length / count) break;
  }
  return best;
}

}  // namespace

std::vector<Vector3> bentCurve(const Vector3& from, const Vector3& to, const Surroundings& around,
                               int count) {
  if (count == 2 || from == to) return {from, to};
  Bent best = bend(from, to, around, count);
  // What four points cannot follow, a tail for one, more points may
  for (int more = count + 2; more <= 2 * count; more += 2) {
    if (best.astray < 5e-5 * around.diagonal) break;
    Bent finer = bend(from, to, around, more);
    if (finer.astray < 0.7 * best.astray) best = std::move(finer);
  }
  return best.points;
}

std::vector<bool> onRemovedHalf(const std::vector<MuscleSites>& table,
                                const model::CutPlane& symmetry, double diagonal) {
  std::unordered_map<std::string, double> height;
  for (const MuscleSites& muscle : table) {
    double sum = 0.0;
    for (const AttachmentSite& site : muscle.sites) sum += heightOver(symmetry, site.at);
    height[muscle.muscle] = sum / static_cast<double>(muscle.sites.size());
  }
  std::vector<bool> out;
  for (const MuscleSites& muscle : table) {
    const auto twinName = mirroredName(muscle.muscle);
    const auto twin = twinName ? height.find(*twinName) : height.end();
    const double own = height[muscle.muscle];
    const bool tells = twin != height.end() && std::abs(own - twin->second) > 2e-4 * diagonal;
    out.push_back(tells ? own < twin->second : own < -1e-3 * diagonal);
  }
  return out;
}

std::optional<model::Tissue> muscleFrom(const MuscleSites& table, const Surroundings& around,
                                        Findings& findings) {
  const auto leaveOut = [&](const char* kind, std::string message) {
    findings.push_back(
        {Severity::Note, kind, table.muscle, std::move(message), table.sites.front().at});
    return std::nullopt;
  };

  // What lies beyond the symmetry plane belongs to the other half
  std::vector<AttachmentSite> sites;
  std::optional<AttachmentSite> beyond;
  for (const AttachmentSite& site : table.sites) {
    const bool kept =
        !around.symmetry || heightOver(*around.symmetry, site.at) > -1e-3 * around.diagonal;
    if (kept) {
      sites.push_back(site);
    } else if (!beyond) {
      beyond = site;
    }
  }
  if (sites.empty()) {
    return leaveOut("other-half", fmt::format("{} lies on the side that the symmetry plane removes",
                                              table.muscle));
  }

  std::vector<End> ends;
  for (const AttachmentSite& site : sites) ends.push_back(seated(site, around));
  if (sites.size() == 1 && beyond) {
    // From the one kept site towards the other half, as far as the plane
    const model::CutPlane& plane = *around.symmetry;
    const Vector3 a = ends[0].at;
    const double ha = heightOver(plane, a), hb = heightOver(plane, beyond->at);
    sites.push_back(*beyond);
    sites[1].role = Attachment::Role::Unknown;
    ends.push_back({a + (beyond->at - a) * ha / (ha - hb), {Support::On::Plane, plane.name}});
  }
  // An end on the removed side of the plane would be cut off
  for (End& end : ends) {
    if (around.symmetry && heightOver(*around.symmetry, end.at) < 0.0) {
      end.at -= heightOver(*around.symmetry, end.at) * around.symmetry->normal;
    }
  }

  const auto pair = farthestPair(sites, ends, around.centre);
  if (!pair || (ends[pair->first].at - ends[pair->second].at).norm() < 1e-3 * around.diagonal) {
    return leaveOut(
        "too-few-sites",
        fmt::format("{} has no two attachments apart from each other; draw its curve by hand",
                    table.muscle));
  }
  const auto& [first, last] = *pair;
  model::Tissue muscle{
      .name = table.muscle, .kind = model::Tissue::Kind::Muscle, .side = sideFrom(table.muscle)};
  model::Curve curve;
  curve.start = ends[first].support;
  curve.end = ends[last].support;
  // Thick in the middle, as muscles are
  std::vector<Vector3> points = bentCurve(ends[first].at, ends[last].at, around);
  for (Vector3& p : points) p = rounded(p, around.diagonal);
  if (shareOutside(points, around.skin) > 0.1) {
    return leaveOut(
        "no-way",
        fmt::format("{} would leave the skin on its way between its attachments; are all of "
                    "them its own? Draw its curve by hand",
                    table.muscle));
  }
  for (std::size_t p = 0; p < points.size(); ++p) {
    const bool atEnd = p == 0 || p + 1 == points.size();
    curve.points.push_back({points[p], atEnd ? 0.5 : 1.0});
  }
  muscle.curves.push_back(std::move(curve));
  for (std::size_t k = 0; k < sites.size(); ++k) {
    if (ends[k].support.on == Support::On::Plane) continue;
    Attachment attachment{sites[k].role, ends[k].support, sites[k].at, std::nullopt};
    if (attachment.role == Attachment::Role::Unknown && k == first)
      attachment.role = Attachment::Role::Origin;
    if (attachment.role == Attachment::Role::Unknown && k == last)
      attachment.role = Attachment::Role::Insertion;
    if (!sites[k].patchFile.empty())
      attachment.patch = model::MeshRef{.file = sites[k].patchFile, .part = {}, .unit = {}};
    muscle.attachments.push_back(std::move(attachment));
  }
  return muscle;
}

}  // namespace ecorche::authoring
