#include <ecorche/core/contract.h>
#include <ecorche/core/files.h>
#include <ecorche/core/subprocess.h>
#include <ecorche/mesh/import_file.h>
#include <ecorche/mesh/read_mesh.h>
#include <ecorche/mesh/read_obj.h>
#include <ecorche/mesh/read_off.h>
#include <ecorche/mesh/read_ply.h>
#include <ecorche/mesh/read_stl.h>
#include <ecorche/mesh/weld.h>
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstring>
#include <iterator>
#include <set>

namespace ecorche::mesh {

namespace fs = std::filesystem;

namespace {

// What Assimp of Debian 12 reads and is a surface, without the formats that we read.
constexpr std::string_view kForeignSuffixes[] = {
    "glb", "gltf", "fbx", "dae", "3ds", "3mf", "blend", "x",    "x3d", "wrl",
    "lwo", "lws",  "ase", "ac",  "cob", "dxf", "ms3d",  "ogex", "amf", "zgl"};

std::string suffixOf(const fs::path& file) {
  std::string suffix = file.extension().string();
  if (!suffix.empty()) suffix.erase(0, 1);
  std::ranges::transform(suffix, suffix.begin(), [](unsigned char c) { return std::tolower(c); });
  return suffix;
}

bool isForeign(std::string_view suffix) {
  return std::ranges::find(kForeignSuffixes, suffix) != std::end(kForeignSuffixes);
}

std::string_view firstWord(std::string_view bytes) {
  constexpr std::string_view kBlank = " \t\r\n";
  const auto begin = bytes.find_first_not_of(kBlank);
  if (begin == bytes.npos) return {};
  bytes.remove_prefix(begin);
  return bytes.substr(0, bytes.find_first_of(kBlank));
}

bool isBinaryStl(std::string_view bytes) {
  if (bytes.size() < 84) return false;
  std::uint32_t count = 0;
  std::memcpy(&count, bytes.data() + 80, sizeof count);
  return count > 0 && bytes.size() == 84 + 50 * std::size_t{count};
}

Result<SurfaceMesh> readThroughWorker(const fs::path& file, RunContext& run) {
  auto scratch = ScratchFolder::create();
  if (!scratch) return passOn(scratch);
  const fs::path result = scratch->path() / "mesh";

  const ProcessOptions options{.timeout = 300.0, .memoryLimit = workerMemoryLimit()};
  const auto atFile = [&](Error error) {
    if (error.place.file.empty()) error.place.file = file.string();
    return tl::unexpected(std::move(error));
  };
  const auto end =
      runWorker({"import", fs::absolute(file).string(), result.string()}, options, run);
  if (!end) return atFile(end.error());
  const auto bytes = readFile(result);
  if (!bytes) {
    return fail(ErrorCode::WorkerCrashed, "ecorche-worker left no result", {.file = file.string()});
  }
  auto mesh = decodeImport(*bytes);
  if (!mesh) return atFile(mesh.error());

  if (mesh->empty()) {
    return fail(ErrorCode::MeshWithoutFaces, "the file holds no triangles; export it again",
                {.file = file.string()});
  }
  for (Eigen::Index v = 0; v < mesh->V.rows(); ++v) {
    if (!mesh->V.row(v).allFinite()) {
      return fail(
          ErrorCode::NonFiniteVertex,
          fmt::format("vertex {} is ({}, {}, {}); remove or place it where the mesh was made",
                      v + 1, mesh->V(v, 0), mesh->V(v, 1), mesh->V(v, 2)),
          {.file = file.string()});
    }
  }
  return weldExact(*mesh);
}

/// Parts are asked for by name: those without one get one, later ones of the same are numbered.
void tellPartsApart(std::vector<Part>& parts) {
  std::set<std::string> given;
  for (const Part& part : parts) given.insert(part.name);
  std::set<std::string> taken;
  for (std::size_t p = 0; p < parts.size(); ++p) {
    std::string& name = parts[p].name;
    if (name.empty()) name = fmt::format("part {}", p + 1);
    const std::string stem = name;
    for (int k = 2; taken.contains(name) || (name != stem && given.contains(name)); ++k)
      name = fmt::format("{}_{}", stem, k);
    taken.insert(name);
  }
}

}  // namespace

Result<MeshFormat> meshFormat(std::string_view bytes, const fs::path& file) {
  const std::string_view word = firstWord(bytes.substr(0, 1024));
  const std::string suffix = suffixOf(file);
  const bool text = bytes.substr(0, 4096).find('\0') == bytes.npos;

  if (bytes.starts_with("ply\n") || bytes.starts_with("ply\r")) return MeshFormat::Ply;
  if (bytes.starts_with("glTF") || bytes.starts_with("Kaydara FBX Binary"))
    return MeshFormat::Foreign;
  if (word.ends_with("OFF") && word.size() <= 7 && text) return MeshFormat::Off;
  if (isForeign(suffix)) return MeshFormat::Foreign;
  if (suffix == "stl" || isBinaryStl(bytes)) return MeshFormat::Stl;
  if (word == "solid" && text && bytes.substr(0, 4096).find("facet") != bytes.npos)
    return MeshFormat::Stl;
  if (suffix == "off" && text) return MeshFormat::Off;
  if (suffix == "obj" && text) return MeshFormat::Obj;
  constexpr std::string_view kObjKeys[] = {"v", "o", "g", "mtllib"};
  if (text && suffix != "ply" && std::ranges::find(kObjKeys, word) != std::end(kObjKeys))
    return MeshFormat::Obj;
  return fail(ErrorCode::FileUnknownFormat,
              "this is no mesh that can be read; OBJ, PLY, STL, OFF, GLB, glTF and FBX can",
              {.file = file.string()});
}

bool isMeshFile(const fs::path& file) {
  const std::string suffix = suffixOf(file);
  return suffix == "obj" || suffix == "ply" || suffix == "stl" || suffix == "off" ||
         isForeign(suffix);
}

Result<SurfaceMesh> readMesh(const fs::path& file, const ReadOptions& options, RunContext& run) {
  EC_REQUIRE(options.metresPerUnit > 0.0 && std::isfinite(options.metresPerUnit));
  const Stage stage(run, "reading");
  const auto bytes = readFile(file);
  if (!bytes) return passOn(bytes);
  const auto format = meshFormat(*bytes, file);
  if (!format) return passOn(format);

  const std::string name = file.string();
  auto mesh = [&]() -> Result<SurfaceMesh> {
    switch (*format) {
      case MeshFormat::Obj:
        return parseObj(*bytes, name, run);
      case MeshFormat::Ply:
        return parsePly(*bytes, name, run);
      case MeshFormat::Stl:
        return parseStl(*bytes, name, run);
      case MeshFormat::Off:
        return parseOff(*bytes, name, run);
      case MeshFormat::Foreign:
        break;
    }
    return readThroughWorker(file, run);
  }();
  if (!mesh) return mesh;
  mesh->name = file.stem().string();
  tellPartsApart(mesh->parts);
  mesh->V *= options.metresPerUnit;
  if (!mesh->V.allFinite()) {
    return fail(ErrorCode::NonFiniteVertex, "the coordinates are too large for this unit",
                {.file = name});
  }
  return mesh;
}

}  // namespace ecorche::mesh
