#pragma once

#include <ecorche/mesh/spline.h>
#include <ecorche/mesh/surface_query.h>
#include <ecorche/model/project.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace ecorche::authoring {

/// A bone ready to be asked.
struct BoneSurface {
  std::string name;
  mesh::Box box;
  std::shared_ptr<const mesh::SurfaceQuery> surface;  ///< as given: ends sit on it
  /// Closed, so that inside has a meaning: the surface itself, or one around it (see solidBone).
  /// None where the surface is open.
  std::shared_ptr<const mesh::SurfaceQuery> solid;

  [[nodiscard]] double distanceToBox(const mesh::Vector3& p) const {
    return (box.lo - p).cwiseMax(p - box.hi).cwiseMax(mesh::Vector3::Zero()).norm();
  }
};
/// @param mesh  has a face with an area
[[nodiscard]] BoneSurface boneSurface(std::string name, const mesh::SurfaceMesh& mesh);

/// What the end of a curve may sit on.
struct SnapTargets {
  struct TissueCurve {
    std::string tissue;
    mesh::Spline spline;
  };
  std::vector<BoneSurface> bones;
  std::vector<model::CutPlane> planes;
  std::vector<TissueCurve> curves;
};
/// Bones as given; planes and curves of the project.
[[nodiscard]] SnapTargets snapTargets(const model::Project& project,
                                      std::vector<BoneSurface> bones);

struct Snap {
  model::Support support;
  mesh::Vector3 at = mesh::Vector3::Zero();  ///< on the support [m]
  double distance = 0.0;                     ///< that the end was moved [m]
};

/// Where a curve's end goes that was let go at p: onto the nearest bone surface, cut plane or curve
/// of another tissue.
/// @param reach  no farther than this [m]
/// @param owner  the tissue whose curve it is; its own curves do not count
/// @return  nothing where all are out of reach: the end is free
[[nodiscard]] std::optional<Snap> snapEnd(const mesh::Vector3& p, const SnapTargets& targets,
                                          double reach, const std::string& owner = {});

/// The nearest bone alone.
[[nodiscard]] std::optional<Snap> snapToBone(const mesh::Vector3& p,
                                             const std::vector<BoneSurface>& bones, double reach);

}  // namespace ecorche::authoring
