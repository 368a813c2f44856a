#include <ecorche/core/contract.h>
#include <ecorche/core/files.h>
#include <ecorche/exchange/file_names.h>
#include <ecorche/exchange/output_folder.h>
#include <ecorche/exchange/vtu.h>
#include <ecorche/mesh/write_mesh.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace ecorche::exchange {

namespace fs = std::filesystem;

namespace {

// File of every tissue's surface, relative to the folder; empty where none is written.
std::vector<std::string> tissueFiles(const OutputContents& c) {
  std::vector<std::string> muscleNames;
  for (const auto& tissue : c.tissues) muscleNames.push_back(tissue.name);
  const std::vector<std::string> safe = fileNames(muscleNames);
  std::vector<std::string> files(c.surfaces.size());
  for (std::size_t i = 0; i < files.size(); ++i) {
    if (c.surfaces[i].empty()) continue;
    if (i == 0) {
      files[i] = "fat.obj";
    } else if (!c.tissues[i - 1].filler) {
      files[i] = "muscles/" + safe[i - 1] + ".obj";
    }
  }
  return files;
}

std::vector<std::string> originalFiles(const std::vector<OriginalSurface>& originals) {
  std::vector<std::string> names;
  for (const OriginalSurface& o : originals) names.push_back(o.name);
  const std::vector<std::string> safe = fileNames(names);
  std::vector<std::string> files;
  for (std::size_t i = 0; i < originals.size(); ++i) {
    if (originals[i].kind == "skin") {
      files.emplace_back("skin.obj");
    } else {
      files.push_back(
          fmt::format("{}/{}.obj", originals[i].kind == "bone" ? "bones" : "others", safe[i]));
    }
  }
  return files;
}

ModelRecord recordOf(const OutputContents& c, const std::vector<std::string>& tissueFile,
                     const std::vector<std::string>& originalFile) {
  ModelRecord record;
  record.skinDiagonal = c.domain.skinDiagonal;
  record.surfaceTolerance = c.surfaceTolerance;
  record.tissues.push_back({kFat.value, "fat", "fat", tissueFile[0], {}});
  for (std::size_t i = 0; i < c.tissues.size(); ++i) {
    const tissue::CurveTissue& tissue = c.tissues[i];
    TissueRecord entry{kFirstMuscle.value + static_cast<std::int32_t>(i),
                       tissue.name,
                       tissue.filler ? "filler" : "muscle",
                       tissueFile[i + 1],
                       {}};
    for (const auto& curve : tissue.curves) {
      entry.curves.push_back({curve.name, curve.spline.sample(curve.spline.length() / 200).point});
    }
    record.tissues.push_back(std::move(entry));
  }
  for (std::size_t i = 0; i < c.originals.size(); ++i) {
    record.surfaces.push_back({c.originals[i].name, c.originals[i].kind, originalFile[i]});
  }
  for (const auto& plane : c.planes)
    record.planes.push_back({plane.name, plane.point, plane.normal});
  return record;
}

Result<void> makeFolders(const fs::path& folder, const std::vector<std::string>& files) {
  for (const std::string& file : files) {
    if (file.empty()) continue;
    std::error_code ec;
    fs::create_directories((folder / file).parent_path(), ec);
    if (ec) {
      return fail(ErrorCode::FileNotWritable,
                  fmt::format("cannot create the folder: {}", ec.message()),
                  {.file = (folder / file).parent_path().string()});
    }
  }
  return {};
}

}  // namespace

Result<OutputFormats> parseFormats(const std::string& list) {
  OutputFormats formats{false, false, false};
  std::size_t at = 0;
  while (at <= list.size()) {
    const std::size_t comma = std::min(list.find(',', at), list.size());
    const std::string word = list.substr(at, comma - at);
    if (word == "vtu") {
      formats.vtu = true;
    } else if (word == "mesh") {
      formats.medit = true;
    } else if (word == "obj") {
      formats.obj = true;
    } else {
      return fail(ErrorCode::UnknownName,
                  fmt::format("\"{}\" is no format; known are vtu, mesh and obj", word));
    }
    at = comma + 1;
  }
  return formats;
}

Result<WrittenOutput> writeOutput(const fs::path& folder, const OutputContents& c,
                                  const OutputFormats& formats, RunContext& run) {
  EC_REQUIRE_EQ(c.surfaces.size(), c.tissues.size() + 1);
  const Stage stage(run, "writing");
  const std::vector<std::string> originalFile = originalFiles(c.originals);
  WrittenOutput written;
  written.tissueFiles = formats.obj ? tissueFiles(c) : std::vector<std::string>(c.surfaces.size());
  std::vector<TissueName> names{{kFat.value, "fat"}};
  for (std::size_t i = 0; i < c.tissues.size(); ++i) {
    names.push_back({kFirstMuscle.value + static_cast<std::int32_t>(i), c.tissues[i].name});
  }

  if (formats.vtu) {
    const VtuContents vtu{c.anatomy.mesh,     c.anatomy.label,       names,
                          &c.fibers.tetFiber, &c.fibers.vertexFiber, &c.fibers.tendon};
    if (auto ok = writeVtu(folder / "anatomy.vtu", vtu); !ok) return passOn(ok);
  }
  run.progress("writing", 0.4);
  if (run.cancelled()) return fail(ErrorCode::Cancelled, "writing");
  if (formats.medit) {
    MarkedFaces faces = markFaces(c.anatomy, c.domain, names);
    if (auto ok =
            writeMedit(folder / "anatomy.mesh", c.anatomy.mesh, c.anatomy.label, faces, names);
        !ok) {
      return passOn(ok);
    }
    written.references = std::move(faces.meaning);
  }
  run.progress("writing", 0.7);
  if (run.cancelled()) return fail(ErrorCode::Cancelled, "writing");

  if (auto ok = makeFolders(folder, written.tissueFiles); !ok) return passOn(ok);
  if (auto ok = makeFolders(folder, originalFile); !ok) return passOn(ok);
  for (std::size_t i = 0; i < c.surfaces.size(); ++i) {
    if (written.tissueFiles[i].empty()) continue;
    if (auto ok = mesh::writeObj(c.surfaces[i], folder / written.tissueFiles[i]); !ok)
      return passOn(ok);
  }
  for (std::size_t i = 0; i < c.originals.size(); ++i) {
    if (auto ok = mesh::writeObj(*c.originals[i].mesh, folder / originalFile[i]); !ok)
      return passOn(ok);
  }
  ModelRecord record = recordOf(c, written.tissueFiles, originalFile);
  record.references = written.references;
  if (auto ok = writeFileWhole(folder / "model.json", printModelRecord(record)); !ok)
    return passOn(ok);
  return written;
}

}  // namespace ecorche::exchange
