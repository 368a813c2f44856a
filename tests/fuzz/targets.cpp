#include "fuzz/targets.h"

#include <ecorche/mesh/import_file.h>
#include <ecorche/mesh/read_obj.h>
#include <ecorche/mesh/read_off.h>
#include <ecorche/mesh/read_ply.h>
#include <ecorche/mesh/read_stl.h>
#include <ecorche/mesh/surface_check.h>
#include <ecorche/mesh/surface_repair.h>
#include <ecorche/model/command_text.h>
#include <ecorche/model/project_check.h>
#include <ecorche/model/project_file.h>

namespace ecorche::test {

namespace {

using mesh::SurfaceMesh;

void checkIndices(const SurfaceMesh& mesh) {
  for (const std::int32_t v : mesh.F.reshaped())
    demand(v >= 0 && v < mesh.V.rows(), "a face names a vertex that is not there");
  std::int64_t next = 0;
  for (const auto& part : mesh.parts) {
    demand(part.firstFace == next && part.faceCount >= 0, "parts are not in face order");
    next += part.faceCount;
  }
  demand(mesh.parts.empty() || next == mesh.F.rows(), "parts do not cover the faces");
}

template <Result<SurfaceMesh> (*parse)(std::string_view, const std::string&, RunContext&)>
void read(std::string_view bytes) {
  RunContext run;
  const auto mesh = parse(bytes, "fuzz", run);
  if (!mesh) {
    demand(!mesh.error().message.empty() && mesh.error().place.file == "fuzz",
           "an error without a sentence or a place");
    return;
  }
  demand(!mesh->empty(), "a mesh without faces");
  demand(mesh->V.allFinite(), "a vertex that is no number");
  checkIndices(*mesh);
}

void import(std::string_view bytes) {
  if (const auto mesh = mesh::decodeImport(bytes)) checkIndices(*mesh);
}

// Bytes become a small surface: vertices on a coarse grid, so that coincidences of every kind are
// frequent.
void repair(std::string_view bytes) {
  constexpr int kSide = 4;
  constexpr std::size_t kMostFaces = 200;
  SurfaceMesh mesh;
  mesh.name = "fuzz";
  mesh.V.resize(kSide * kSide * kSide, 3);
  for (int v = 0; v < mesh.V.rows(); ++v)
    mesh.V.row(v) << v % kSide, v / kSide % kSide, v / (kSide * kSide);
  const std::size_t faces = std::min(bytes.size() / 3, kMostFaces);
  mesh.F.resize(static_cast<Eigen::Index>(faces), 3);
  for (std::size_t f = 0; f < faces; ++f) {
    for (std::size_t k = 0; k < 3; ++k) {
      mesh.F(static_cast<Eigen::Index>(f), static_cast<Eigen::Index>(k)) =
          static_cast<unsigned char>(bytes[3 * f + k]) % (kSide * kSide * kSide);
    }
  }
  RunContext run;
  const auto mended = mesh::repairSurface(mesh, {.holeRel = 0.5}, run);
  if (!mended) return;
  checkIndices(mended->mesh);
  const auto check = mesh::checkSurface(mended->mesh, {.selfIntersections = true});
  demand(check.nonManifoldEdges == 0 && check.nonManifoldVertices == 0,
         "repaired, but no manifold");
  demand(check.inconsistentEdges == 0, "repaired, but faces do not agree about their sides");
  demand(check.duplicateFaces == 0, "repaired, but faces are doubled");
}

// What is read can be built upon, and comes back from its own text.
void project(std::string_view bytes) {
  const auto project = model::parseProject(bytes, "fuzz");
  if (!project) {
    demand(!project.error().message.empty() && project.error().place.file == "fuzz",
           "an error without a sentence or a place");
    return;
  }
  demand(!model::findFault(*project), "a project with a fault");
  const auto again = model::parseProject(model::projectText(*project), "fuzz");
  demand(again.has_value() && *again == *project, "a project that its own text does not give back");
}

void script(std::string_view bytes) {
  const auto lines = model::parseScript(bytes, "fuzz");
  if (!lines) {
    demand(!lines.error().message.empty() && lines.error().place.file == "fuzz",
           "an error without a sentence or a place");
    return;
  }
  for (const model::ScriptLine& line : *lines) {
    const auto again = model::parseCommand(model::formatCommand(line.command));
    demand(again.has_value() && *again == line.command,
           "a command that its own text does not give back");
  }
}

constexpr FuzzTarget kInputTargets[] = {
    {"obj", read<mesh::parseObj>},
    {"ply", read<mesh::parsePly>},
    {"stl", read<mesh::parseStl>},
    {"off", read<mesh::parseOff>},
    {"import", import},
    {"repair", repair},
    {"project", project},
    {"script", script},
};

}  // namespace

std::span<const FuzzTarget> inputTargets() { return kInputTargets; }

}  // namespace ecorche::test
