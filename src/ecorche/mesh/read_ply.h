#pragma once

#include <ecorche/core/result.h>
#include <ecorche/core/run_context.h>
#include <ecorche/mesh/surface_mesh.h>

#include <string>
#include <string_view>

namespace ecorche::mesh {

/// PLY 1.0, ASCII or binary of either byte order: x, y, z of the element vertex, the index list of
/// the element face; everything else is passed over. Any bytes give a mesh with valid indices and
/// finite coordinates, or an error.
///
/// @param file  name for errors
/// @errors  FileTruncated, FileSyntax, NonFiniteVertex, MeshWithoutFaces, Cancelled
[[nodiscard]] Result<SurfaceMesh> parsePly(std::string_view bytes, const std::string& file,
                                           RunContext& run);

}  // namespace ecorche::mesh
