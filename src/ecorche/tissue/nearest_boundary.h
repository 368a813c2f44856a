#pragma once

#include <ecorche/domain/domain.h>

#include <optional>

namespace ecorche::tissue {

/// Point of the domain's boundary nearest to p, and how far it is. Looks at every face: for a few
/// questions.
struct BoundaryHit {
  std::int32_t face = -1;  ///< -1: no such face
  mesh::Vector3 point = mesh::Vector3::Zero();
  double distance = 0.0;  ///< [m]
};
/// @param kind  only faces of this kind; unset: all
[[nodiscard]] BoundaryHit nearestOnBoundary(const domain::Domain& domain, const mesh::Vector3& p,
                                            std::optional<domain::BoundaryTag::Kind> kind = {});

/// Point of triangle abc nearest to p.
[[nodiscard]] mesh::Vector3 nearestOnTriangle(const mesh::Vector3& p, const mesh::Vector3& a,
                                              const mesh::Vector3& b, const mesh::Vector3& c);

}  // namespace ecorche::tissue
