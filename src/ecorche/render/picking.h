#pragma once

#include <ecorche/core/ids.h>
#include <ecorche/mesh/surface_query.h>
#include <ecorche/render/scene.h>

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>

namespace ecorche::render {

/// What lies under the pointer.
struct Pick {
  enum class Kind : std::uint8_t { Nothing, Point, Line, Surface, Tissue };
  Kind kind = Kind::Nothing;
  std::size_t item = 0;                          ///< of scene.points, lines or surfaces
  std::size_t index = 0;                         ///< point, line or face within the item
  TissueId tissue;                               ///< Kind::Tissue
  mesh::Vector3 at = mesh::Vector3::Zero();      ///< [m]
  mesh::Vector3 normal = mesh::Vector3::Zero();  ///< unit, towards the eye; surfaces and tissues
  double distance = 0.0;                         ///< along the ray [m]
  double along = 0.0;  ///< Kind::Line: length along the line up to there [m]
};

struct PickOptions {
  bool points = true;
  bool lines = true;
  bool surfaces = true;  ///< opaque ones
  bool veils = false;    ///< transparent ones too: drawing on skin
  bool tissues = true;
  double reach = 6.0;  ///< how far beside a point or line it still counts [pixels]
};

/// Finds what is seen at a pixel of a scene, without OpenGL. Keeps a search tree per surface, made
/// when it is first asked for.
class Picker {
 public:
  /// Points go before lines, lines before what has an area; among each kind the nearest to the eye,
  /// where things on top hide the others. What the clip plane takes away is not found.
  /// @param pixel  from the top left, centres at .5
  [[nodiscard]] Pick pick(const Scene& scene, const Camera& camera, int width, int height,
                          const Eigen::Vector2d& pixel, const PickOptions& options = {});

 private:
  struct Known {
    std::shared_ptr<const mesh::SurfaceMesh> mesh;
    std::uint64_t revision = 0;
    std::unique_ptr<mesh::SurfaceQuery> query;
    mesh::Box box;
  };
  std::map<const mesh::SurfaceMesh*, Known> known_;

  const Known& known(const SurfaceItem& item);
};

}  // namespace ecorche::render
