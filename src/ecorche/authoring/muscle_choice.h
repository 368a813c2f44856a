#pragma once

#include <ecorche/authoring/attachments.h>
#include <ecorche/core/result.h>

#include <string>
#include <vector>

namespace ecorche::authoring {

/// Names of muscles as a user gives them: separated by commas, or in a file, one a line, where #
/// starts a comment.
/// @errors  FileNotReadable, FileEmpty (a file without names)
[[nodiscard]] Result<std::vector<std::string>> muscleNamesFrom(const std::string& listOrFile);

/// The muscles of a table that have one of these names, in table order. Names are compared by
/// letters and digits alone; one without a side means both sides.
/// @errors  UnknownName (with names of the table that are like it)
[[nodiscard]] Result<std::vector<MuscleSites>> chosenMuscles(const std::vector<MuscleSites>& table,
                                                             const std::vector<std::string>& names);

}  // namespace ecorche::authoring
