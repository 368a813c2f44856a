#pragma once

#include <ecorche/core/result.h>

#include <string>
#include <vector>

namespace ecorche::worker {

/// What follows the subcommand on the command line.
using Arguments = std::vector<std::string>;

/// `import INPUT OUTPUT`: any mesh file that Assimp knows, as an import file (mesh/import_file.h).
/// @errors FileSyntax, FileNotWritable
Result<void> importMesh(const Arguments& arguments);

/// `tetrahedralize INPUT OUTPUT`: a closed surface and points inside it, as tets
/// (domain/tet_files.h), by TetGen.
/// @errors MeshingFailed (what TetGen refuses, with its reason), OutOfMemory, FileNotWritable
Result<void> tetrahedralizeSurface(const Arguments& arguments);

/// `fill INPUT OUTPUT`: the same by CGAL Mesh_3, which makes the surface anew. Changes the working
/// folder to OUTPUT's.
/// @errors MeshingFailed, OutOfMemory, FileNotWritable
Result<void> fillSurface(const Arguments& arguments);

}  // namespace ecorche::worker
