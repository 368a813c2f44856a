#pragma once

#include <ecorche/core/result.h>
#include <ecorche/exchange/anatomy_file.h>

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace ecorche::exchange {

/// What goes into a VTU file. Optional arrays are null.
struct VtuContents {
  const mesh::TetMesh& mesh;
  const std::vector<TissueId>& tissue;  ///< #T
  const std::vector<TissueName>& names;
  const mesh::Directions* tetFiber = nullptr;         ///< #T×3
  const mesh::Directions* vertexFiber = nullptr;      ///< #V×3
  const std::vector<std::uint8_t>* tendon = nullptr;  ///< #T; empty counts as null
};

/// VTK XML unstructured grid: tets; cell data `tissue` (Int32), `fiber` (3 Float64), `tendon`
/// (UInt8); point data `fiber`; field data one Int32 per tissue, named "tissue:NAME", with its id.
/// Arrays are appended raw, little endian, 64-bit headers: bits survive. Field data are numbers
/// because meshio knows no strings there.
/// @errors FileNotWritable
[[nodiscard]] Result<void> writeVtu(const std::filesystem::path& file, const VtuContents& contents);

/// Reads back what writeVtu wrote (not every VTU there is).
/// @return  arrays of matching sizes, corner indices within the vertices; values as they stand in
/// the file
/// @errors FileMissing, FileNotReadable, FileEmpty, FileUnknownFormat, FileSyntax, FileTruncated
[[nodiscard]] Result<AnatomyFile> readVtu(const std::filesystem::path& file);

/// The same from bytes. @param file  for messages
[[nodiscard]] Result<AnatomyFile> parseVtu(std::string_view bytes, const std::string& file);

}  // namespace ecorche::exchange
