#include <ecorche/authoring/solid_bone.h>
#include <ecorche/domain/carve.h>
#include <ecorche/domain/wrap.h>
#include <ecorche/mesh/surface_repair.h>

#include <fmt/format.h>

namespace ecorche::authoring {

Result<BoneSurface> solidBone(std::string name, const mesh::SurfaceMesh& mesh, double wrapTolerance,
                              Findings& findings, RunContext& run) {
  BoneSurface out = boneSurface(std::move(name), mesh);
  if (out.solid || out.surface->empty()) return out;

  const auto repaired = mesh::repairSurface(mesh, {}, run);
  if (run.cancelled()) return fail(ErrorCode::Cancelled, "making bones solid");
  if (!repaired) return out;
  if (const BoneSurface mended = boneSurface(out.name, repaired->mesh); mended.solid) {
    out.solid = mended.solid;
    return out;
  }
  const domain::Hole hole{out.name, repaired->mesh, {}, false};
  const auto around = domain::wrap({&hole}, wrapTolerance, run);
  if (run.cancelled()) return fail(ErrorCode::Cancelled, "making bones solid");
  if (!around) return out;
  out.solid = std::make_shared<mesh::SurfaceQuery>(around->V, around->F);
  findings.push_back({Severity::Note, "open-bone", out.name,
                      fmt::format("\"{}\" is not closed; curves keep out of a closed surface "
                                  "around it, {:.2g} mm wide of it at most",
                                  out.name, wrapTolerance * 1e3),
                      out.box.centre()});
  return out;
}

}  // namespace ecorche::authoring
