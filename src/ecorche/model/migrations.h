#pragma once

#include <ecorche/model/json.h>

#include <span>

namespace ecorche::model {

/// One step from a schema to the next. Works on the tree, so that places in the file stay known.
struct Migration {
  int from = 0;
  Result<void> (*apply)(Json& root);
};

/// All steps, by `from`. Schema 1 is the first, so the list is empty until there is a second; a new
/// schema adds the step from its predecessor here and nothing else.
[[nodiscard]] std::span<const Migration> migrations();

/// Brings a file's tree from its "schema" to `newest` by one step after another, and sets "schema".
/// @errors MissingKey, WrongType, ValueOutOfRange (no such schema), SchemaTooNew, what a step says
[[nodiscard]] Result<void> migrate(Json& root, int newest, std::span<const Migration> steps,
                                   const std::string& file);

}  // namespace ecorche::model
