#pragma once

#include <ecorche/mesh/surface_topology.h>

#include <cstdint>
#include <vector>

namespace ecorche::mesh {

/// Which pieces of a surface hold which others, a vertex of each asked: no vertex where pieces
/// touch, so that it lies in or out.
///
/// @param mayHold  #pieces, not 0: closed, and may hold others
/// @param asked    #pieces, not 0: its holders are wanted
/// @return  for each piece those that hold it, ascending; itself never. Time grows with the faces
///          and with how many pieces a ray meets, not with the square of the pieces.
[[nodiscard]] std::vector<std::vector<std::int32_t>> holders(const Positions& V, const Triangles& F,
                                                             const FaceComponents& pieces,
                                                             const std::vector<char>& mayHold,
                                                             const std::vector<char>& asked);

/// Faces of every piece, ascending.
[[nodiscard]] std::vector<std::vector<Eigen::Index>> facesByPiece(const FaceComponents& pieces);

}  // namespace ecorche::mesh
