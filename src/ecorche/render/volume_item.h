#pragma once

#include <ecorche/render/volume_geometry.h>
#include <ecorche/tissue/tissue_fields.h>

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

namespace ecorche::render {

/// How one tissue looks where it is drawn straight from the fields.
struct VolumeTissue {
  std::array<float, 4> colour{0.5f, 0.2f, 0.15f, 1.0f};  ///< linear light; alpha is not looked at
  float roughness = 0.36f;                               ///< 0 mirror … 1 chalk
  /// Below 1 the others show through it (x-ray), as through skin: denser where it turns away.
  float opacity = 1.0f;
  bool visible = true;
  /// Shown where the clip plane cuts it although it is not visible otherwise: fat, as a rule.
  bool inCut = false;
  /// Where it is drawn, away from its place (exploded view) [m].
  mesh::Vector3 shift = mesh::Vector3::Zero();
};

/// Tissues drawn straight from their fields: inside a tet every field is linear, so what owns a
/// point and where ownership changes along a ray is solved exactly. What is seen is the first point
/// along the ray that belongs to a visible tissue.
///
/// Arrays are shared with whoever made them. A new fieldsRevision means new values; `changed` then
/// says where, so that only that goes to the graphics card.
struct VolumeItem {
  std::shared_ptr<const VolumeGeometry> geometry;
  std::shared_ptr<const tissue::FieldMatrix> fields;  ///< #V×#tissues, column i tissue id i + 1
  bool fatIsCandidate = true;                         ///< false: fat owns nothing
  std::uint64_t fieldsRevision = 0;
  /// Vertices whose values may differ from those of revision fieldsRevision − 1. Null: any.
  std::shared_ptr<const std::vector<std::int32_t>> changed;
  std::vector<VolumeTissue> tissues;  ///< #tissues, entry i of tissue id i + 1: fat first
  /// Directions along which muscles contract, unit, for fine lines along them; null: none.
  std::shared_ptr<const mesh::Directions> flow;  ///< #V×3
};

}  // namespace ecorche::render
