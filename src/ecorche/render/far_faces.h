#pragma once

// Private to render's sources.

#include <ecorche/mesh/surface_mesh.h>
#include <ecorche/render/shading_mesh.h>

#include <cstdint>
#include <vector>

namespace ecorche::render {

/// A surface's faces as they look from so far that what lies in one cell is one pixel.
struct FarFaces {
  double cell = 0.0;                   ///< no vertex has gone farther than its diagonal [m]
  std::vector<std::uint32_t> corners;  ///< three per face, of the shading mesh's vertices
};

/// Ever coarser ones, each with at most two thirds of the faces of the one before: vertices of one
/// cell of a grid become that which is nearest to their mean [Rossignac & Borrel 1993], faces that
/// are left without area go. Grids are the item's own, of 1024 to 4 cells along its diagonal; few
/// faces have none. Deterministic.
[[nodiscard]] std::vector<FarFaces> farFaces(const mesh::SurfaceMesh& mesh,
                                             const ShadingMesh& shading);

}  // namespace ecorche::render
