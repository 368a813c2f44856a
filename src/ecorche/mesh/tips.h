#pragma once

#include <ecorche/mesh/types.h>

namespace ecorche::mesh {

/// Vertices at the very same place, where two tips of a surface touch or two of its ridges cross,
/// are drawn back a little, each towards the middle of its neighbours: by a twentieth of its
/// shortest edge.
///
/// @param V  moved
/// @return   how many vertices were moved
Eigen::Index drawTipsApart(Positions& V, const Triangles& F);

}  // namespace ecorche::mesh
