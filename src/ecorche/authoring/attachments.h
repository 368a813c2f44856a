#pragma once

#include <ecorche/core/result.h>
#include <ecorche/model/project.h>

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace ecorche::authoring {

/// One place where a muscle meets a bone, as a table tells it.
struct AttachmentSite {
  std::string muscle;  ///< by muscleNameFrom
  std::string bone;    ///< as in the table; need not be a bone of the project
  model::Attachment::Role role = model::Attachment::Role::Unknown;
  mesh::Vector3 at = mesh::Vector3::Zero();  // centre [m]
  std::string patchFile;                     ///< as in the table; may be empty
  int line = 0;                              ///< of the table, from 1
};

/// All sites of one muscle, in table order.
struct MuscleSites {
  std::string muscle;
  std::vector<AttachmentSite> sites;
};

/// Reads a table of attachments: comma-separated, a first line with column names in any order,
/// double quotes around cells that hold commas. Two sets of columns are known:
///   muscle, bone, x, y, z, and if there role (origin or insertion) and patch (a mesh file)
///   muscle_file, bone_name_in_site, cx, cy, cz, site_file  (lists of sites, one patch each;
///   further columns are ignored,
///   and so are lines without a muscle)
/// @param metresPerUnit  of the coordinates
/// @errors  FileMissing, FileNotReadable, FileEmpty, MissingKey (a column), UnknownKey (a column),
/// FileSyntax (too few or
///          too many cells), WrongType (not a number), ValueOutOfRange (a role), all with line and
///          column
[[nodiscard]] Result<std::vector<MuscleSites>> readAttachments(const std::filesystem::path& file,
                                                               double metresPerUnit);

/// The same from text. @param file  for messages
[[nodiscard]] Result<std::vector<MuscleSites>> parseAttachments(std::string_view text,
                                                                const std::string& file,
                                                                double metresPerUnit);

}  // namespace ecorche::authoring
