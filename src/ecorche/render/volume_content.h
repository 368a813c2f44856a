#pragma once

// Private to render's sources; others hold one by its pointer (volume_item.h).

#include <ecorche/render/volume_layers.h>
#include <ecorche/render/volume_records.h>

#include <memory>
#include <optional>
#include <vector>

namespace ecorche::render {

/// All that drawing a volume needs and that takes time to make: smoothed fields, and every layer's
/// records. Knows no OpenGL, so that another thread can make it (prepareVolume).
class VolumeContent {
 public:
  struct Layer {
    VolumeLayer layer;
    VolumeRecords records;
  };

  /// In step with the item; only what differs from last time is made anew.
  void update(const VolumeItem& item, const std::optional<ClipPlane>& clip);

  [[nodiscard]] const std::shared_ptr<const VolumeGeometry>& geometry() const { return geometry_; }
  [[nodiscard]] const std::vector<std::unique_ptr<Layer>>& layers() const { return layers_; }

 private:
  std::shared_ptr<const VolumeGeometry> geometry_;
  SmoothedFields smoothed_;
  std::shared_ptr<const tissue::FieldMatrix> fields_;  // that smoothed_ is of
  std::uint64_t fieldsRevision_ = 0;
  std::vector<std::unique_ptr<Layer>> layers_;

  void smoothFields(const VolumeItem& item, bool otherTets);
};

}  // namespace ecorche::render
