#pragma once

#include <ecorche/mesh/face_repair.h>

namespace ecorche::mesh {

/// Walls that divide the inside and bound nothing go, as mirrored and joined models have them:
/// patches whose rim joins three faces or more everywhere, without which the surface is still
/// closed, and both of whose sides lie inside it. Where sides are not oriented nothing goes.
/// @return  how many walls, the widest one's place and extent [m]
StepReport dropInnerWalls(LabelledFaces& faces);

}  // namespace ecorche::mesh
