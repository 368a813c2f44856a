#pragma once

#include <ecorche/tissue/tissue_fields.h>

#include <vector>

namespace ecorche::tissue {

/// Areas of a tissue's cross-sections [m²] with planes across `direction`, at the given distances
/// from `origin` [m]. Exact for fields that are linear in every tet: the polygon of each tet is
/// clipped where another field is larger.
[[nodiscard]] std::vector<double> crossSectionAreas(const mesh::TetMesh& mesh,
                                                    const TissueFields& fields, TissueId tissue,
                                                    const mesh::Vector3& origin,
                                                    const mesh::Vector3& direction,
                                                    const std::vector<double>& distances);

}  // namespace ecorche::tissue
