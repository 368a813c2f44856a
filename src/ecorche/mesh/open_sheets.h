#pragma once

#include <ecorche/mesh/surface_mesh.h>
#include <ecorche/mesh/surface_topology.h>

#include <vector>

namespace ecorche::mesh {

/// Which pieces are open sheets that enclose nothing and belong to nothing: hair cards, eyelashes,
/// stray triangles beside a skin.
///
/// A sheet is open, and its faces look mostly one way (the sum of their area vectors is more than
/// 0.7 of their areas together; it is nothing of what is closed, half of half a ball, all of what
/// is flat), or it is a narrow strip. A piece of skin that is cracked off all around looks the
/// same, but its border runs along that of a piece which is no sheet: it is none then, nor is what
/// runs along it in turn. Where all pieces would be sheets none is.
///
/// @return  #pieces, not 0: a sheet. A piece whose faces do not agree about their sides may go
///          unseen; none is seen where there is none.
[[nodiscard]] std::vector<char> openSheets(const Positions& V, const Triangles& F,
                                           const SurfaceEdges& edges, const FaceComponents& pieces);

/// "hair", "lashes" and 3 more: the parts that the faces come from, for a message; nothing where
/// the mesh has none.
/// @param chosen  #parts, not 0: asked for
[[nodiscard]] std::string partsNamed(const SurfaceMesh& mesh, const std::vector<char>& chosen);

}  // namespace ecorche::mesh
