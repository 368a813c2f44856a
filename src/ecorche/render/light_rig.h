#pragma once

#include <ecorche/render/scene.h>

#include <Eigen/Core>
#include <vector>

namespace ecorche::render {

/// Light from one far-away spot.
struct LightSample {
  mesh::Vector3 direction = mesh::Vector3::UnitZ();      ///< unit, towards the light
  Eigen::Vector3f irradiance = Eigen::Vector3f::Zero();  ///< on a surface that faces it, linear
  bool key = false;  ///< part of the key or rim lamp: makes highlights
};

/// The lamps of a photographer's table, as far as one pass of a picture uses them.
///
/// A warm key lamp above and left of the eye, a weak rim lamp behind on the right, and a sky all
/// around that is brighter above than below. Each is an area: it is sampled by directions, and
/// every pass of a picture takes other ones, so that shadows are soft and ambient occlusion falls
/// out when the passes are averaged [Haeberli & Akeley 1990].
struct LightRigOptions {
  int passes = 12;
  int keyPerPass = 2;
  int rimPerPass = 1;
  int skyPerPass = 7;
  float exposure = 1.0f;
};

/// @param pass  in [0, passes)
/// @return  lamps first, then sky. Summed over a pass, a white surface that nothing shades and that
/// is turned halfway
///          between eye and up receives `exposure`, the same in every pass.
[[nodiscard]] std::vector<LightSample> lightsOfPass(const Camera& camera,
                                                    const LightRigOptions& options, int pass);

/// The sky of the rig as one light from everywhere: what a surface receives that faces up or down,
/// growing evenly in between.
struct SkyLight {
  Eigen::Vector3f above = Eigen::Vector3f::Zero();
  Eigen::Vector3f below = Eigen::Vector3f::Zero();
};
/// @return  what the sky of all passes gives the reference surface where nothing shades it
[[nodiscard]] SkyLight skyLight(float exposure);

/// The eye's own axes, unit and right-handed: right, up, towards the eye. Works for an `up` along
/// the line of sight.
struct EyeAxes {
  mesh::Vector3 right, up, back;
};
[[nodiscard]] EyeAxes eyeAxes(const Camera& camera);

}  // namespace ecorche::render
