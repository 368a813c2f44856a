#pragma once

#include <ecorche/core/result.h>
#include <ecorche/core/run_context.h>
#include <ecorche/mesh/surface_mesh.h>

#include <filesystem>
#include <string>
#include <string_view>

namespace ecorche::mesh {

struct ReadOptions {
  /// Metres in one unit of the file. 1: the file is in metres.
  double metresPerUnit = 1.0;
};

/// Reads a surface of any format we know, by content first and suffix second.
///
/// OBJ, PLY (ASCII, binary of either byte order), STL (ASCII, binary) and OFF are read here;
/// glTF/GLB, FBX, COLLADA, 3DS and the rest by ecorche-worker, a process that may crash without
/// harm. Polygons are cut into triangles (polygon_soup.h). Vertices of STL and of the worker's
/// formats are welded where they are exactly equal; those of the other formats are kept as they
/// are. Nothing else is repaired.
///
/// @return  valid indices, finite coordinates [m], named after the file; OBJ objects or groups,
/// ASCII STL solids and
///          glTF nodes as parts, each with a name of its own: "rib", "rib_2" where both are "rib"
/// @errors  FileMissing, FileNotReadable, FileEmpty, FileTruncated, FileUnknownFormat, FileSyntax,
/// NonFiniteVertex,
///          MeshWithoutFaces; from the worker also WorkerMissing, WorkerCrashed, WorkerTimedOut,
///          OutOfMemory; Cancelled. Errors in text files name the line.
[[nodiscard]] Result<SurfaceMesh> readMesh(const std::filesystem::path& file,
                                           const ReadOptions& options, RunContext& run);

enum class MeshFormat { Obj, Ply, Stl, Off, Foreign };

/// What these bytes are, or what the suffix says where they do not tell; Foreign is for the worker.
/// @errors  FileUnknownFormat
[[nodiscard]] Result<MeshFormat> meshFormat(std::string_view bytes,
                                            const std::filesystem::path& file);

/// True for suffixes that readMesh reads: to pick the meshes out of a folder.
[[nodiscard]] bool isMeshFile(const std::filesystem::path& file);

}  // namespace ecorche::mesh
