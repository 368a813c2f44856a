#pragma once

#include <ecorche/mesh/surface_query.h>

#include <functional>
#include <optional>

namespace ecorche::mesh {

/// A surface ready to be compared with others.
struct ContactBody {
  explicit ContactBody(const SurfaceMesh& surface)
      : mesh(surface), query(surface), box(boundingBox(surface)) {}
  const SurfaceMesh& mesh;
  SurfaceQuery query;
  Box box;
};

/// How two closed surfaces get in each other's way.
struct SurfaceContact {
  enum class Kind {
    Touch,    ///< nearer than the tolerance, neither in the other
    Overlap,  ///< part of each lies in the other
    Within    ///< the first lies in the second altogether
  };
  Kind kind = Kind::Touch;
  double depth = 0.0;   ///< how far a vertex lies in the other; Touch: how near [m]
  double volume = 0.0;  ///< of what both hold, counted on a lattice, within some per cent [m³]
  Vector3 place = Vector3::Zero();  ///< where it is deepest, or nearest
};

/// Nothing where they are farther apart than the tolerance. Vertices and a lattice are asked, so a
/// needle between all of them is missed. Open surfaces give what their winding says.
[[nodiscard]] std::optional<SurfaceContact> contactOf(const ContactBody& a, const ContactBody& b,
                                                      double tolerance);

/// What of a body lies outside another; nothing where it lies inside altogether.
struct PokingOut {
  double depth = 0.0;   ///< of the farthest vertex [m]
  double volume = 0.0;  ///< counted on a lattice [m³]
  Vector3 place = Vector3::Zero();
};
/// @param counts  points for which it is false do not count; unset: all do
[[nodiscard]] std::optional<PokingOut> pokingOut(
    const ContactBody& body, const ContactBody& skin,
    const std::function<bool(const Vector3&)>& counts = {});

}  // namespace ecorche::mesh
