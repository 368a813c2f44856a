#pragma once

#include <ecorche/core/ids.h>
#include <ecorche/envelope/anatomy.h>
#include <ecorche/mesh/surface_mesh.h>
#include <ecorche/tissue/tissue_fields.h>

#include <vector>

namespace ecorche::envelope {

/// What lies on the other side of a face of a tissue's surface.
struct Beyond {
  TissueId tissue;          ///< the neighbour; kNoTissue on the domain's boundary
  domain::BoundaryTag tag;  ///< what the boundary is there; unused between tissues
};

/// The closed surface of one tissue, triangles shared with its neighbours.
struct TissueSurface {
  TissueId tissue;
  mesh::SurfaceMesh mesh;            ///< facing outward; empty where the tissue has no tets
  std::vector<std::int32_t> vertex;  ///< #V the anatomy's vertex of each
  std::vector<std::int32_t> tet;     ///< #F the anatomy's tet inside of each
  std::vector<Beyond> beyond;        ///< #F
};

/// Where a tissue touches a bone or a cut plane.
struct Attachment {
  domain::BoundaryTag tag;
  double area = 0.0;                               ///< [m²]
  mesh::Vector3 centroid = mesh::Vector3::Zero();  ///< of the area [m]
};

/// Surfaces of tissues 1 … tissueCount (fat first), entry i of id i + 1.
/// @param names  of the tissues, as many
[[nodiscard]] std::vector<TissueSurface> tissueSurfaces(const Anatomy& anatomy,
                                                        const std::vector<std::string>& names);

/// Contacts with bones and cut planes, by tag.
[[nodiscard]] std::vector<Attachment> attachmentsOf(const TissueSurface& surface);

struct TissueMeasure {
  double volume = 0.0;  ///< [m³]
  std::int64_t tets = 0;
  std::int64_t components = 0;  ///< face-connected
};
/// Of tissues 1 … tissueCount, entry i of id i + 1.
[[nodiscard]] std::vector<TissueMeasure> measureTissues(const Anatomy& anatomy,
                                                        std::size_t tissueCount);

/// Unit normals for pictures: on interfaces the downhill direction of f_i − f_j averaged over the
/// tets around each vertex, so that shading shows the smooth field and not the facets; elsewhere
/// the surface's own.
[[nodiscard]] mesh::Directions fieldNormals(const TissueSurface& surface, const Anatomy& anatomy,
                                            const domain::Domain& domain,
                                            const tissue::TissueFields& fields);

}  // namespace ecorche::envelope
