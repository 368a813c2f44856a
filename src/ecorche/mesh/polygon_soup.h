#pragma once

#include <ecorche/mesh/surface_mesh.h>

#include <array>
#include <string>
#include <vector>

namespace ecorche::mesh {

/// What a file holds before it is made of triangles: polygons over shared vertices, each in a part.
struct PolygonSoup {
  std::vector<double> xyz;            ///< 3·#V [the file's unit]
  std::vector<std::int32_t> corners;  ///< vertex numbers of all polygons, one after another
  std::vector<std::int32_t> size;     ///< #polygons, each at least 3
  std::vector<std::int32_t> part;     ///< #polygons, into partNames; empty: no parts
  std::vector<std::string> partNames;

  [[nodiscard]] std::int32_t vertexCount() const {
    return static_cast<std::int32_t>(xyz.size() / 3);
  }
};

/// Triangles of a soup; faces of a part in their order, parts in order of first face, parts without
/// faces left out.
///
/// A quad is cut along the diagonal that keeps both halves facing the same way, the shorter one if
/// both do. Larger polygons are cut ear by ear in the plane that fits them best, so concave ones
/// come out right; no polygon takes more than a bounded time, whatever its shape.
[[nodiscard]] SurfaceMesh triangulated(const PolygonSoup& soup);

/// n − 2 triangles of one polygon, as numbers of its corners 0 … n − 1; its own orientation is
/// kept.
[[nodiscard]] std::vector<std::array<std::int32_t, 3>> triangulatePolygon(
    const std::vector<Vector3>& polygon);

}  // namespace ecorche::mesh
