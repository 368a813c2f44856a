#include <ecorche/core/index.h>
#include <ecorche/core/parallel.h>
#include <ecorche/engine/bench_adaptive.h>
#include <ecorche/envelope/tissue_surface.h>
#include <ecorche/mesh/surface_query.h>
#include <ecorche/model/project_check.h>
#include <ecorche/tissue/solve_tissues.h>

#include <algorithm>
#include <cmath>

namespace ecorche::engine {

namespace {

using mesh::Vector3;

constexpr Eigen::Index kMostAsked = 20'000;  // faces of one muscle that are measured from

// Where a muscle meets other tissues, one per muscle.
struct Interfaces {
  std::int64_t tets = 0;
  std::int64_t vertices = 0;
  std::vector<mesh::SurfaceMesh> of;
};

struct Weighed {
  double distance = 0.0;
  double area = 0.0;
};

mesh::SurfaceMesh betweenTissues(const envelope::TissueSurface& surface) {
  mesh::SurfaceMesh out;
  out.V = surface.mesh.V;
  out.F.resize(surface.mesh.F.rows(), 3);
  Eigen::Index count = 0;
  for (Eigen::Index f = 0; f < surface.mesh.F.rows(); ++f) {
    if (surface.beyond[toIndex(f)].tissue != kNoTissue) out.F.row(count++) = surface.mesh.F.row(f);
  }
  out.F.conservativeResize(count, 3);
  return out;
}

Result<Interfaces> interfacesOn(const model::Project& project, const ProjectMeshes& meshes,
                                std::int64_t tets, Sizing sizing, RunContext& run) {
  auto built = buildDomainOf(project, meshes, {.tets = tets, .sizing = sizing}, run);
  if (!built) return passOn(built);
  const auto tissues = curveTissues(project);
  auto solved = tissue::solveTissues(built->domain, tissues, tissueOptions(project), run);
  if (!solved) return passOn(solved);
  auto anatomy = envelope::buildAnatomy(built->domain, solved->fields, solved->cores, {}, run);
  if (!anatomy) return passOn(anatomy);
  const auto names = fieldNames(tissues);
  Interfaces out;
  out.tets = built->domain.mesh.T.rows();
  out.vertices = built->domain.mesh.V.rows();
  for (const auto& surface : envelope::tissueSurfaces(anatomy->anatomy, names)) {
    if (surface.tissue != kFat) out.of.push_back(betweenTissues(surface));
  }
  return out;
}

// From middles of faces, evenly through the list where there are more than enough.
void addDistances(const mesh::SurfaceMesh& from, const mesh::SurfaceMesh& to,
                  std::vector<Weighed>& all) {
  if (from.F.rows() == 0 || to.F.rows() == 0) return;
  const mesh::SurfaceQuery query(to);
  const Eigen::Index count = std::min(kMostAsked, from.F.rows());
  const double each = static_cast<double>(from.F.rows()) / static_cast<double>(count);
  std::vector<Weighed> found(toIndex(count));
  parallelFor(
      count,
      [&](std::int64_t i) {
        const auto f = static_cast<Eigen::Index>(static_cast<double>(i) * each);
        const auto corner = [&](int k) { return Vector3(from.V.row(from.F(f, k)).transpose()); };
        const Vector3 a = corner(0), b = corner(1), c = corner(2);
        found[toIndex(i)] = {query.distance((a + b + c) / 3.0),
                             0.5 * each * (b - a).cross(c - a).norm()};
      },
      64);
  all.insert(all.end(), found.begin(), found.end());
}

InterfaceError errorOf(const Interfaces& now, const Interfaces& reference) {
  std::vector<Weighed> all;
  for (std::size_t i = 0; i < now.of.size(); ++i) {
    addDistances(now.of[i], reference.of[i], all);
    addDistances(reference.of[i], now.of[i], all);
  }
  std::ranges::sort(all, {}, &Weighed::distance);
  double area = 0.0;
  for (const Weighed& w : all) area += w.area;
  InterfaceError out;
  double before = 0.0;
  for (const Weighed& w : all) {
    out.mean += w.distance * w.area / area;
    out.rms += w.distance * w.distance * w.area / area;
    if (before < 0.95 * area) out.p95 = w.distance;
    before += w.area;
  }
  out.rms = std::sqrt(out.rms);
  return out;
}

// Errors fall as a power of the tets between two uniform domains.
void compare(AdaptiveCase& c, const std::vector<AdaptiveCase>& uniform) {
  const auto share = [&](double tets) { return tets / static_cast<double>(c.tets); };
  if (c.error.mean < uniform.back().error.mean) {
    c.saved = share(static_cast<double>(uniform.back().tets));
    c.savesMore = true;
  }
  for (std::size_t i = 1; i < uniform.size(); ++i) {
    const AdaptiveCase& coarse = uniform[i - 1];
    const AdaptiveCase& fine = uniform[i];
    if (c.error.mean > coarse.error.mean || c.error.mean < fine.error.mean) continue;
    const double part =
        std::log(coarse.error.mean / c.error.mean) / std::log(coarse.error.mean / fine.error.mean);
    c.saved =
        share(static_cast<double>(coarse.tets) *
              std::pow(static_cast<double>(fine.tets) / static_cast<double>(coarse.tets), part));
  }
}

}  // namespace

Result<AdaptiveBench> benchAdaptive(const model::Project& project, std::vector<std::int64_t> tets,
                                    std::int64_t reference, RunContext& run) {
  if (auto sound = model::checkProject(project); !sound) return passOn(sound);
  auto meshes = loadMeshes(project, run);
  if (!meshes) return passOn(meshes);
  std::ranges::sort(tets);
  const auto fine = interfacesOn(project, *meshes, reference, Sizing::Draft, run);
  if (!fine) return passOn(fine);
  AdaptiveBench out;
  out.referenceTets = fine->tets;
  std::vector<AdaptiveCase> uniform;
  for (const Sizing sizing : {Sizing::None, Sizing::Curves, Sizing::Draft}) {
    for (const std::int64_t wanted : tets) {
      const auto now = interfacesOn(project, *meshes, wanted, sizing, run);
      if (!now) return passOn(now);
      AdaptiveCase c{sizing, now->tets, now->vertices, errorOf(*now, *fine), {}, false};
      if (sizing == Sizing::None) {
        uniform.push_back(c);
      } else {
        compare(c, uniform);
      }
      out.cases.push_back(c);
      if (run.cancelled()) return fail(ErrorCode::Cancelled, "stopped between two domains");
    }
  }
  return out;
}

}  // namespace ecorche::engine
