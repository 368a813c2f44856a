#pragma once

#include <ecorche/mesh/surface_query.h>
#include <ecorche/mesh/surface_topology.h>

#include <optional>
#include <vector>

namespace ecorche::mesh {

/// How often a surface winds around what lies just above a face: half-way to what is met next.
///
/// @param query  a closed surface
/// @param face   of the mesh, whose faces are those of the surface or pieces of them
/// @param hair   what is nearer than that is the face itself [m]
/// @return  nothing for a face without an area that doubles could tell, and where the place is on
///          the surface
[[nodiscard]] std::optional<int> windingAbove(const SurfaceQuery& query, const SurfaceMesh& mesh,
                                              Eigen::Index face, double hair);

/// The largest face of every patch: its middle is the farthest from the patch's rim.
[[nodiscard]] std::vector<Eigen::Index> largestFaces(const SurfaceMesh& mesh,
                                                     const FaceComponents& patches);

}  // namespace ecorche::mesh
