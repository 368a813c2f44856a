#pragma once

#include <ecorche/mesh/surface_repair.h>

#include <optional>
#include <string_view>

namespace ecorche::mesh {

/// What a user may ask for where certain repairs do not do. Each changes what the surface says, so
/// none happens unasked.
enum class Mending {
  None,
  FillHoles,  ///< every hole is closed, however large, over its border
  OuterHull,  ///< only what is seen from outside stays: inner walls, inner coats, hollows go
  Wrap        ///< holes are filled, then a closed skin is laid around everything but open sheets
};

/// "none", "fill-holes", "outer-hull", "wrap", as project files and commands have it; and back.
[[nodiscard]] std::string_view name(Mending how);
[[nodiscard]] std::optional<Mending> mendingNamed(std::string_view word);

/// A wrap bridges gaps and bags narrower than this share of the diagonal, and lies outside by the
/// other.
inline constexpr double kWrapGapRel = 0.01;
inline constexpr double kWrapOffsetRel = 0.0005;

/// The surface as it was asked to be mended. What was done is told with its size, and how far the
/// result is from what was given, one way and the other.
///
/// @return  closed, oriented, outward; for OuterHull and Wrap free of self-intersections. None: as
///          it was, without findings.
/// @errors  those of repairSurface; SkinNotClosed (a hole that cannot be filled), MeshNotRepairable
///          (no outer hull: the message names the way out), Cancelled
[[nodiscard]] Result<RepairedSurface> mendSurface(const SurfaceMesh& mesh, Mending how,
                                                  RunContext& run);

}  // namespace ecorche::mesh
