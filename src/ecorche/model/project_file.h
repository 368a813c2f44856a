#pragma once

#include <ecorche/core/result.h>
#include <ecorche/model/project.h>

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace ecorche::model {

/// The schema that this program writes. Older ones are migrated while reading.
inline constexpr int kSchema = 1;

/// Reads a project file (docs/project.schema.json) and checks it with findFault. Meshes are not
/// opened.
///
/// Every error names file, line and column: `forearm.ecorche:41:17: muscle "biceps" has no curve;
/// draw one or delete the muscle`.
/// @errors FileMissing, FileNotReadable, FileEmpty, FileTruncated, FileSyntax, UnknownKey,
/// MissingKey, WrongType,
///         SchemaTooNew and what findFault names
[[nodiscard]] Result<Project> loadProject(const std::filesystem::path& file);

/// The same from text. @param file  for messages; its folder becomes Project::folder
[[nodiscard]] Result<Project> parseProject(std::string_view text,
                                           const std::filesystem::path& file);

/// The file's text: keys in a fixed order, defaults left out, one control point a line, numbers as
/// short as they can be. parseProject gives back the same project to the last bit (inches and
/// degrees: from the second writing on).
[[nodiscard]] std::string projectText(const Project& project);

/// Writes the file whole or not at all. What loadProject would refuse is not written.
/// @errors FileNotWritable and what findFault names
[[nodiscard]] Result<void> saveProject(const Project& project, const std::filesystem::path& file);

/// The keys of one kind of object in the file, for the reader and for the test that holds it to the
/// schema.
struct ObjectKeys {
  std::string_view object;  ///< as under $defs of the schema; "project" is the whole file
  std::vector<std::string_view> required;
  std::vector<std::string_view> optional;
};
[[nodiscard]] std::span<const ObjectKeys> projectKeys();

}  // namespace ecorche::model
