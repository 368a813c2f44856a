#pragma once

#include <ecorche/core/result.h>
#include <ecorche/mesh/surface_mesh.h>

#include <string>
#include <string_view>

namespace ecorche::mesh {

/// A surface as bytes that go between ecorche-worker and us on one machine: name, V, F, parts.
[[nodiscard]] std::string encodeImport(const SurfaceMesh& mesh);

/// Reads it back and believes nothing: the writer may have crashed half-way or been led astray by a
/// hostile file.
/// @return  indices in range, parts in face order covering all faces (or none); coordinates may be
/// anything
/// @errors  FileTruncated where the bytes do not end as they should, FileSyntax for indices and
/// parts out of range
[[nodiscard]] Result<SurfaceMesh> decodeImport(std::string_view bytes);

}  // namespace ecorche::mesh
