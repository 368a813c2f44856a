#pragma once

#include <ecorche/render/volume_geometry.h>
#include <ecorche/tissue/tissue_fields.h>

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
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

struct ClipPlane {
  mesh::Vector3 point = mesh::Vector3::Zero();    // [m]
  mesh::Vector3 normal = mesh::Vector3::UnitX();  // what the normal points at is kept

  bool operator==(const ClipPlane&) const = default;
};

/// Where fields have changed since the revision before.
struct FieldChange {
  std::vector<std::int32_t> vertices;  ///< ascending, each once
  std::vector<std::int32_t> columns;   ///< ascending, each once
};

class VolumeContent;

/// Tissues drawn straight from their fields: inside a tet every field is linear, so what owns a
/// point and where ownership changes along a ray is solved exactly. What is seen is the first point
/// along the ray that belongs to a visible tissue.
///
/// Arrays are shared with whoever made them. A new fieldsRevision means new values; `changed` then
/// says where, so that only that is made anew and goes to the graphics card.
struct VolumeItem {
  std::shared_ptr<const VolumeGeometry> geometry;
  std::shared_ptr<const tissue::FieldMatrix> fields;  ///< #V×#tissues, column i tissue id i + 1
  bool fatIsCandidate = true;                         ///< false: fat owns nothing
  std::uint64_t fieldsRevision = 0;
  /// What may differ from revision fieldsRevision − 1. Null: anything.
  std::shared_ptr<const FieldChange> changed;
  std::vector<VolumeTissue> tissues;  ///< #tissues, entry i of tissue id i + 1: fat first
  /// Directions along which muscles contract, unit, for fine lines along them; null: none.
  std::shared_ptr<const mesh::Directions> flow;  ///< #V×3
  /// From prepareVolume: taken over by the renderer that draws the item next. Null: it makes its
  /// own.
  std::shared_ptr<VolumeContent> prepared;
};

/// What a renderer has to make before it can draw the item: nearly all the time that a first
/// picture of other fields takes. For threads that nobody waits for. Whatever the item looks like
/// once it is drawn, the picture is right; what has changed since is made then.
[[nodiscard]] std::shared_ptr<VolumeContent> prepareVolume(const VolumeItem& item,
                                                           const std::optional<ClipPlane>& clip);

}  // namespace ecorche::render
