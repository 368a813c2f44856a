#pragma once

#include <ecorche/core/result.h>

#include <filesystem>

namespace ecorche::studio {

/// An example that comes with the program: beside it, where it was installed, or in the source tree
/// that it was built from.
/// @errors FileMissing, with the places that were looked at
[[nodiscard]] Result<std::filesystem::path> exampleFile(const std::filesystem::path& name);

}  // namespace ecorche::studio
