#pragma once

#include <ecorche/render/ray_caster.h>
#include <ecorche/render/views.h>
#include <ecorche/render/volume_item.h>

#include <memory>
#include <utility>

#include "support/generated_anatomy.h"

namespace ecorche::test {

/// A generated anatomy as something to draw: fat hidden but shown in cuts, every tissue a colour of
/// its own.
inline render::VolumeItem volumeItem(const domain::Domain& domain,
                                     const tissue::FieldMatrix& fields, bool fatIsCandidate) {
  render::VolumeItem item;
  item.geometry = std::make_shared<const render::VolumeGeometry>(
      std::make_shared<const mesh::TetMesh>(domain.mesh), domain.neighbours);
  item.fields = std::make_shared<const tissue::FieldMatrix>(fields);
  item.fatIsCandidate = fatIsCandidate;
  item.fieldsRevision = 1;
  item.tissues.resize(static_cast<std::size_t>(fields.cols()));
  for (std::size_t i = 0; i < item.tissues.size(); ++i) {
    const auto x = static_cast<float>(i);
    item.tissues[i].colour = {0.3f + 0.5f * (x / 9.0f), 0.2f, 0.7f - 0.5f * (x / 9.0f), 1.0f};
  }
  item.tissues[0].visible = false;
  item.tissues[0].inCut = true;
  return item;
}
inline render::VolumeItem volumeItem(const GeneratedAnatomy& anatomy) {
  return volumeItem(anatomy.domain, anatomy.fields.values, anatomy.fields.fatIsCandidate);
}

/// The whole of an item from a side.
inline render::Camera cameraOn(const render::VolumeItem& item, double azimuthDeg,
                               double elevationDeg, double fovDeg = 24.0) {
  const mesh::Box box = item.geometry->box();
  return render::framed({azimuthDeg, elevationDeg, fovDeg, 1.0}, render::guessedAxes(box, 'Z'), box,
                        1.0);
}

}  // namespace ecorche::test
