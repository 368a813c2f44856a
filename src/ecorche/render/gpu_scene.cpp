#include <ecorche/core/contract.h>
#include <ecorche/core/parallel.h>
#include <ecorche/render/gpu_scene.h>
#include <ecorche/render/slice.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace ecorche::render {
namespace {

struct TubeInstance {
  float from[3];
  float to[3];
  float colour[4];
  float radius[2];  // pixels; metres where above 0
};

struct BallInstance {
  float centre[3];
  float colour[4];
  float radius;
};

bool isTransparent(const SurfaceItem& item) {
  if (!item.faceColours) return item.colour[3] < 1.0f;
  return std::any_of(item.faceColours->begin(), item.faceColours->end(),
                     [](const Rgba& c) { return c[3] < 1.0f; });
}

// But for what materials say.
bool sameShape(const SurfaceItem& a, const SurfaceItem& b) {
  SurfaceItem dressed = a;
  dressed.colour = b.colour;
  dressed.roughness = b.roughness;
  dressed.cullBack = b.cullBack;
  dressed.edgeOpacity = b.edgeOpacity;
  return dressed == b && isTransparent(a) == isTransparent(b) &&
         !(a.capped && !a.capColour && a.colour != b.colour);
}

// Every directed edge once in either direction, and volume above 0. Sums of hashes stand for the
// set of edges: what is open passes with a chance of 2⁻⁶⁴.
bool isClosedOutward(const mesh::SurfaceMesh& m) {
  const auto hash = [](std::int32_t a, std::int32_t b) {
    std::uint64_t x = static_cast<std::uint64_t>(static_cast<std::uint32_t>(a)) << 32 |
                      static_cast<std::uint32_t>(b);
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ull;  // splitmix64 [Steele, Lea, Flood 2014]
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebull;
    return x ^ (x >> 31);
  };
  std::uint64_t sum = 0;
  for (Eigen::Index f = 0; f < m.F.rows(); ++f)
    for (int k = 0; k < 3; ++k) {
      const std::int32_t a = m.F(f, k);
      const std::int32_t b = m.F(f, (k + 1) % 3);
      sum += hash(a, b) - hash(b, a);
    }
  return sum == 0 && mesh::signedVolume(m.V, m.F) > 0.0;
}

void fill(const gl::Buffer& buffer, GLenum target, const void* data, std::size_t bytes) {
  glBindBuffer(target, buffer.id());
  glBufferData(target, static_cast<GLsizeiptr>(bytes), data, GL_STATIC_DRAW);
}

void attribute(GLuint index, GLint size, GLenum type, bool normalised, std::size_t stride,
               std::size_t offset, GLuint divisor) {
  glEnableVertexAttribArray(index);
  glVertexAttribPointer(index, size, type, normalised ? GL_TRUE : GL_FALSE,
                        static_cast<GLsizei>(stride), reinterpret_cast<const void*>(offset));
  glVertexAttribDivisor(index, divisor);
}

void storePosition(const mesh::Vector3& p, const mesh::Vector3& origin, float* out) {
  for (Eigen::Index c = 0; c < 3; ++c) out[c] = static_cast<float>(p(c) - origin(c));
}

// The part of a segment on the kept side of the clip plane; false where nothing is left.
bool clipSegment(const ClipPlane& clip, mesh::Vector3& a, mesh::Vector3& b) {
  const double da = clip.normal.dot(a - clip.point);
  const double db = clip.normal.dot(b - clip.point);
  if (da < 0.0 && db < 0.0) return false;
  if (da < 0.0) a += (b - a) * (da / (da - db));
  if (db < 0.0) b += (a - b) * (db / (db - da));
  return true;
}

}  // namespace

GpuScene::Prepared& GpuScene::prepare(const SurfaceItem& item) {
  Prepared& p = prepared_[item.mesh.get()];
  const bool fresh = p.mesh == item.mesh && p.normals == item.normals &&
                     p.revision == item.revision && p.creaseDeg == item.creaseDeg &&
                     p.smoothing == item.normalSmoothing;
  p.used = true;
  if (fresh) return p;

  p.mesh = item.mesh;
  p.normals = item.normals;
  p.revision = item.revision;
  p.creaseDeg = item.creaseDeg;
  p.smoothing = item.normalSmoothing;
  p.closed = isClosedOutward(*item.mesh);
  p.far.reset();
  if (!item.normals) {
    p.shading =
        shadingMesh(*item.mesh, {.creaseDeg = item.creaseDeg, .smoothing = item.normalSmoothing});
    return p;
  }
  EC_REQUIRE_EQ(item.normals->rows(), item.mesh->V.rows());
  p.shading.vertex.resize(static_cast<std::size_t>(item.mesh->V.rows()));
  for (std::size_t v = 0; v < p.shading.vertex.size(); ++v)
    p.shading.vertex[v] = static_cast<std::int32_t>(v);
  p.shading.normals = *item.normals;
  p.shading.F = item.mesh->F;
  return p;
}

Result<void> GpuScene::upload(const Scene& scene, bool inMotion) {
  if (scene.surfaces.size() >= kNotClipped)
    return fail(ErrorCode::NoGraphics,
                "more than 32,767 surfaces in one picture; join those that share a colour");
  const bool sameClip = held_.any && scene.clip == held_.clip;
  const bool sameLook = sameClip && scene.surfaces == held_.surfaces;
  const auto sameShapes = [&] {
    return std::ranges::equal(scene.surfaces, held_.surfaces, sameShape);
  };
  bool sameSurfaces = (sameLook || (sameClip && sameShapes())) && (held_.far || !inMotion);
  bool sameLines = sameClip && scene.lines == held_.lines;
  bool samePoints = held_.any && scene.points == held_.points;
  if (sameSurfaces && !sameLook) {
    // Caps follow behind the surfaces that they close
    std::ranges::copy(scene.surfaces, capped_.surfaces.begin());
    held_.surfaces = scene.surfaces;
  }
  if (!sameSurfaces) {
    for (const SurfaceItem& item : scene.surfaces) EC_REQUIRE(item.mesh != nullptr);
    Scene bare;
    bare.surfaces = scene.surfaces;
    bare.clip = scene.clip;
    capped_ = withCaps(bare);
    if (capped_.surfaces.size() >= kNotClipped)
      return fail(
          ErrorCode::NoGraphics,
          "more than 32,767 surfaces and cuts in one picture; join those that share a colour");
    held_.surfaces = scene.surfaces;
    held_.far = held_.far || inMotion;
    held_.surfaceBox = mesh::Box{};
    for (const SurfaceItem& item : capped_.surfaces)
      held_.surfaceBox.add(mesh::boundingBox(*item.mesh));
  }
  if (!sameLines) {
    held_.lines = scene.lines;
    held_.lineBox = mesh::Box{};
    for (const LineItem& item : scene.lines)
      if (item.lines)
        for (const auto& line : *item.lines)
          for (const mesh::Vector3& p : line) held_.lineBox.add(p);
  }
  if (!samePoints) {
    held_.points = scene.points;
    held_.pointBox = mesh::Box{};
    for (const PointItem& item : scene.points)
      if (item.points)
        for (const mesh::Vector3& p : *item.points) held_.pointBox.add(p);
  }
  held_.clip = scene.clip;

  box_ = mesh::Box{};
  for (const mesh::Box* box : {&held_.surfaceBox, &held_.lineBox, &held_.pointBox})
    if (!box->empty()) box_.add(*box);
  if (scene.volume) {
    const mesh::Box& box = scene.volume->geometry->box();
    for (const VolumeTissue& tissue : scene.volume->tissues)
      if (!box.empty()) box_.add(mesh::Box{box.lo + tissue.shift, box.hi + tissue.shift});
  }
  // The middle stays where it was while that serves: a point more does not send everything again
  const mesh::Vector3 middle = box_.empty() ? mesh::Vector3::Zero() : box_.centre();
  if (!held_.any || !((middle - origin_).norm() <= 0.25 * box_.diagonal())) {
    sameSurfaces = sameLines = samePoints = false;
    origin_ = middle;
  }
  held_.any = true;

  if (!sameSurfaces) uploadSurfaces(capped_);
  if (!sameSurfaces || !sameLook) uploadMaterials(capped_);
  if (!sameLines) uploadLines(scene);
  if (!samePoints) uploadPoints(scene);
  return {};
}

void GpuScene::lookFrom(const Camera& camera, int height, const Eigen::Matrix4f& toClip) {
  opaque_.lookFrom(camera, height, toClip, origin_);
  veils_.lookFrom(camera, height, toClip, origin_);
}

void GpuScene::uploadSurfaces(const Scene& scene) {
  for (auto& [address, p] : prepared_) p.used = false;
  using Kind = TriangleBatch::Kind;
  std::vector<std::size_t> order(scene.surfaces.size());
  std::vector<Kind> kind;
  for (std::size_t i = 0; i < order.size(); ++i) {
    order[i] = i;
    const SurfaceItem& item = scene.surfaces[i];
    const bool closed = prepare(item).closed;
    kind.push_back(!item.castsShadow ? Kind::Unshaded : closed ? Kind::Closed : Kind::Open);
  }
  std::ranges::stable_sort(order, {}, [&](std::size_t i) { return kind[i]; });
  std::erase_if(prepared_, [](const auto& entry) { return !entry.second.used; });
  if (held_.far) {
    std::vector<Prepared*> all;
    for (auto& [address, p] : prepared_) all.push_back(&p);
    parallelFor(
        std::ssize(all),
        [&](std::int64_t i) {
          Prepared& p = *all[static_cast<std::size_t>(i)];
          if (!p.far) p.far = farFaces(*p.mesh, p.shading);
        },
        1);
  }

  veilItems_ = static_cast<std::size_t>(std::ranges::count_if(scene.surfaces, isTransparent));
  opaque_.clear();
  veils_.clear();
  for (const std::size_t i : order) {
    const SurfaceItem& item = scene.surfaces[i];
    const Prepared& p = prepare(item);
    (isTransparent(item) ? veils_ : opaque_)
        .add(item, p.shading, p.far && !item.faceColours ? &*p.far : nullptr,
             static_cast<std::uint16_t>(i), kind[i], origin_);
  }
  opaque_.upload();
  veils_.upload();
}

void GpuScene::uploadMaterials(const Scene& scene) {
  std::vector<float> materials;
  for (const SurfaceItem& item : scene.surfaces) {
    const Rgba colour = item.faceColours ? Rgba{1.0f, 1.0f, 1.0f, 1.0f} : item.colour;
    materials.insert(materials.end(), colour.begin(), colour.end());
    materials.insert(materials.end(),
                     {std::clamp(item.roughness, 0.05f, 1.0f), item.edgeOpacity.value_or(-1.0f),
                      item.cullBack ? 1.0f : 0.0f, 0.0f});
  }
  if (materials.empty()) materials.resize(8);
  materialData_ = gl::Buffer::make();
  fill(materialData_, GL_TEXTURE_BUFFER, materials.data(), materials.size() * sizeof(float));
  materials_ = gl::Texture::make();
  glBindTexture(GL_TEXTURE_BUFFER, materials_.id());
  glTexBuffer(GL_TEXTURE_BUFFER, GL_RGBA32F, materialData_.id());
}

void GpuScene::uploadLines(const Scene& scene) {
  for (const bool onTop : {false, true}) {
    std::vector<TubeInstance> instances;
    for (const LineItem& item : scene.lines) {
      if (item.onTop != onTop || !item.lines) continue;
      if (item.lineColours) EC_REQUIRE_EQ(item.lineColours->size(), item.lines->size());
      for (std::size_t i = 0; i < item.lines->size(); ++i) {
        const auto& line = (*item.lines)[i];
        const Rgba& colour = item.lineColours ? (*item.lineColours)[i] : item.colour;
        for (std::size_t k = 1; k < line.size(); ++k) {
          mesh::Vector3 a = line[k - 1];
          mesh::Vector3 b = line[k];
          if (item.clipped && scene.clip && !clipSegment(*scene.clip, a, b)) continue;
          TubeInstance t;
          storePosition(a, origin_, t.from);
          storePosition(b, origin_, t.to);
          std::copy(colour.begin(), colour.end(), t.colour);
          t.radius[0] = 0.5f * item.widthPixels;
          t.radius[1] = static_cast<float>(0.5 * item.widthMetres);
          instances.push_back(t);
        }
      }
    }
    InstanceBatch& batch = tubes_[onTop ? 1 : 0];
    batch.array = gl::VertexArray::make();
    batch.instances = gl::Buffer::make();
    batch.count = static_cast<GLsizei>(instances.size());
    glBindVertexArray(batch.array.id());
    fill(batch.instances, GL_ARRAY_BUFFER, instances.data(),
         instances.size() * sizeof(TubeInstance));
    constexpr std::size_t stride = sizeof(TubeInstance);
    attribute(0, 3, GL_FLOAT, false, stride, offsetof(TubeInstance, from), 1);
    attribute(1, 3, GL_FLOAT, false, stride, offsetof(TubeInstance, to), 1);
    attribute(2, 4, GL_FLOAT, false, stride, offsetof(TubeInstance, colour), 1);
    attribute(3, 2, GL_FLOAT, false, stride, offsetof(TubeInstance, radius), 1);
    glBindVertexArray(0);
  }
}

void GpuScene::uploadPoints(const Scene& scene) {
  for (const bool onTop : {false, true}) {
    std::vector<BallInstance> instances;
    for (const PointItem& item : scene.points) {
      if (item.onTop != onTop || !item.points) continue;
      for (const mesh::Vector3& p : *item.points) {
        BallInstance b;
        storePosition(p, origin_, b.centre);
        std::copy(item.colour.begin(), item.colour.end(), b.colour);
        b.radius = item.radiusPixels;
        instances.push_back(b);
      }
    }
    InstanceBatch& batch = balls_[onTop ? 1 : 0];
    batch.array = gl::VertexArray::make();
    batch.instances = gl::Buffer::make();
    batch.count = static_cast<GLsizei>(instances.size());
    glBindVertexArray(batch.array.id());
    fill(batch.instances, GL_ARRAY_BUFFER, instances.data(),
         instances.size() * sizeof(BallInstance));
    constexpr std::size_t stride = sizeof(BallInstance);
    attribute(0, 3, GL_FLOAT, false, stride, offsetof(BallInstance, centre), 1);
    attribute(1, 4, GL_FLOAT, false, stride, offsetof(BallInstance, colour), 1);
    attribute(2, 1, GL_FLOAT, false, stride, offsetof(BallInstance, radius), 1);
    glBindVertexArray(0);
  }
}

}  // namespace ecorche::render
