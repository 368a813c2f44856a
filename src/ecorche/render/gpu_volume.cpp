#include <ecorche/core/contract.h>
#include <ecorche/render/gpu_volume.h>
#include <ecorche/render/light_rig.h>
#include <ecorche/render/views.h>

#include <algorithm>

namespace ecorche::render {
namespace {

constexpr std::size_t kTexelBytes = sizeof(VolumeRecords::Texel);

void bufferTexture(gl::Texture& texture, const gl::Buffer& buffer, GLenum format) {
  if (!texture) texture = gl::Texture::make();
  glBindTexture(GL_TEXTURE_BUFFER, texture.id());
  glTexBuffer(GL_TEXTURE_BUFFER, format, buffer.id());
}

}  // namespace

void GpuVolume::uploadPositions() {
  const mesh::Positions& V = geometry_->mesh().V;
  std::vector<float> data(4 * static_cast<std::size_t>(V.rows()), 0.0f);
  for (Eigen::Index v = 0; v < V.rows(); ++v)
    for (Eigen::Index c = 0; c < 3; ++c)
      data[static_cast<std::size_t>(4 * v + c)] = static_cast<float>(V(v, c) - origin_(c));
  positionData_ = gl::Buffer::make();
  glBindBuffer(GL_TEXTURE_BUFFER, positionData_.id());
  glBufferData(GL_TEXTURE_BUFFER, static_cast<GLsizeiptr>(data.size() * sizeof(float)), data.data(),
               GL_STATIC_DRAW);
  contentBytes_ += data.size() * sizeof(float);
  bufferTexture(positions_, positionData_, GL_RGBA32F);
}

void GpuVolume::uploadTissues(const VolumeItem& item) {
  std::vector<float> table;
  for (const VolumeTissue& tissue : item.tissues)
    table.insert(table.end(),
                 {tissue.colour[0], tissue.colour[1], tissue.colour[2],
                  std::clamp(tissue.roughness, 0.05f, 1.0f), tissue.opacity, 0.0f, 0.0f, 0.0f});
  if (table == tissueTable_) return;
  tissueTable_ = std::move(table);
  tissueData_ = gl::Buffer::make();
  glBindBuffer(GL_TEXTURE_BUFFER, tissueData_.id());
  glBufferData(GL_TEXTURE_BUFFER, static_cast<GLsizeiptr>(tissueTable_.size() * sizeof(float)),
               tissueTable_.data(), GL_STATIC_DRAW);
  contentBytes_ += tissueTable_.size() * sizeof(float);
  bufferTexture(tissues_, tissueData_, GL_RGBA32F);
}

Result<void> GpuVolume::uploadRecords(GpuVolumeLayer& layer) {
  const std::vector<VolumeRecords::Texel>& texels = layer.records.texels();
  const std::vector<VolumeRecords::Range> changes = layer.records.takeChanges();
  if (!layer.texels || texels.size() > layer.capacity) {
    GLint largest = 0;
    glGetIntegerv(GL_MAX_TEXTURE_BUFFER_SIZE, &largest);
    if (texels.size() > static_cast<std::size_t>(largest))
      return fail(ErrorCode::NoGraphics,
                  "the graphics driver holds too little for a view of that many tets; use fewer, "
                  "or Mesa's software renderer (LIBGL_ALWAYS_SOFTWARE=1)");
    // Room to grow, so that the next edit need not send everything again
    layer.capacity = std::min<std::size_t>(texels.size() + texels.size() / 4 + 4096,
                                           static_cast<std::size_t>(largest));
    layer.texels = gl::Buffer::make();
    glBindBuffer(GL_TEXTURE_BUFFER, layer.texels.id());
    glBufferData(GL_TEXTURE_BUFFER, static_cast<GLsizeiptr>(layer.capacity * kTexelBytes), nullptr,
                 GL_DYNAMIC_DRAW);
    glBufferSubData(GL_TEXTURE_BUFFER, 0, static_cast<GLsizeiptr>(texels.size() * kTexelBytes),
                    texels.data());
    contentBytes_ += texels.size() * kTexelBytes;
    bufferTexture(layer.texture, layer.texels, GL_RGBA32UI);
    return {};
  }
  glBindBuffer(GL_TEXTURE_BUFFER, layer.texels.id());
  for (const auto& [begin, end] : changes) {
    glBufferSubData(GL_TEXTURE_BUFFER, static_cast<GLintptr>(begin * kTexelBytes),
                    static_cast<GLsizeiptr>((end - begin) * kTexelBytes), texels.data() + begin);
    contentBytes_ += (end - begin) * kTexelBytes;
  }
  if (!changes.empty()) surfaceFresh_ = false;
  return {};
}

void GpuVolume::uploadFlow(const VolumeItem& item, bool otherTets) {
  const bool otherFlow = item.flow != flow_;
  const bool hadFlow = flow_ != nullptr;
  flow_ = item.flow;
  if (!flow_) return;
  const mesh::TetMesh& mesh = geometry_->mesh();
  if (otherTets || !hadFlow) {
    tetData_ = gl::Buffer::make();
    glBindBuffer(GL_TEXTURE_BUFFER, tetData_.id());
    const std::size_t bytes = static_cast<std::size_t>(mesh.T.size()) * sizeof(std::int32_t);
    glBufferData(GL_TEXTURE_BUFFER, static_cast<GLsizeiptr>(bytes), mesh.T.data(), GL_STATIC_DRAW);
    contentBytes_ += bytes;
    bufferTexture(tets_, tetData_, GL_RGBA32I);
  }
  if (!otherTets && !otherFlow) return;
  EC_REQUIRE_EQ(flow_->rows(), mesh.V.rows());
  std::vector<float> data(4 * static_cast<std::size_t>(flow_->rows()), 0.0f);
  for (Eigen::Index v = 0; v < flow_->rows(); ++v)
    for (Eigen::Index c = 0; c < 3; ++c)
      data[static_cast<std::size_t>(4 * v + c)] = static_cast<float>((*flow_)(v, c));
  flowData_ = gl::Buffer::make();
  glBindBuffer(GL_TEXTURE_BUFFER, flowData_.id());
  glBufferData(GL_TEXTURE_BUFFER, static_cast<GLsizeiptr>(data.size() * sizeof(float)), data.data(),
               GL_STATIC_DRAW);
  contentBytes_ += data.size() * sizeof(float);
  bufferTexture(flowTexture_, flowData_, GL_RGBA32F);
}

void GpuVolume::smoothFields(const VolumeItem& item, bool otherTets) {
  const bool same = item.fields == fields_ && item.fieldsRevision == fieldsRevision_;
  if (same && !otherTets) return;
  const bool next = !otherTets && item.changed && item.fieldsRevision == fieldsRevision_ + 1;
  smoothed_.update(*geometry_, *item.fields, next ? item.changed.get() : nullptr);
  fields_ = item.fields;
  fieldsRevision_ = item.fieldsRevision;
}

Result<void> GpuVolume::update(const VolumeItem& item, const std::optional<ClipPlane>& clip) {
  contentBytes_ = 0;
  const std::vector<VolumeLayer> wanted = volumeLayers(item);
  const bool otherTets = item.geometry != geometry_;
  if (otherTets) {
    geometry_ = item.geometry;
    const mesh::Box& box = geometry_->box();
    origin_ = box.empty() ? mesh::Vector3::Zero() : box.centre();
    slack_ = static_cast<float>(2e-6 * box.diagonal());
    layers_.clear();
    surfaceFresh_ = false;
    uploadPositions();
  }
  uploadTissues(item);
  uploadFlow(item, otherTets);
  smoothFields(item, otherTets);
  if (wanted.size() != layers_.size()) surfaceFresh_ = false;
  layers_.resize(wanted.size());
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    if (!layers_[i]) layers_[i] = std::make_unique<GpuVolumeLayer>();
    GpuVolumeLayer& layer = *layers_[i];
    if (!(layer.layer == wanted[i])) surfaceFresh_ = false;
    layer.layer = wanted[i];
    layer.records.update(item, smoothed_, layer.layer, clip);
    if (auto ok = uploadRecords(layer); !ok) return ok;
  }
  return {};
}

void GpuVolume::lookFrom(const Camera& camera, int width, int height, const mesh::Box& box) {
  viewBytes_ = 0;
  const EyeAxes axes = eyeAxes(camera);
  std::vector<VolumeRecords::Corner> corners;
  for (const auto& layer : layers_) {
    const mesh::Vector3 origin = origin_ + layer->layer.shift;
    VolumeRecords::Eye eye;
    eye.at = (camera.eye - origin).cast<float>();
    eye.forward = (-axes.back).cast<float>();
    eye.parallel = camera.fovDeg <= 0.0;
    eye.worldToClip = viewProjection(camera, width, height, box, origin).cast<float>();
    layer->records.trianglesFrom(eye, corners);

    if (!layer->array) {
      layer->array = gl::VertexArray::make();
      layer->corners = gl::Buffer::make();
    }
    glBindVertexArray(layer->array.id());
    glBindBuffer(GL_ARRAY_BUFFER, layer->corners.id());
    const std::size_t bytes = corners.size() * sizeof(VolumeRecords::Corner);
    if (corners.size() > layer->cornerCapacity) layer->cornerCapacity = corners.size() * 5 / 4;
    // A fresh store each time: the driver need not wait for the last frame to be drawn
    glBufferData(GL_ARRAY_BUFFER,
                 static_cast<GLsizeiptr>(layer->cornerCapacity * sizeof(VolumeRecords::Corner)),
                 nullptr, GL_STREAM_DRAW);
    glBufferSubData(GL_ARRAY_BUFFER, 0, static_cast<GLsizeiptr>(bytes), corners.data());
    glEnableVertexAttribArray(0);
    glVertexAttribIPointer(0, 2, GL_UNSIGNED_INT, sizeof(VolumeRecords::Corner), nullptr);
    layer->cornerCount = static_cast<GLsizei>(corners.size());
    viewBytes_ += bytes;
  }
  glBindVertexArray(0);
}

std::int64_t GpuVolume::tetCount() const {
  std::int64_t count = 0;
  for (const auto& layer : layers_) count += layer->records.drawnTets();
  return count;
}

std::int64_t GpuVolume::triangleCount() const {
  std::int64_t count = 0;
  for (const auto& layer : layers_) count += layer->cornerCount / 3;
  return count;
}

const std::vector<Eigen::Vector3f>& GpuVolume::surface() {
  if (surfaceFresh_) return surface_;
  surface_.clear();
  std::vector<Eigen::Vector3f> own;
  for (const auto& layer : layers_) {
    if (layer->layer.veil) continue;
    layer->records.surfaceTriangles(own);
    const Eigen::Vector3f shift = layer->layer.shift.cast<float>();
    for (const Eigen::Vector3f& p : own) surface_.emplace_back(p + shift);
  }
  surfaceFresh_ = true;
  return surface_;
}

}  // namespace ecorche::render
