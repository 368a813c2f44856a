#pragma once

#include <ecorche/core/finding.h>
#include <ecorche/core/run_context.h>
#include <ecorche/domain/tagged_surface.h>

#include <string>
#include <vector>

namespace ecorche::domain {

/// A closed surface to take out of the skin: a bone, an obstacle, a cavity.
struct Hole {
  std::string name;
  mesh::SurfaceMesh mesh;  ///< facing outward where it is closed
  BoundaryTag tag;
  bool fit = true;  ///< closed, oriented, free of self-intersections; otherwise it is wrapped first
  double moved = 0.0;  ///< how far thinning took it from what was given [m]
};

struct CarveInput {
  mesh::SurfaceMesh skin;  ///< closed, facing outward, free of self-intersections
  double skinMoved = 0.0;  ///< as Hole::moved
  std::vector<Hole> holes;
  std::vector<CutPlane> cutPlanes;
};

struct CarveOptions {
  /// How far a wrap may stray from what it wraps [m].
  double wrapTolerance = 0.0;
};

struct Carved {
  TaggedSurface surface;  ///< exact up to rounding: input faces and pieces of them, and faces on
                          ///< the cut planes
  Findings findings;      ///< what was united, wrapped, cut off, left out
  std::vector<std::size_t>
      wrapped;        ///< places in CarveInput::holes of those that had to be wrapped, ascending
  int wrapCount = 0;  ///< clusters that had to be wrapped
  /// Places in CarveInput::holes of those that lie beyond a cut plane or outside the skin with all
  /// their pieces, ascending.
  std::vector<std::size_t> leftOut;
};

/// Skin minus holes, on the kept side of every cut plane.
///
/// Holes that touch or overlap are united first, exactly where that works and by an alpha wrap
/// [Portaneri et al. 2022] where it does not (open, self-intersecting or just touching meshes).
/// Pieces of holes beyond a cut plane or outside the skin are left out, the latter with a word.
/// What reaches out of the skin on the kept side is cut off there and reported with its volume.
/// Every face keeps the
/// tag of the input face it is a piece of; faces of a wrap take the tag of the closest hole.
/// Vertices of cut faces lie on their plane up to the rounding of one projection (exactly where the
/// normal is an axis).
///
/// @errors  BonesOutsideSkin, EmptyDomain, MeshNotRepairable, Cancelled
[[nodiscard]] Result<Carved> carve(const CarveInput& input, const CarveOptions& options,
                                   RunContext& run);

}  // namespace ecorche::domain
