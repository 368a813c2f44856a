#include <ecorche/render/volume_content.h>

namespace ecorche::render {

std::shared_ptr<VolumeContent> prepareVolume(const VolumeItem& item,
                                             const std::optional<ClipPlane>& clip) {
  auto out = std::make_shared<VolumeContent>();
  out->update(item, clip);
  return out;
}

void VolumeContent::smoothFields(const VolumeItem& item, bool otherTets) {
  const bool same = item.fields == fields_ && item.fieldsRevision == fieldsRevision_;
  if (same && !otherTets) return;
  const bool next = !otherTets && item.changed && item.fieldsRevision == fieldsRevision_ + 1;
  smoothed_.update(*geometry_, *item.fields, next ? &*item.changed : nullptr);
  fields_ = item.fields;
  fieldsRevision_ = item.fieldsRevision;
}

void VolumeContent::update(const VolumeItem& item, const std::optional<ClipPlane>& clip) {
  const std::vector<VolumeLayer> wanted = volumeLayers(item);
  const bool otherTets = item.geometry != geometry_;
  if (otherTets) {
    geometry_ = item.geometry;
    layers_.clear();
  }
  smoothFields(item, otherTets);
  layers_.resize(wanted.size());
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    if (!layers_[i]) layers_[i] = std::make_unique<Layer>();
    layers_[i]->layer = wanted[i];
    layers_[i]->records.update(item, smoothed_, wanted[i], clip);
  }
}

}  // namespace ecorche::render
