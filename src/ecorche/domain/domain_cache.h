#pragma once

#include <ecorche/domain/build_domain.h>

#include <optional>
#include <string>

namespace ecorche::domain {

/// Names a domain by what it was made from: meshes, planes, curves, options, and this code's
/// version of the answer.
[[nodiscard]] std::string cacheKey(const DomainInput& input, const DomainOptions& options);

/// The domain of that key; nothing where there is none. A damaged file is removed and gives a
/// finding.
[[nodiscard]] std::optional<DomainBuild> loadCached(const std::string& key, Findings& findings);

/// Leaves the domain in the cache, whole or not at all; the oldest go when all together exceed 4
/// GB. A cache that cannot be written is no error.
void storeCached(const std::string& key, const DomainBuild& build);

}  // namespace ecorche::domain
