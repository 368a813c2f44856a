#pragma once

#include <ecorche/domain/domain.h>

#include <cstdint>
#include <vector>

namespace ecorche::domain {

/// A closed surface whose faces know what they belong to; the shape of the domain before it is
/// filled with tets.
struct TaggedSurface {
  mesh::Positions V;              ///< #V×3 [m]
  mesh::Triangles F;              ///< #F×3, facing out of the domain
  std::vector<std::int32_t> tag;  ///< #F, packed(BoundaryTag)
};

/// A BoundaryTag in one number, for files and for mesh libraries that carry integers.
[[nodiscard]] constexpr std::int32_t packed(BoundaryTag tag) {
  return static_cast<std::int32_t>(tag.kind) * 0x100000 + tag.index;
}
[[nodiscard]] constexpr BoundaryTag unpacked(std::int32_t code) {
  return {static_cast<BoundaryTag::Kind>(code / 0x100000), code % 0x100000};
}

/// All faces of the mesh with one tag.
[[nodiscard]] TaggedSurface tagged(const mesh::SurfaceMesh& mesh, BoundaryTag tag);

/// The faces that carry a tag, vertices renumbered in order of first use by index.
[[nodiscard]] mesh::SurfaceMesh facesOf(const TaggedSurface& surface, std::int32_t tag);

/// The point of the plane nearest to p: up to rounding, and exactly where the unit normal is an
/// axis.
[[nodiscard]] mesh::Vector3 ontoPlane(const CutPlane& plane, mesh::Vector3 p);

/// Vertices by coordinates, faces by their vertices: the same surface in the same order, whatever
/// order it was made in.
[[nodiscard]] TaggedSurface ordered(const TaggedSurface& surface);

/// Without vertices that no face uses.
[[nodiscard]] TaggedSurface compacted(const TaggedSurface& surface);

}  // namespace ecorche::domain
