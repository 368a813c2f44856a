#pragma once

#include <ecorche/core/result.h>
#include <ecorche/core/run_context.h>
#include <ecorche/envelope/anatomy.h>
#include <ecorche/exchange/anatomy_file.h>

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace ecorche::exchange {

/// The triangles of an anatomy that mean something, with what they mean.
struct MarkedFaces {
  mesh::Triangles F;  ///< boundary faces outward, then interfaces, facing out of the inner tissue
  std::vector<std::int32_t> reference;  ///< #F
  std::vector<FaceReference> meaning;   ///< by reference; only those that occur
};

/// Skin, bones, cut planes … in this order, then interfaces by the two tissues; inner is
/// the one of higher id, so that a muscle's interfaces with fat face out of the muscle.
/// @param names  of tissues; an id without one is written as its number
[[nodiscard]] MarkedFaces markFaces(const envelope::Anatomy& anatomy, const domain::Domain& domain,
                                    const std::vector<TissueName>& names);

/// MEDIT ASCII: vertices (shortest decimals that read back to the same bits), triangles with their
/// reference, tets with their tissue id. Comments at the top tell what the references stand for.
/// @errors FileNotWritable
[[nodiscard]] Result<void> writeMedit(const std::filesystem::path& file, const mesh::TetMesh& mesh,
                                      const std::vector<TissueId>& tissue, const MarkedFaces& faces,
                                      const std::vector<TissueName>& names);

/// Reads vertices, triangles and tets of any MEDIT ASCII file in 3D; other sections are skipped.
/// @errors FileMissing, FileNotReadable, FileEmpty, FileUnknownFormat, FileSyntax, FileTruncated
[[nodiscard]] Result<AnatomyFile> readMedit(const std::filesystem::path& file);

/// The same from bytes. @param file  for messages
[[nodiscard]] Result<AnatomyFile> parseMedit(std::string_view bytes, const std::string& file);

}  // namespace ecorche::exchange
