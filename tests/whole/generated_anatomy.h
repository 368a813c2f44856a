#pragma once

#include <ecorche/mesh/surface_mesh.h>
#include <ecorche/model/project.h>

#include <cstdint>
#include <filesystem>

namespace ecorche::test {

/// A limb nobody has: a bent, tapering tube for a skin, one to four capsules for bones, of which
/// some touch, overlap or poke out of the skin, and one to six muscles with curves from bone to
/// bone, all by chance. The same seed gives the same anatomy on every machine, but for the last
/// digits of sines.
struct GeneratedAnatomy {
  model::Project project;  ///< names meshes that lie in `folder` after generateAnatomy
  bool bonesTouch = false;
  bool bonePokesOut = false;
};

/// Writes skin and bones to the folder.
/// @param tets  what the project asks for
[[nodiscard]] GeneratedAnatomy generateAnatomy(std::uint64_t seed, std::int64_t tets,
                                               const std::filesystem::path& folder);

}  // namespace ecorche::test
