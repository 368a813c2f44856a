#pragma once

#include <ecorche/core/result.h>
#include <ecorche/render/scene.h>

#include <Eigen/Core>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace ecorche::render {

/// How a model stands in its world; unit vectors across each other. The dog: up Z, nose along X.
struct ModelAxes {
  mesh::Vector3 up = mesh::Vector3::UnitZ();
  mesh::Vector3 forward = mesh::Vector3::UnitX();
};

/// From where a model is looked at.
struct View {
  double azimuthDeg = 0.0;    ///< 0: from the front; 90: from the model's own left [degrees]
  double elevationDeg = 0.0;  ///< above the horizon, -90 to 90 [degrees]
  double fovDeg = 24.0;       ///< vertical opening; 0: parallel rays [degrees]
  double zoom = 1.0;          ///< above 1: closer than what fills the picture
};

/// Reads "front", "back", "left", "right", "top", "bottom", "three-quarter", "three-quarter-right",
/// or settings with commas: "az=30,el=20,fov=0,zoom=1.5". A name may come first: "left,el=10".
/// Parallel rays: "ortho".
/// @errors CommandSyntax, ValueOutOfRange; the message lists what is understood
[[nodiscard]] Result<View> parseView(std::string_view text);

/// A camera of that view with all points of the scene in the picture.
///
/// @param margin  of the picture's smaller side left free on each side [share, 0 to 0.4]
/// @param aspect  width over height of the picture
[[nodiscard]] Camera framed(const View& view, const ModelAxes& axes, const mesh::Box& box,
                            double aspect, double margin = 0.05);
/// What a clip takes away does not count, nor what lies outside `within`.
[[nodiscard]] Camera framed(const View& view, const ModelAxes& axes, const Scene& scene,
                            double aspect, double margin = 0.05,
                            const std::optional<mesh::Box>& within = {});

/// Axes that suit a box when nobody says: up as given, forward along the longer of the other two
/// sides.
[[nodiscard]] ModelAxes guessedAxes(const mesh::Box& box, char up = 'Z');

/// Pixel (from the top left, centres at .5) and distance along the line of sight; nothing behind
/// the eye.
struct Projected {
  Eigen::Vector2d pixel;
  double depth = 0.0;
};
[[nodiscard]] std::optional<Projected> project(const Camera& camera, int width, int height,
                                               const mesh::Vector3& point);

/// The ray of sight through a pixel (from the top left, centres at .5): from the eye, or, where
/// rays are parallel, from the plane across them at the eye. The other way round of project().
[[nodiscard]] Ray rayThrough(const Camera& camera, int width, int height,
                             const Eigen::Vector2d& pixel);

/// World (relative to `origin`) to clip space of OpenGL; near and far planes enclose the box.
///
/// @param jitter  the whole picture is moved by this [pixels]
[[nodiscard]] Eigen::Matrix4d viewProjection(const Camera& camera, int width, int height,
                                             const mesh::Box& box, const mesh::Vector3& origin,
                                             const Eigen::Vector2d& jitter = {0.0, 0.0});

/// All of a box lies beyond one side of the picture, or behind the eye.
///
/// @param toClip  as viewProjection gives, for places relative to the same origin as the box's
[[nodiscard]] bool isBeyondPicture(const Eigen::Matrix4f& toClip, const Eigen::Vector3f& lo,
                                   const Eigen::Vector3f& hi);

/// Size of a pixel [m]: at distance 1 m from the eye, or everywhere where rays are parallel.
[[nodiscard]] double pixelSize(const Camera& camera, int height);

}  // namespace ecorche::render
