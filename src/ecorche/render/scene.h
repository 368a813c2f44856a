#pragma once

#include <ecorche/mesh/surface_mesh.h>
#include <ecorche/render/volume_item.h>

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace ecorche::render {

using Rgba = std::array<float, 4>;  ///< linear light, straight alpha

/// A surface to draw. Arrays are shared with whoever made them; a new revision means new contents.
struct SurfaceItem {
  std::string name;
  std::shared_ptr<const mesh::SurfaceMesh> mesh;
  std::shared_ptr<const mesh::Directions> normals;  ///< per vertex; null: computed from the faces
  std::shared_ptr<const std::vector<Rgba>>
      faceColours;  ///< per face instead of `colour`; null: one colour
  Rgba colour{0.7f, 0.7f, 0.7f, 1.0f};
  float roughness = 0.6f;  ///< 0 mirror … 1 chalk
  bool cullBack = false;   ///< draw outward faces only
  /// Opacity where the surface is seen edge-on, growing from colour[3] where it faces the eye: how
  /// skin and glass look. Unset: the same everywhere. Used where the surface is transparent.
  std::optional<float> edgeOpacity;
  double creaseDeg =
      60.0;  ///< edges that turn by more stay sharp; not used with `normals` [degrees]
  int normalSmoothing =
      0;  ///< rounds of averaging normals with neighbours; not used with `normals`
  /// Closed, and to be seen as massive: where the clip plane opens it, the cut is filled with
  /// `capColour` (unset: its own colour). Opaque items only.
  bool capped = false;
  std::optional<Rgba> capColour;
  bool clipped = true;      ///< false: the clip plane leaves it alone (caps)
  bool castsShadow = true;  ///< opaque surfaces only
  std::uint64_t revision = 0;

  bool operator==(const SurfaceItem&) const = default;
};

/// Lines, drawn as round tubes that take the light: curves, fibres.
struct LineItem {
  std::string name;
  std::shared_ptr<const std::vector<std::vector<mesh::Vector3>>> lines;
  std::shared_ptr<const std::vector<Rgba>>
      lineColours;  ///< per line instead of `colour`; null: one colour
  Rgba colour{0.0f, 0.0f, 0.0f, 1.0f};
  float widthPixels = 2.0f;  ///< in the finished picture
  double widthMetres = 0.0;  ///< instead of widthPixels where above 0
  bool onTop = false;        ///< drawn through what stands before it
  bool clipped =
      false;  ///< true: the clip plane takes away what lies behind it, to the nearest point
  std::uint64_t revision = 0;

  bool operator==(const LineItem&) const = default;
};

/// Balls of a radius in pixels: control points.
struct PointItem {
  std::string name;
  std::shared_ptr<const std::vector<mesh::Vector3>> points;
  Rgba colour{1.0f, 1.0f, 1.0f, 1.0f};
  float radiusPixels = 4.0f;
  bool onTop = false;
  std::uint64_t revision = 0;

  bool operator==(const PointItem&) const = default;
};

/// Everything in a picture but the eye.
struct Scene {
  std::vector<SurfaceItem> surfaces;
  std::vector<LineItem> lines;
  std::vector<PointItem> points;
  std::optional<VolumeItem> volume;  ///< tissues drawn from their fields
  std::optional<ClipPlane>
      clip;  ///< surfaces are cut there; caps are given as surfaces by whoever fills the scene
  Rgba background{1.0f, 1.0f, 1.0f, 1.0f};
};

/// Where the eye is. Orthographic where fovDeg is 0.
struct Camera {
  mesh::Vector3 eye{0.0, -1.0, 0.0};
  mesh::Vector3 target = mesh::Vector3::Zero();
  mesh::Vector3 up = mesh::Vector3::UnitZ();
  double fovDeg = 30.0;      ///< vertical
  double orthoHeight = 1.0;  ///< height of the picture at the target [m], orthographic only
};

}  // namespace ecorche::render
