#include <ecorche/core/contract.h>
#include <ecorche/render/volume_layers.h>

#include <algorithm>

namespace ecorche::render {

std::vector<VolumeLayer> volumeLayers(const VolumeItem& item) {
  EC_REQUIRE(item.geometry != nullptr && item.fields != nullptr);
  EC_REQUIRE_EQ(item.fields->rows(), item.geometry->mesh().V.rows());
  EC_REQUIRE_EQ(static_cast<Eigen::Index>(item.tissues.size()), item.fields->cols());
  std::vector<VolumeLayer> layers;
  const auto layerOf = [&](const mesh::Vector3& shift, bool veil) -> VolumeLayer& {
    for (VolumeLayer& layer : layers)
      if (layer.shift == shift && layer.veil == veil) return layer;
    layers.push_back({shift, veil, std::vector<Role>(item.tissues.size(), Role::Hidden)});
    return layers.back();
  };
  for (std::size_t i = 0; i < item.tissues.size(); ++i) {
    const VolumeTissue& tissue = item.tissues[i];
    if (tissue.visible) {
      layerOf(tissue.shift, tissue.opacity < 1.0f).role[i] = Role::Seen;
    } else if (tissue.inCut) {
      layerOf(tissue.shift, false).role[i] = Role::Cut;
    }
  }
  std::ranges::stable_partition(layers, [](const VolumeLayer& layer) { return !layer.veil; });
  return layers;
}

Eigen::Vector3f interfaceNormal(const VolumeGeometry& geometry, const tissue::FieldMatrix& fields,
                                std::int32_t vertex, Eigen::Index inside, Eigen::Index outside) {
  const VolumeGeometry::Stencils& s = geometry.stencils();
  const auto v = static_cast<std::size_t>(vertex);
  // Against the vertex's own value, so that large equal values take no digits away
  const double own = fields(vertex, outside) - fields(vertex, inside);
  Eigen::Vector3f sum = Eigen::Vector3f::Zero();
  for (auto n = static_cast<std::size_t>(s.first[v]); n < static_cast<std::size_t>(s.first[v + 1]);
       ++n) {
    const double difference = fields(s.vertex[n], outside) - fields(s.vertex[n], inside);
    sum += static_cast<float>(difference - own) * s.weight[n];
  }
  const float length = sum.norm();
  return length > 0.0f ? Eigen::Vector3f(sum / length) : Eigen::Vector3f(Eigen::Vector3f::Zero());
}

}  // namespace ecorche::render
