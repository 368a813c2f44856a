#pragma once

#include <ecorche/core/finding.h>
#include <ecorche/mesh/surface_mesh.h>

#include <optional>
#include <vector>

namespace ecorche::mesh {

struct SurfaceCheckOptions {
  /// Look for faces that cut one another: about ten times the time of all the rest.
  bool selfIntersections = false;
};

/// What is right and wrong with a surface. Counts say how much, findings say it in sentences with a
/// place each.
struct SurfaceCheck {
  /// A connected border.
  struct Hole {
    Vector3 place = Vector3::Zero();  ///< middle of the border's box [m]
    double extent = 0.0;              ///< diagonal of the border's box [m]
    double perimeter = 0.0;           ///< [m]
    std::int64_t edges = 0;
    std::int32_t piece = 0;  ///< into components
    Box box;
  };
  /// A piece that hangs together by edges.
  struct Component {
    std::int32_t firstFace = 0;
    std::int64_t faces = 0;
    Box box;
    double area = 0.0;    ///< [m²]
    double volume = 0.0;  ///< signed [m³]; of no meaning where not closed
    bool closed = false;  ///< no border, consistently oriented
    bool inward =
        false;  ///< closed with negative volume: turned inside out, or the wall of a cavity
    std::optional<int> genus;  ///< handles; of closed manifold pieces
  };

  std::int64_t nonFiniteVertices = 0;
  std::int64_t unusedVertices = 0;
  std::int64_t duplicateVertices = 0;  ///< used vertices at exactly the place of an earlier one
  std::int64_t degenerateFaces =
      0;  ///< without area: a vertex named twice, or three on a line, exactly
  std::int64_t duplicateFaces = 0;  ///< over the same three vertices as an earlier one
  std::int64_t borderEdges = 0;
  std::int64_t nonManifoldEdges = 0;              ///< with more than two faces
  std::int64_t nonManifoldVertices = 0;           ///< where several fans of faces meet
  std::int64_t inconsistentEdges = 0;             ///< with two faces that run the same way
  std::optional<std::int64_t> selfIntersections;  ///< pairs of faces; where it was asked for
  std::vector<Hole> holes;                        ///< largest extent first
  std::vector<Component> components;              ///< in order of first face

  Findings findings;

  /// Without border, manifold, oriented, every face with an area: what subtraction and
  /// tetrahedralisation need besides freedom from self-intersections.
  [[nodiscard]] bool isSound() const;
};

/// Looks at everything above. Any mesh with valid indices is welcome; a mesh with non-finite
/// vertices is looked at no further. Findings name the mesh by its name.
[[nodiscard]] SurfaceCheck checkSurface(const SurfaceMesh& mesh,
                                        const SurfaceCheckOptions& options = {});

/// Sound and free of self-intersections: fit for exact subtraction and for tets.
[[nodiscard]] bool isUncrossed(const SurfaceMesh& mesh);

}  // namespace ecorche::mesh
