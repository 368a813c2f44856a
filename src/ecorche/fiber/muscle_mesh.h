#pragma once

#include <ecorche/core/ids.h>
#include <ecorche/domain/domain.h>
#include <ecorche/envelope/anatomy.h>

#include <vector>

namespace ecorche::fiber {

/// A face of a muscle's surface and what lies beyond it.
struct MuscleFace {
  std::array<std::int32_t, 3> v{};  ///< local vertices, facing outward
  std::int32_t tet = -1;            ///< local
  std::int32_t boundary = -1;   ///< place in Anatomy::boundaryTag; -1: another tissue lies beyond
  TissueId beyond = kNoTissue;  ///< that tissue; none on the domain's boundary
};

/// One muscle's tets with vertices numbered from 0, in the anatomy's order.
struct MuscleMesh {
  TissueId tissue;
  std::vector<std::int32_t> tetId;     ///< local → anatomy
  std::vector<std::int32_t> vertexId;  ///< local → anatomy
  mesh::TetMesh mesh;
  mesh::TetNeighbours neighbours;  ///< within the muscle
  Eigen::VectorXd volume;          ///< #T [m³]
  std::vector<MuscleFace> surface;
  std::vector<std::int32_t> component;  ///< #T face-connected components, numbered by first tet
  std::vector<double> componentVolume;  ///< [m³]

  [[nodiscard]] mesh::Vector3 centroid(std::int64_t tet) const;
};

/// Anatomy tets of every tissue, ascending; index = tissue id.
[[nodiscard]] std::vector<std::vector<std::int32_t>> tetsByTissue(const envelope::Anatomy& anatomy);

/// Every tet's place among those of its tissue: the other way round.
[[nodiscard]] std::vector<std::int32_t> placesInTissue(
    const std::vector<std::vector<std::int32_t>>& tets, std::size_t tetCount);

/// For 4·tet + corner the boundary face opposite that corner, -1 elsewhere.
[[nodiscard]] std::vector<std::int32_t> boundaryOfSlot(const envelope::Anatomy& anatomy);

/// @param tets           of one tissue, ascending
/// @param placeInTissue  from placesInTissue
/// @param boundaryOf     from boundaryOfSlot
[[nodiscard]] MuscleMesh extractMuscle(const envelope::Anatomy& anatomy, TissueId tissue,
                                       const std::vector<std::int32_t>& tets,
                                       const std::vector<std::int32_t>& placeInTissue,
                                       const std::vector<std::int32_t>& boundaryOf);

}  // namespace ecorche::fiber
