#pragma once

#include <ecorche/core/result.h>
#include <ecorche/core/run_context.h>
#include <ecorche/mesh/surface_mesh.h>

#include <string>
#include <string_view>

namespace ecorche::mesh {

/// Wavefront OBJ: v and f with negative indices, continued lines and vertex references before their
/// vertices; textures, normals, materials and free-form surfaces are passed over. Two or more
/// objects make the parts, else groups do; faces of groups that come back later in the file are put
/// together. Any bytes give a mesh with valid indices and finite coordinates, or an error.
///
/// @param file  name for errors
/// @errors  FileTruncated, FileSyntax, NonFiniteVertex, MeshWithoutFaces, Cancelled
[[nodiscard]] Result<SurfaceMesh> parseObj(std::string_view bytes, const std::string& file,
                                           RunContext& run);

}  // namespace ecorche::mesh
