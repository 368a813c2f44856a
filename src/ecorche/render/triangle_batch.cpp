#include <ecorche/core/contract.h>
#include <ecorche/core/parallel.h>
#include <ecorche/render/triangle_batch.h>
#include <ecorche/render/views.h>

#include <algorithm>
#include <cmath>

namespace ecorche::render {
namespace {

// Cells of a coarser surface are at most so large: vertices go by less than that, most by a third.
constexpr double kCellPixels = 1.0;

void store(const Rgba& colour, std::uint16_t* out) {
  for (std::size_t c = 0; c < 4; ++c)
    out[c] = static_cast<std::uint16_t>(std::lround(65535.0f * std::clamp(colour[c], 0.0f, 1.0f)));
}

void storeNormal(const mesh::Directions& normals, Eigen::Index row, std::int16_t* out) {
  for (Eigen::Index c = 0; c < 3; ++c)
    out[c] =
        static_cast<std::int16_t>(std::lround(32767.0 * std::clamp(normals(row, c), -1.0, 1.0)));
}

const void* offset(std::size_t index) {
  return reinterpret_cast<const void*>(index * sizeof(std::uint32_t));
}

void cullBackFaces() {
  glFrontFace(GL_CCW);
  glCullFace(GL_BACK);
  glEnable(GL_CULL_FACE);
}

void attribute(GLuint index, GLint size, GLenum type, std::size_t at) {
  glEnableVertexAttribArray(index);
  glVertexAttribPointer(index, size, type, type == GL_FLOAT ? GL_FALSE : GL_TRUE,
                        sizeof(SurfaceVertex), reinterpret_cast<const void*>(at));
}

}  // namespace

void TriangleBatch::clear() {
  vertices_.clear();
  indices_.clear();
  farIndices_.clear();
  surfaces_.clear();
  corners_.clear();
  end_ = {};
  closed_ = {};
  open_ = {};
}

void TriangleBatch::add(const SurfaceItem& item, const ShadingMesh& shading,
                        const std::vector<FarFaces>* far, std::uint16_t number, Kind kind,
                        const mesh::Vector3& origin) {
  EC_REQUIRE(surfaces_.empty() || surfaces_.back().kind <= kind);
  const mesh::SurfaceMesh& m = *item.mesh;
  const auto tag = static_cast<std::uint16_t>(number | (item.clipped ? 0u : kNotClipped));
  const auto vertexOf = [&](std::int32_t n, const Rgba& colour) {
    SurfaceVertex v;
    const std::int32_t source = shading.vertex[static_cast<std::size_t>(n)];
    for (Eigen::Index c = 0; c < 3; ++c)
      v.position[c] = static_cast<float>(m.V(source, c) - origin(c));
    storeNormal(shading.normals, n, v.normal);
    v.item = tag;
    store(colour, v.colour);
    return v;
  };

  Surface surface;
  surface.box = mesh::boundingBox(m);
  surface.kind = kind;
  const auto base = static_cast<std::uint32_t>(vertices_.size());
  const std::size_t first = indices_.size();
  if (!item.faceColours) {
    vertices_.resize(base + shading.vertex.size());
    parallelFor(static_cast<std::int64_t>(shading.vertex.size()), [&](std::int64_t n) {
      vertices_[base + static_cast<std::size_t>(n)] =
          vertexOf(static_cast<std::int32_t>(n), {1.0f, 1.0f, 1.0f, 1.0f});
    });
    for (Eigen::Index i = 0; i < shading.F.size(); ++i)
      indices_.push_back(base + static_cast<std::uint32_t>(shading.F.data()[i]));
  } else {
    // Colours jump from face to face: every face has corners of its own
    EC_REQUIRE_EQ(static_cast<Eigen::Index>(item.faceColours->size()), m.F.rows());
    EC_REQUIRE(far == nullptr);
    for (Eigen::Index f = 0; f < m.F.rows(); ++f)
      for (int k = 0; k < 3; ++k) {
        indices_.push_back(static_cast<std::uint32_t>(vertices_.size()));
        vertices_.push_back(
            vertexOf(shading.F(f, k), (*item.faceColours)[static_cast<std::size_t>(f)]));
      }
  }
  surface.levels.push_back({first, static_cast<GLsizei>(indices_.size() - first), 0.0});
  if (far != nullptr) {
    for (const FarFaces& faces : *far) {
      surface.levels.push_back(
          {farIndices_.size(), static_cast<GLsizei>(faces.corners.size()), faces.cell});
      for (const std::uint32_t corner : faces.corners) farIndices_.push_back(base + corner);
    }
  }
  surfaces_.push_back(std::move(surface));
  for (auto k = static_cast<std::size_t>(kind); k < end_.size(); ++k)
    end_[k] = static_cast<GLsizei>(indices_.size());
}

void TriangleBatch::upload() {
  corners_.resize(indices_.size());
  for (std::size_t i = 0; i < corners_.size(); ++i)
    corners_[i] = Eigen::Vector3f::Map(vertices_[indices_[i]].position);
  for (Surface& surface : surfaces_)
    for (std::size_t l = 1; l < surface.levels.size(); ++l)
      surface.levels[l].first += indices_.size();
  indices_.insert(indices_.end(), farIndices_.begin(), farIndices_.end());

  array_ = gl::VertexArray::make();
  vertexData_ = gl::Buffer::make();
  indexData_ = gl::Buffer::make();
  glBindVertexArray(array_.id());
  glBindBuffer(GL_ARRAY_BUFFER, vertexData_.id());
  glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(vertices_.size() * sizeof(SurfaceVertex)),
               vertices_.data(), GL_STATIC_DRAW);
  glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, indexData_.id());
  glBufferData(GL_ELEMENT_ARRAY_BUFFER,
               static_cast<GLsizeiptr>(indices_.size() * sizeof(std::uint32_t)), indices_.data(),
               GL_STATIC_DRAW);
  attribute(0, 3, GL_FLOAT, offsetof(SurfaceVertex, position));
  attribute(1, 3, GL_SHORT, offsetof(SurfaceVertex, normal));
  glEnableVertexAttribArray(2);
  glVertexAttribIPointer(2, 1, GL_UNSIGNED_SHORT, sizeof(SurfaceVertex),
                         reinterpret_cast<const void*>(offsetof(SurfaceVertex, item)));
  attribute(3, 4, GL_UNSIGNED_SHORT, offsetof(SurfaceVertex, colour));
  glBindVertexArray(0);
  vertices_ = {};
  indices_ = {};
  farIndices_ = {};
}

void TriangleBatch::lookFrom(const Camera& camera, int height, const Eigen::Matrix4f& toClip,
                             const mesh::Vector3& origin) {
  closed_ = {};
  open_ = {};
  const double pixel = pixelSize(camera, height);
  for (const Surface& surface : surfaces_) {
    if (surface.box.empty() || isBeyondPicture(toClip, (surface.box.lo - origin).cast<float>(),
                                               (surface.box.hi - origin).cast<float>()))
      continue;
    double size = pixel;
    if (camera.fovDeg > 0.0) {
      const mesh::Vector3 nearest = camera.eye.cwiseMax(surface.box.lo).cwiseMin(surface.box.hi);
      size *= (camera.eye - nearest).norm();
    }
    std::size_t level = 0;
    while (level + 1 < surface.levels.size() &&
           surface.levels[level + 1].cell <= kCellPixels * size)
      ++level;
    const Level& chosen = surface.levels[level];
    Chosen& to = surface.kind == Kind::Closed ? closed_ : open_;
    to.counts.push_back(chosen.count);
    to.offsets.push_back(offset(chosen.first));
  }
}

void TriangleBatch::Chosen::draw() const {
  if (counts.empty()) return;
  glMultiDrawElements(GL_TRIANGLES, counts.data(), GL_UNSIGNED_INT, offsets.data(),
                      static_cast<GLsizei>(counts.size()));
}

void TriangleBatch::draw(GLsizei count, bool cullBacks) const {
  if (count == 0) return;
  const GLsizei closed = cullBacks ? std::min(count, end_[0]) : 0;
  glBindVertexArray(array_.id());
  if (closed > 0) {
    cullBackFaces();
    glDrawElements(GL_TRIANGLES, closed, GL_UNSIGNED_INT, nullptr);
    glDisable(GL_CULL_FACE);
  }
  if (count > closed)
    glDrawElements(GL_TRIANGLES, count - closed, GL_UNSIGNED_INT,
                   offset(static_cast<std::size_t>(closed)));
}

void TriangleBatch::drawAll(bool cullBacks) const { draw(end_[2], cullBacks); }
void TriangleBatch::drawCasters(bool cullBacks) const { draw(end_[1], cullBacks); }

void TriangleBatch::drawNear(bool cullBacks) const {
  if (surfaces_.empty()) return;
  glBindVertexArray(array_.id());
  if (cullBacks) cullBackFaces();
  closed_.draw();
  glDisable(GL_CULL_FACE);
  open_.draw();
}

std::int64_t TriangleBatch::nearTriangles() const {
  std::int64_t count = 0;
  for (const Chosen* chosen : {&closed_, &open_})
    for (const GLsizei n : chosen->counts) count += n / 3;
  return count;
}

}  // namespace ecorche::render
