#pragma once

#include <ecorche/engine/build.h>
#include <ecorche/render/image.h>
#include <ecorche/render/palette.h>
#include <ecorche/render/scene.h>
#include <ecorche/render/views.h>

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace ecorche::engine {

/// What a picture can show, from a build in memory or from a folder that one wrote.
struct PictureModel {
  struct Surface {
    std::string name;
    std::shared_ptr<const mesh::SurfaceMesh> mesh;
    std::shared_ptr<const mesh::Directions> normals;  ///< null: smoothed from the faces
  };
  struct Tissue {
    TissueId id;
    std::string name;
    std::string kind;  ///< "fat", "muscle" or "filler"
    Surface surface;
    std::vector<std::vector<mesh::Vector3>> curves;  ///< poly-lines, origin first
    std::vector<std::vector<mesh::Vector3>> fibers;  ///< traced, origin first
    std::optional<render::Rgba> colour;
  };
  Surface skin;
  std::vector<Surface> bones;
  std::vector<Surface> obstacles;
  std::vector<Tissue> tissues;  ///< by id, fat first
  std::vector<mesh::Vector3> controlPoints;
  std::shared_ptr<const mesh::TetMesh> tets;  ///< for slices
  std::shared_ptr<const mesh::TetNeighbours> neighbours;
  std::vector<TissueId> label;  ///< #T
  /// Tissues straight from their fields, in place of surfaces and slices.
  std::optional<render::VolumeItem> volume;
};

/// @errors none; shares nothing with the build, which may go
[[nodiscard]] PictureModel pictureModel(const model::Project& project, const Build& build);
/// What a window shows while one models: nothing is meshed, tissues are drawn from their fields.
struct Preview {
  PreparedDomain domain;
  tissue::TissueFields fields;
};
/// @errors what findFault says about the project, those of prepareDomain and tissue::solveTissues
[[nodiscard]] Result<Preview> preparePreview(const model::Project& project,
                                             const BuildOptions& options, RunContext& run);
[[nodiscard]] PictureModel pictureModel(const model::Project& project, const Preview& preview);

/// Reads model.json, surfaces, tets of a folder that `build` wrote.
/// @errors those of the readers
[[nodiscard]] Result<PictureModel> readPictureModel(const std::filesystem::path& folder,
                                                    RunContext& run);

struct PictureSettings {
  int width = 1600;                    ///< [pixels]
  int height = 1200;                   ///< [pixels]
  int samples = 16;                    ///< passes averaged: anti-aliasing and soft light
  std::string view = "three-quarter";  ///< see render::parseView
  char up = 'Z';                       ///< axis that points up in the model
  std::optional<render::ClipPlane>
      clip;  ///< what its normal points at stays; the cut is coloured by tissue
  std::vector<std::string> hide;  ///< "skin", "bones", "muscles", "fillers", "curves", or names
  std::vector<std::string> only;  ///< tissues to show alone; empty: all
  bool curves = false;            ///< drawn curves on top
  bool fibers = false;            ///< traced fibres in place of muscles' surfaces
  render::Palette palette = render::Palette::Anatomical;
  bool transparentBackground = false;
  bool motion = false;  ///< as a window shows it while it is being turned: one quick pass
};

/// "x=0.1", "y<0.2" (keep what is below) or "z>0". A bare "=" keeps what is above. @errors
/// CommandSyntax
[[nodiscard]] Result<render::ClipPlane> parseClip(const std::string& text);

/// @errors NoGraphics, CommandSyntax (the view), UnknownName (something to hide or show that is not
/// there), Cancelled
[[nodiscard]] Result<render::Image> drawPicture(const PictureModel& model,
                                                const PictureSettings& settings, RunContext& run);
[[nodiscard]] Result<render::Image> drawPicture(const model::Project& project, const Build& build,
                                                const PictureSettings& settings, RunContext& run);

}  // namespace ecorche::engine
