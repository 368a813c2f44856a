#pragma once

#include <ecorche/core/result.h>

#include <cstdint>
#include <string>

namespace ecorche::engine {

/// What a build will take, told before it begins. Within a factor of two of what it takes on a
/// desktop machine; docs/decisions.md has the measurements.
struct Estimate {
  std::int64_t tets = 0;         ///< of the domain
  std::int64_t memoryBytes = 0;  ///< at the worst moment, program and worker together
  double seconds = 0.0;          ///< wall time without a cached domain

  /// "about 640 k tets, 3.1 GB and 70 s"
  [[nodiscard]] std::string text() const;
};

/// @param tets     asked for
/// @param muscles  with fillers
/// @param faces    of all input meshes
[[nodiscard]] Estimate estimateBuild(std::int64_t tets, std::int64_t muscles, std::int64_t faces);

/// Memory that this process may still have: what the machine has to spare and what its group is
/// allowed. ECORCHE_MEMORY (bytes) takes its place.
[[nodiscard]] std::int64_t availableMemory();

/// Refuses what the machine cannot hold, with a number of tets that it can.
/// @errors OutOfMemory
[[nodiscard]] Result<void> requireMemory(const Estimate& estimate, std::int64_t muscles,
                                         std::int64_t faces);

}  // namespace ecorche::engine
