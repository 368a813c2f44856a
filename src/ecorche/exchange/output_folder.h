#pragma once

#include <ecorche/core/result.h>
#include <ecorche/core/run_context.h>
#include <ecorche/exchange/medit.h>
#include <ecorche/exchange/model_record.h>
#include <ecorche/fiber/fiber_field.h>
#include <ecorche/mesh/surface_mesh.h>

#include <filesystem>
#include <string>
#include <vector>

namespace ecorche::exchange {

/// A closed mesh that the user gave, kept for display and for checking how far the domain is from
/// it.
struct OriginalSurface {
  std::string name;
  std::string kind;  ///< "skin", "bone", "obstacle" or "cavity"; one skin
  const mesh::SurfaceMesh* mesh = nullptr;
};

/// Everything that `build` writes but the report and the picture.
struct OutputContents {
  const envelope::Anatomy& anatomy;
  const domain::Domain& domain;
  const std::vector<tissue::CurveTissue>& tissues;
  const fiber::FiberField& fibers;
  /// Surface of every tissue, by place: 0 fat, then `tissues` in order. No faces: nothing is
  /// written for it.
  const std::vector<mesh::SurfaceMesh>& surfaces;
  const std::vector<OriginalSurface>& originals;
  const std::vector<domain::CutPlane>& planes;
  double surfaceTolerance = 0.001;  ///< share of the skin's diagonal
};

/// Formats that --formats names.
struct OutputFormats {
  bool vtu = true;
  bool medit = true;
  bool obj = true;
};

/// "vtu,mesh,obj". @errors UnknownName
[[nodiscard]] Result<OutputFormats> parseFormats(const std::string& list);

/// What was written, for the report.
struct WrittenOutput {
  std::vector<FaceReference> references;  ///< of triangles in anatomy.mesh
  std::vector<std::string> tissueFiles;   ///< by place as OutputContents::surfaces; empty: no file
};

/// Writes anatomy.vtu, anatomy.mesh, muscles/NAME.obj, fat.obj, skin.obj, bones/NAME.obj,
/// model.json into an existing folder. Fillers have no surface file. Names become file names by
/// fileNames(); model.json tells which is which.
/// @errors FileNotWritable, Cancelled
[[nodiscard]] Result<WrittenOutput> writeOutput(const std::filesystem::path& folder,
                                                const OutputContents& contents,
                                                const OutputFormats& formats, RunContext& run);

}  // namespace ecorche::exchange
