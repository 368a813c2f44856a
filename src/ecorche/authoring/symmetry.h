#pragma once

#include <ecorche/core/result.h>
#include <ecorche/core/run_context.h>
#include <ecorche/mesh/surface_mesh.h>

#include <optional>

namespace ecorche::authoring {

/// A plane that mirrors a surface onto itself.
struct SymmetryPlane {
  mesh::Vector3 point = mesh::Vector3::Zero();    // [m], the plane's point nearest to the origin
  mesh::Vector3 normal = mesh::Vector3::UnitY();  // unit, its largest coordinate positive
  /// Mean distance of mirrored points to the surface [share of the bounding-box diagonal].
  double error = 0.0;
  /// The plane found was within a hair of one of the frame's own planes, so that one was taken.
  bool snapped = false;
};

struct SymmetryOptions {
  /// A plane with a larger error is no symmetry [share of the diagonal].
  double tolerance = 0.004;
};

/// Looks for the plane that mirrors a surface best: principal axes, the frame's axes and directions
/// in between are tried, the best are refined by mirroring points and fitting the plane to where
/// they land (as in iterative closest points; the best plane for given pairs is an eigenvector).
/// Faces may be open or cut; their area counts.
///
/// @return  nothing where no plane is good enough; where several are (a box), the one with the
/// least error
/// @errors  MeshWithoutFaces, Cancelled
[[nodiscard]] Result<std::optional<SymmetryPlane>> findSymmetryPlane(const mesh::SurfaceMesh& skin,
                                                                     const SymmetryOptions& options,
                                                                     RunContext& run);

}  // namespace ecorche::authoring
