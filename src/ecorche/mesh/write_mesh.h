#pragma once

#include <ecorche/core/result.h>
#include <ecorche/mesh/surface_mesh.h>

#include <filesystem>
#include <string>

namespace ecorche::mesh {

/// A surface as the bytes of a file, in metres. Coordinates of OBJ, PLY and OFF come back to the
/// last bit: shortest decimals that do, or doubles. STL holds 32-bit coordinates and no shared
/// vertices.
[[nodiscard]] std::string objText(
    const SurfaceMesh& mesh);  ///< parts as groups, "o NAME" where there are none
[[nodiscard]] std::string plyBytes(const SurfaceMesh& mesh);  ///< binary, little-endian, no parts
[[nodiscard]] std::string offText(const SurfaceMesh& mesh);   ///< no parts
[[nodiscard]] std::string stlBytes(const SurfaceMesh& mesh);  ///< binary, no parts

/// The same, written whole or not at all. @errors FileNotWritable
[[nodiscard]] Result<void> writeObj(const SurfaceMesh& mesh, const std::filesystem::path& file);
[[nodiscard]] Result<void> writePly(const SurfaceMesh& mesh, const std::filesystem::path& file);
[[nodiscard]] Result<void> writeOff(const SurfaceMesh& mesh, const std::filesystem::path& file);
[[nodiscard]] Result<void> writeStl(const SurfaceMesh& mesh, const std::filesystem::path& file);

}  // namespace ecorche::mesh
