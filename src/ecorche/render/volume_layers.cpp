#include <ecorche/core/contract.h>
#include <ecorche/core/parallel.h>
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

namespace {

// Values of the smoothed difference outside − inside come from `at`; the vertex's own is taken off,
// so that large equal values take no digits away.
template <class At>
Eigen::Vector3f downhill(const VolumeGeometry::Stencils& s, std::int32_t vertex, const At& at) {
  const auto v = static_cast<std::size_t>(vertex);
  const auto own = at(vertex);
  Eigen::Vector3f sum = Eigen::Vector3f::Zero();
  for (auto n = static_cast<std::size_t>(s.first[v]); n < static_cast<std::size_t>(s.first[v + 1]);
       ++n)
    sum += static_cast<float>(at(s.vertex[n]) - own) * s.gradient[n];
  const float length = sum.norm();
  return length > 0.0f ? Eigen::Vector3f(sum / length) : Eigen::Vector3f(Eigen::Vector3f::Zero());
}

}  // namespace

void SmoothedFields::update(const VolumeGeometry& geometry, const tissue::FieldMatrix& fields,
                            const FieldChange* change) {
  const VolumeGeometry::Stencils& s = geometry.stencils();
  columns_ = fields.cols();
  values_.resize(static_cast<std::size_t>(fields.size()));
  if (change != nullptr) {
    const std::vector<std::int32_t> around = withNeighbours(geometry, change->vertices, 1);
    parallelFor(
        std::ssize(around),
        [&](std::int64_t i) {
          const auto v = static_cast<std::size_t>(around[static_cast<std::size_t>(i)]);
          for (const std::int32_t c : change->columns) {
            double sum = 0.0;
            for (auto n = static_cast<std::size_t>(s.first[v]);
                 n < static_cast<std::size_t>(s.first[v + 1]); ++n)
              sum += static_cast<double>(s.mean[n]) * fields(s.vertex[n], c);
            values_[v * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(c)] =
                static_cast<float>(sum);
          }
        },
        1024);
    return;
  }
  parallelFor(
      fields.rows(),
      [&](std::int64_t v) {
        const auto i = static_cast<std::size_t>(v);
        thread_local Eigen::RowVectorXd sum;
        sum.setZero(columns_);
        for (auto n = static_cast<std::size_t>(s.first[i]);
             n < static_cast<std::size_t>(s.first[i + 1]); ++n)
          sum += static_cast<double>(s.mean[n]) * fields.row(s.vertex[n]);
        float* row = values_.data() + v * columns_;
        for (std::ptrdiff_t c = 0; c < columns_; ++c) row[c] = static_cast<float>(sum(c));
      },
      256);
}

Eigen::Vector3f interfaceNormal(const VolumeGeometry& geometry, const SmoothedFields& fields,
                                std::int32_t vertex, Eigen::Index inside, Eigen::Index outside) {
  return downhill(geometry.stencils(), vertex, [&](std::int32_t u) {
    const float* row = fields.row(u);
    return row[outside] - row[inside];
  });
}

Eigen::Vector3f interfaceNormal(const VolumeGeometry& geometry, const tissue::FieldMatrix& fields,
                                std::int32_t vertex, Eigen::Index inside, Eigen::Index outside) {
  const VolumeGeometry::Stencils& s = geometry.stencils();
  return downhill(s, vertex, [&](std::int32_t u) {
    const auto i = static_cast<std::size_t>(u);
    double sum = 0.0;
    for (auto n = static_cast<std::size_t>(s.first[i]);
         n < static_cast<std::size_t>(s.first[i + 1]); ++n)
      sum += static_cast<double>(s.mean[n]) *
             (fields(s.vertex[n], outside) - fields(s.vertex[n], inside));
    return sum;
  });
}

std::vector<std::int32_t> withNeighbours(const VolumeGeometry& geometry,
                                         const std::vector<std::int32_t>& vertices, int rounds) {
  const VolumeGeometry::Stencils& s = geometry.stencils();
  std::vector<std::uint8_t> marked(s.first.size() - 1, 0);
  std::vector<std::int32_t> out;
  const auto add = [&](std::int32_t v) {
    if (marked[static_cast<std::size_t>(v)] != 0) return;
    marked[static_cast<std::size_t>(v)] = 1;
    out.push_back(v);
  };
  for (const std::int32_t v : vertices) add(v);
  std::size_t begin = 0;
  for (int round = 0; round < rounds; ++round) {
    const std::size_t end = out.size();
    for (std::size_t i = begin; i < end; ++i) {
      const auto v = static_cast<std::size_t>(out[i]);
      for (auto n = static_cast<std::size_t>(s.first[v]);
           n < static_cast<std::size_t>(s.first[v + 1]); ++n)
        add(s.vertex[n]);
    }
    begin = end;
  }
  return out;
}

}  // namespace ecorche::render
