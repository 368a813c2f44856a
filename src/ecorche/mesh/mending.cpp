#include <ecorche/mesh/face_repair.h>
#include <ecorche/mesh/mending.h>
#include <ecorche/mesh/outer_hull.h>
#include <ecorche/mesh/surface_check.h>
#include <ecorche/mesh/surface_query.h>
#include <ecorche/mesh/surface_topology.h>
#include <ecorche/mesh/surface_wrap.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>

namespace ecorche::mesh {

namespace {

struct Word {
  Mending how;
  std::string_view word;
};
constexpr std::array<Word, 4> kWords{{{Mending::None, "none"},
                                      {Mending::FillHoles, "fill-holes"},
                                      {Mending::OuterHull, "outer-hull"},
                                      {Mending::Wrap, "wrap"}}};

/// Every closed piece outward, also those that were walls of hollows.
SurfaceMesh allOutward(SurfaceMesh mesh) {
  const FaceComponents pieces = components(mesh.F);
  const auto check = checkSurface(mesh).components;
  for (Eigen::Index f = 0; f < mesh.F.rows(); ++f) {
    const auto piece = static_cast<std::size_t>(pieces.label[static_cast<std::size_t>(f)]);
    if (check[piece].inward) std::swap(mesh.F(f, 1), mesh.F(f, 2));
  }
  return mesh;
}

class Mender {
 public:
  Mender(const SurfaceMesh& mesh, Mending how, RunContext& run)
      : mesh_(mesh), how_(how), run_(run) {}

  Result<RepairedSurface> operator()() {
    const bool hull = how_ == Mending::OuterHull;
    auto closed =
        repairSurface(mesh_,
                      hull ? RepairOptions{.mustClose = true}
                           : RepairOptions{.holeRel = std::numeric_limits<double>::infinity(),
                                           .mustClose = how_ == Mending::FillHoles,
                                           .leaveOutSheets = true},
                      run_);
    if (!closed) return closed;
    if (how_ == Mending::FillHoles) return closed;
    auto out = hull ? outermost(*closed) : wrapped(*closed);
    if (!out) return out;
    // What the repair left to be seen is of no interest once it is wrapped or gone
    for (const Finding& finding : closed->findings) {
      if (finding.severity == Severity::Repaired) out->findings.push_back(finding);
    }
    std::rotate(out->findings.begin(), out->findings.begin() + 1, out->findings.end());
    return out;
  }

 private:
  Result<RepairedSurface> outermost(const RepairedSurface& closed) {
    const double before = signedVolume(closed.mesh.V, closed.mesh.F);
    auto hull = outerHull(allOutward(closed.mesh), run_);
    if (run_.cancelled()) return fail(ErrorCode::Cancelled, "mending was interrupted");
    if (!hull) {
      return fail(ErrorCode::MeshNotRepairable,
                  fmt::format("\"{}\" has no exact outer hull (faces lie upon one another); ask "
                              "for \"wrap\" instead of \"outer-hull\"",
                              mesh_.name),
                  {.object = mesh_.name});
    }
    RepairedSurface out{.mesh = std::move(*hull), .findings = {}};
    const double after = signedVolume(out.mesh.V, out.mesh.F);
    tell(
        out, "outer-hull",
        fmt::format("\"{}\": as asked, only what is seen from outside was kept, {} of {} faces; "
                    "it encloses {:.4g} cm³, before {:.4g} cm³",
                    mesh_.name, out.mesh.F.rows(), closed.mesh.F.rows(), after * 1e6, before * 1e6),
        boundingBox(out.mesh).centre(), after - before);
    return out;
  }

  Result<RepairedSurface> wrapped(const RepairedSurface& closed) {
    const double diagonal = boundingBox(closed.mesh).diagonal();
    auto wrap = wrapSurface(closed.mesh, kWrapGapRel * diagonal, kWrapOffsetRel * diagonal, run_);
    if (!wrap) return passOn(wrap);
    const auto apart = surfaceDeviation(closed.mesh, *wrap, 0.25 * kWrapGapRel * diagonal, run_);
    if (!apart) return passOn(apart);
    const bool fromMesh = apart->aToB.max > apart->bToA.max;
    RepairedSurface out{.mesh = std::move(*wrap), .findings = {}};
    tell(out, "wrap",
         fmt::format("\"{}\": as asked, it was wrapped; the wrap lies up to {:.3g} mm from the "
                     "mesh (mean {:.3g} mm), the mesh up to {:.3g} mm from the wrap (mean {:.3g} "
                     "mm)",
                     mesh_.name, apart->bToA.max * 1e3, apart->bToA.mean * 1e3,
                     apart->aToB.max * 1e3, apart->aToB.mean * 1e3),
         fromMesh ? apart->aToB.place : apart->bToA.place, apart->max());
    return out;
  }

  void tell(RepairedSurface& out, const char* kind, std::string message, const Vector3& place,
            double size) const {
    out.findings.push_back({.severity = Severity::Repaired,
                            .kind = kind,
                            .object = mesh_.name,
                            .message = std::move(message),
                            .point = place,
                            .size = size});
  }

  const SurfaceMesh& mesh_;
  Mending how_;
  RunContext& run_;
};

}  // namespace

std::string_view name(Mending how) { return std::ranges::find(kWords, how, &Word::how)->word; }

std::optional<Mending> mendingNamed(std::string_view word) {
  const auto known = std::ranges::find(kWords, word, &Word::word);
  if (known == kWords.end()) return std::nullopt;
  return known->how;
}

Result<RepairedSurface> mendSurface(const SurfaceMesh& mesh, Mending how, RunContext& run) {
  if (how == Mending::None) return RepairedSurface{.mesh = mesh, .findings = {}};
  const Stage stage(run, "mending");
  return Mender(mesh, how, run)();
}

}  // namespace ecorche::mesh
