#pragma once

#include <ecorche/core/finding.h>
#include <ecorche/mesh/surface_mesh.h>

#include <optional>
#include <string>
#include <vector>

namespace ecorche::mesh {

/// A bone, or all of them, that seems to be written in another unit than the skin.
struct UnitMismatch {
  std::optional<std::size_t> bone;  ///< unset: all of them, or the skin against all of them
  double factor = 1.0;  ///< how many times too large it is: 10, 25.4, 100, 1000 or one over these
  /// It lies where no bone can be, and would lie inside the skin in another unit. Otherwise it
  /// could be meant.
  bool certain = false;
  std::string message;  ///< names both, the sizes, the factor and the way out
};

/// Looks for bones that do not fit the skin but would if they were 10, 25.4, 100 or 1000 times
/// smaller or larger about the origin, as a wrong unit makes them. Boxes are compared, nothing
/// else; what lies elsewhere for another reason (another frame) is no matter of units.
[[nodiscard]] std::vector<UnitMismatch> unitMismatches(const SurfaceMesh& skin,
                                                       const std::vector<SurfaceMesh>& bones);

}  // namespace ecorche::mesh
