#pragma once

#include <string>
#include <vector>

namespace ecorche::exchange {

/// File names (without ending) for things with any names: letters a–z, A–Z, digits, '-', '_' and
/// '.', no dot or dash in front, none that Windows reserves, at most 100 bytes, different even
/// where case does not count. What is good already stays as it is; the order decides who keeps a
/// name that two want.
[[nodiscard]] std::vector<std::string> fileNames(const std::vector<std::string>& names);

}  // namespace ecorche::exchange
