#pragma once

#include <ecorche/core/result.h>
#include <ecorche/core/run_context.h>
#include <ecorche/mesh/surface_mesh.h>

#include <string>
#include <string_view>

namespace ecorche::mesh {

/// STL, ASCII or binary: corners are welded where they are exactly equal, normals and attributes
/// are passed over; each solid of an ASCII file is a part. Bytes after the announced triangles of a
/// binary file are passed over. Any bytes give a mesh with valid indices and finite coordinates, or
/// an error.
///
/// @param file  name for errors
/// @errors  FileTruncated, FileSyntax, NonFiniteVertex, MeshWithoutFaces, Cancelled
[[nodiscard]] Result<SurfaceMesh> parseStl(std::string_view bytes, const std::string& file,
                                           RunContext& run);

}  // namespace ecorche::mesh
