#pragma once

#include <ecorche/domain/build_domain.h>

#include <optional>
#include <string>
#include <string_view>

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

/// The bytes of a cached domain, and back; nothing where they are not whole. They believe nothing:
/// whoever wrote the file may have been killed half-way.
[[nodiscard]] std::string encodeCached(const DomainBuild& build);
[[nodiscard]] std::optional<DomainBuild> decodeCached(std::string_view bytes);

/// A body as encodeCached seals it, with its checksum: for tests that damage what is inside.
[[nodiscard]] std::string sealed(std::string_view body);

}  // namespace ecorche::domain
