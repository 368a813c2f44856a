#pragma once

#include <ecorche/core/finding.h>
#include <ecorche/core/ids.h>
#include <ecorche/core/result.h>
#include <ecorche/core/run_context.h>
#include <ecorche/mesh/surface_mesh.h>
#include <ecorche/mesh/tet_mesh.h>

#include <optional>
#include <string>
#include <vector>

namespace ecorche::domain {

/// What a boundary face of the domain belongs to. `index` counts bones, cut planes, obstacles or
/// cavities in input order.
struct BoundaryTag {
  enum class Kind : std::uint8_t { Skin, Bone, CutPlane, Obstacle, Cavity };
  Kind kind = Kind::Skin;
  std::int32_t index = 0;
  auto operator<=>(const BoundaryTag&) const = default;
};

/// Keeps the half space that the normal points into; its faces carry no skin constraint [ABLSJ21
/// §5].
struct CutPlane {
  std::string name;
  mesh::Vector3 point = mesh::Vector3::Zero();    // [m]
  mesh::Vector3 normal = mesh::Vector3::UnitY();  // unit
};

/// skin minus bones, obstacles and cavities, on the kept side of every cut plane, in tets.
struct Domain {
  mesh::TetMesh mesh;
  mesh::TetNeighbours neighbours;         ///< #T×4
  mesh::Triangles boundaryF;              ///< facing outward
  std::vector<std::int32_t> boundaryTet;  ///< #B the tet of each boundary face
  std::vector<BoundaryTag> boundaryTag;   ///< #B
  std::vector<std::uint8_t>
      onSkin;  ///< #V 1 where the fields are fixed: a skin face touches the vertex

  std::vector<std::string> boneNames;
  std::vector<std::string> cutPlaneNames;
  double skinDiagonal = 0.0;  ///< bounding-box diagonal of the uncut skin [m]
  double volume = 0.0;        ///< sum of tet volumes [m³]

  [[nodiscard]] std::int64_t freeVertexCount() const;  ///< vertices that are not skin
};

}  // namespace ecorche::domain
