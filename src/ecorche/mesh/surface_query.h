#pragma once

#include <ecorche/core/result.h>
#include <ecorche/core/run_context.h>
#include <ecorche/mesh/surface_mesh.h>

#include <algorithm>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

namespace ecorche::mesh {

/// Answers closest-point, ray and inside questions about a surface it keeps a copy of: a box tree
/// (CGAL AABB), doubles, and exact predicates wherever a side has to be decided. Safe to ask from
/// many threads at once.
///
/// Triangles without area are left out. A surface without any other triangle may be asked, but has
/// nothing to answer: closest() requires a triangle.
class SurfaceQuery {
 public:
  SurfaceQuery(const Positions& V, const Triangles& F);
  explicit SurfaceQuery(const SurfaceMesh& mesh) : SurfaceQuery(mesh.V, mesh.F) {}
  SurfaceQuery(SurfaceQuery&&) noexcept;
  SurfaceQuery& operator=(SurfaceQuery&&) noexcept;
  ~SurfaceQuery();

  [[nodiscard]] bool empty() const;

  struct Closest {
    Vector3 point;  ///< on the surface [m]
    std::int32_t face = -1;
    double distance = 0.0;  ///< [m]
  };
  [[nodiscard]] Closest closest(const Vector3& p) const;
  [[nodiscard]] double distance(const Vector3& p) const { return closest(p).distance; }
  /// Negative inside (see inside).
  [[nodiscard]] double signedDistance(const Vector3& p) const;

  struct Hit {
    double t = 0.0;  ///< the hit is at origin + t·direction
    std::int32_t face = -1;
    Vector3 point;
    bool entering =
        false;  ///< against the face's normal: from outside where the mesh faces outward
  };
  /// Hits with t in [0, tMax], nearest first. A ray through an edge hits all its faces; one that
  /// runs within a face's plane passes it by. Nothing slips through between neighbouring faces.
  /// @param direction  any length but 0
  [[nodiscard]] std::vector<Hit> allHits(
      const Vector3& origin, const Vector3& direction,
      double tMax = std::numeric_limits<double>::infinity()) const;
  [[nodiscard]] std::optional<Hit> firstHit(
      const Vector3& origin, const Vector3& direction,
      double tMax = std::numeric_limits<double>::infinity()) const;

  /// How often the surface, which must be closed, winds around p: 1 inside one outward shell, 0
  /// outside and in cavities with inward shells, 2 where two shells overlap, −1 inside an inward
  /// shell. Exact; nothing where p is on the surface.
  [[nodiscard]] std::optional<int> windingNumber(const Vector3& p) const;
  /// Winding number other than 0, or on the surface.
  [[nodiscard]] bool inside(const Vector3& p) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// How far two surfaces are apart, one way and the other.
struct SurfaceDeviation {
  struct OneWay {
    double max = 0.0;                 ///< [m]
    double mean = 0.0;                ///< by area [m]
    Vector3 place = Vector3::Zero();  ///< where on the first surface the largest distance was found
  };
  OneWay aToB;
  OneWay bToA;
  [[nodiscard]] double max() const { return std::max(aToB.max, bToA.max); }
};

/// Distances of points on each surface to the other: all vertices, and points of every face no
/// farther apart than `sampleSpacing` [m] (a million points a face at most). True Hausdorff
/// distances are at most sampleSpacing larger than the maxima. Both have faces.
/// @errors  Cancelled, MeshWithoutFaces (no triangle with an area on one side)
[[nodiscard]] Result<SurfaceDeviation> surfaceDeviation(const SurfaceMesh& a, const SurfaceMesh& b,
                                                        double sampleSpacing, RunContext& run);

}  // namespace ecorche::mesh
