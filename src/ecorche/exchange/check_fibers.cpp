#include <ecorche/exchange/check_parts.h>
#include <ecorche/fiber/curve_tets.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace ecorche::exchange {

namespace {

bool isMuscle(const CheckedFiles& files, std::int32_t id) {
  const TissueRecord* tissue = files.tissue(id);
  return tissue != nullptr && tissue->kind == "muscle";
}

// Unit and finite in muscles, zero elsewhere; at vertices unit where a muscle touches.
void checkUnit(const CheckedFiles& files, Checks& checks) {
  const AnatomyFile& a = *files.vtu;
  Check c{"fibers-unit"};
  c.limit = 1e-9;
  std::int64_t bad = 0;
  const auto note = [&](double off, const Eigen::Vector3d& at) {
    // NaN compares false with everything: it must not slip through
    if (off <= c.limit) return;
    if (bad++ == 0) c.point = at;
    c.value = std::isfinite(off) ? std::max(c.value, off) : INFINITY;
  };
  std::vector<bool> touched(static_cast<std::size_t>(a.mesh.V.rows()), false);
  for (Eigen::Index t = 0; t < a.mesh.T.rows(); ++t) {
    const bool muscle = isMuscle(files, a.tissue[static_cast<std::size_t>(t)]);
    note(std::abs(a.tetFiber.row(t).norm() - (muscle ? 1.0 : 0.0)), files.centroid(t));
    for (int k = 0; muscle && k < 4; ++k) touched[static_cast<std::size_t>(a.mesh.T(t, k))] = true;
  }
  for (Eigen::Index v = 0; v < a.vertexFiber.rows(); ++v) {
    const double due = touched[static_cast<std::size_t>(v)] ? 1.0 : 0.0;
    note(std::abs(a.vertexFiber.row(v).norm() - due), a.mesh.V.row(v).transpose());
  }
  c.pass = bad == 0;
  c.detail = fmt::format(
      "{} tets and points whose fibre is not of length 1 in muscle and 0 elsewhere", bad);
  checks.push_back(std::move(c));
}

// The flow rises along an edge where a tet's fibre at that edge points along it: directions alone
// tell where it is higher, or lower, than at all neighbours. On a muscle's surface bumps have such
// places by right.
void checkExtrema(const CheckedFiles& files, Checks& checks) {
  const AnatomyFile& a = *files.vtu;
  constexpr std::uint8_t kRises = 1;
  constexpr std::uint8_t kFalls = 2;
  constexpr std::int32_t kNone = -1;
  constexpr std::int32_t kSurface = -2;
  const auto vertexCount = static_cast<std::size_t>(a.mesh.V.rows());
  std::vector<std::int32_t> owner(vertexCount, kNone);  // of inner vertices their only tissue
  std::vector<std::uint8_t> ways(vertexCount, 0);       // in which the flow goes away from it
  for (Eigen::Index t = 0; t < a.mesh.T.rows(); ++t) {
    const std::int32_t id = a.tissue[static_cast<std::size_t>(t)];
    for (int k = 0; k < 4; ++k) {
      const std::int32_t v = a.mesh.T(t, k);
      std::int32_t& mine = owner[static_cast<std::size_t>(v)];
      mine = mine == kNone || mine == id ? id : kSurface;
      for (int n = 0; n < 4; ++n) {
        if (n == k) continue;
        const double rise = a.tetFiber.row(t).dot(a.mesh.V.row(a.mesh.T(t, n)) - a.mesh.V.row(v));
        ways[static_cast<std::size_t>(v)] |= rise > 0.0 ? kRises : rise < 0.0 ? kFalls : 0;
      }
    }
  }
  for (Eigen::Index f = 0; f < files.boundary.F.rows(); ++f) {
    for (int k = 0; k < 3; ++k) {
      owner[static_cast<std::size_t>(files.boundary.F(f, k))] = kSurface;
    }
  }

  Check c{"fibers-no-extrema"};
  c.limit = 0.005;
  for (const TissueRecord& tissue : files.record.tissues) {
    if (tissue.kind != "muscle" || static_cast<std::size_t>(tissue.id) >= files.tetsOf.size())
      continue;
    std::vector<std::int32_t> vertices;
    for (const std::int32_t t : files.tetsOf[static_cast<std::size_t>(tissue.id)]) {
      for (int k = 0; k < 4; ++k) vertices.push_back(a.mesh.T(t, k));
    }
    std::ranges::sort(vertices);
    vertices.erase(std::ranges::unique(vertices).begin(), vertices.end());
    if (vertices.empty()) continue;
    const auto extrema = std::ranges::count_if(vertices, [&](std::int32_t v) {
      const auto i = static_cast<std::size_t>(v);
      return owner[i] == tissue.id && (ways[i] == kRises || ways[i] == kFalls);
    });
    const double share = static_cast<double>(extrema) / static_cast<double>(vertices.size());
    if (share > c.value) {
      c.value = share;
      c.object = tissue.name;
    }
  }
  c.pass = c.value <= c.limit;
  c.detail = c.value > 0.0 ? fmt::format(
                                 "the flow has extrema inside \"{}\", at {:.2f} % of its "
                                 "vertices, the largest share of all",
                                 c.object, 100.0 * c.value)
                           : "no flow begins or ends inside a muscle";
  checks.push_back(std::move(c));
}

struct Worst {
  double value = 0.0;
  std::string object;
};

void checkDirections(const CheckedFiles& files, Checks& checks) {
  const AnatomyFile& a = *files.vtu;
  Worst angle;
  Worst backward;
  std::int64_t beyond = 0;
  for (const TissueRecord& tissue : files.record.tissues) {
    if (tissue.kind != "muscle" || static_cast<std::size_t>(tissue.id) >= files.tetsOf.size())
      continue;
    double sum = 0.0;
    double against = 0.0;
    std::int64_t count = 0;
    for (const CurveRecord& curve : tissue.curves) {
      for (const auto& hit : fiber::tetsOnCurve(
               a.mesh, files.tetsOf[static_cast<std::size_t>(tissue.id)], curve.points)) {
        const double cosine =
            std::clamp(a.tetFiber.row(hit.tet).dot(hit.tangent.transpose()), -1.0, 1.0);
        sum += std::acos(cosine) * 180.0 / std::numbers::pi;
        against += cosine < 0.0;
        ++count;
      }
    }
    if (count == 0) continue;
    const double mean = sum / static_cast<double>(count);
    beyond += !(mean <= 15.0);
    if (!(mean <= angle.value)) angle = {mean, tissue.name};
    if (against / static_cast<double>(count) > backward.value)
      backward = {against / static_cast<double>(count), tissue.name};
  }
  Check follow{"fibers-follow-curves"};
  follow.limit = 15.0;
  follow.value = angle.value;
  follow.object = angle.object;
  follow.pass = beyond == 0;
  follow.detail = fmt::format(
      "largest mean angle to the curve in tets on it is {:.1f}° (\"{}\"); {} muscles beyond",
      angle.value, angle.object, beyond);
  checks.push_back(std::move(follow));

  Check forward{"fibers-origin-to-insertion"};
  forward.limit = 0.05;
  forward.value = backward.value;
  forward.object = backward.object;
  forward.pass = forward.value <= forward.limit;
  forward.detail = backward.value > 0.0
                       ? fmt::format("\"{}\" runs backwards in {:.1f} % of the tets on its curves",
                                     backward.object, 100.0 * backward.value)
                       : "no fibre on a curve runs backwards";
  checks.push_back(std::move(forward));
}

}  // namespace

void checkFibers(const CheckedFiles& files, Checks& checks) {
  if (!files.vtu || files.vtu->tetFiber.rows() == 0) return;
  checkUnit(files, checks);
  checkDirections(files, checks);
  checkExtrema(files, checks);
}

}  // namespace ecorche::exchange
