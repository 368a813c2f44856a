#pragma once

#include <ecorche/mesh/surface_check.h>
#include <ecorche/mesh/surface_mesh.h>
#include <ecorche/mesh/surface_topology.h>

#include <cstdint>
#include <optional>
#include <vector>

namespace ecorche::mesh {

/// Steps of repairSurface that need no geometry kernel: triangles with a label each, and what a
/// step did to them.

struct LabelledFaces {
  Positions V;
  Triangles F;
  std::vector<std::int32_t> label;  ///< #F the part a face came from

  void keep(const std::vector<char>& kept);  ///< #F, not 0: stays
};

/// How much a step did, and where first.
struct StepReport {
  std::int64_t count = 0;
  std::optional<Vector3> place;
  double size = 0.0;  ///< the largest single change [m] or [m²]

  void see(const Vector3& where, double howMuch = 0.0) {
    if (count++ == 0) place = where;
    if (howMuch > size) {
      size = howMuch;
      place = where;
    }
  }
};

/// Vertices at exactly the same place become one.
StepReport weldEqual(LabelledFaces& faces);

/// Vertices on borders closer than `tolerance` [m] and than a quarter of the border edges there
/// become one.
StepReport weldBorders(LabelledFaces& faces, double tolerance);

/// Faces that name a vertex twice go.
StepReport dropCollapsed(LabelledFaces& faces);

/// Of faces over the same vertices one stays. Patches of doubled faces that were walls go
/// altogether: all their border edges join three faces or more, what is left without them is
/// closed, and both their sides lie inside it. So two boxes put together become one, while a bag of
/// doubled faces on the outside of a surface stays.
StepReport dropDoubled(LabelledFaces& faces);

/// Pieces whose box is smaller than `extent` [m], and open pieces with less than a ten-thousandth
/// of the area, go; the largest piece stays.
StepReport dropSpecks(LabelledFaces& faces, double extent);

/// Which pieces are crumbs: closed, touching none but their like, with less than a thousandth of
/// the volume, as a threshold leaves them in the air around a scan. Within other pieces they are
/// also short of a twenty-fifth of the extent of all: bubbles in the flesh are, an eyeball is not.
///
/// @param pieces  of F, as components() gives
/// @param check   of the same, in that order, as checkSurface() gives
/// @return  #pieces, not 0: a crumb
[[nodiscard]] std::vector<char> crumbs(const Positions& V, const Triangles& F,
                                       const FaceComponents& pieces,
                                       const std::vector<SurfaceCheck::Component>& check);
/// These go.
StepReport dropCrumbs(LabelledFaces& faces);
inline constexpr double kCrumbShare = 1e-3;  ///< of the volume

/// Turns closed pieces outward; what lies inside an inward piece is turned with it. Open pieces go
/// by the sign of the volume that they would enclose, where that is clear.
StepReport orientOutward(LabelledFaces& faces);

}  // namespace ecorche::mesh
