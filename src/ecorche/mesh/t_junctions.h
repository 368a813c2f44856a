#pragma once

#include <ecorche/mesh/face_repair.h>

namespace ecorche::mesh {

/// Border edges that run past border vertices get these as corners: where one side of a seam has
/// more vertices than the other, both have them afterwards, and nothing moves.
/// @param tolerance  how far from the edge a vertex may lie [m]
/// @return  how many vertices were put into edges, and how far they lay from them
StepReport splitAtTJunctions(LabelledFaces& faces, double tolerance);

}  // namespace ecorche::mesh
