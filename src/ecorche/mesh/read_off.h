#pragma once

#include <ecorche/core/result.h>
#include <ecorche/core/run_context.h>
#include <ecorche/mesh/surface_mesh.h>

#include <string>
#include <string_view>

namespace ecorche::mesh {

/// OFF of Geomview, with or without colours, normals and texture coordinates, ASCII only.
/// Any bytes give a mesh with valid indices and finite coordinates, or an error.
///
/// @param file  name for errors
/// @errors  FileTruncated, FileSyntax, NonFiniteVertex, MeshWithoutFaces, Cancelled
[[nodiscard]] Result<SurfaceMesh> parseOff(std::string_view bytes, const std::string& file,
                                           RunContext& run);

}  // namespace ecorche::mesh
