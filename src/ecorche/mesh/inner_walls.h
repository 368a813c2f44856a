#pragma once

#include <ecorche/mesh/face_repair.h>

namespace ecorche::mesh {

/// Walls that divide the inside and bound nothing go, as mirrored and joined models have them: any
/// number of them at once, also where they meet one another.
///
/// Faces sorted exactly around edges of three or more divide space into rooms; walls are faces with
/// an inside room before and behind them. A piece keeps everything where that is not clear: its
/// outer faces look to different sides, faces lie upon one another at an edge, or a hole is wider
/// than `holeRel` allows (see isSmallHole); smaller ones are taken for filled.
/// @return  how many walls, the widest one's place and extent [m]
StepReport dropInnerWalls(LabelledFaces& faces, double holeRel);

}  // namespace ecorche::mesh
