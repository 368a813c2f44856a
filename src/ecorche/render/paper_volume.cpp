#include <ecorche/core/contract.h>
#include <ecorche/core/parallel.h>
#include <ecorche/render/gl_objects.h>
#include <ecorche/render/light_rig.h>
#include <ecorche/render/paper_volume.h>
#include <ecorche/render/views.h>
#include <ecorche/tissue/segmentation.h>

#include <array>

namespace ecorche::render {
namespace {

const std::string kVertex = R"(#version 330 core
layout(location = 0) in uvec2 aCorner;   // vertex, tet
uniform samplerBuffer uPositions;
uniform mat4 uViewProjection;
flat out int vTet;
out vec3 vPosition;
void main() {
  vPosition = texelFetch(uPositions, int(aCorner.x)).xyz;
  vTet = int(aCorner.y);
  gl_Position = uViewProjection * vec4(vPosition, 1.0);
}
)";

const std::string kFragment = R"(#version 330 core
flat in int vTet;
in vec3 vPosition;
layout(location = 0) out vec4 oNormal;   // normal, minus the tissue's id
uniform isamplerBuffer uTets;            // four corners; the first is below 0 where all is fat: -1 - corner
uniform samplerBuffer uPositions;
uniform samplerBuffer uFields;           // of a vertex, four to a texel
uniform vec3 uEye;
uniform vec3 uForward;
uniform float uParallel;
uniform int uColumns;
uniform int uFirst;                      // 0, or 1 where fat owns nothing
uniform int uSteps;

int owner(ivec4 v, vec4 b) {
  int texels = (uColumns + 3) / 4;
  float most = -3e38;
  int best = 0;
  for (int t = 0; t < texels; ++t) {
    vec4 f = b.x * texelFetch(uFields, v.x * texels + t) + b.y * texelFetch(uFields, v.y * texels + t) +
             b.z * texelFetch(uFields, v.z * texels + t) + b.w * texelFetch(uFields, v.w * texels + t);
    for (int k = 0; k < 4; ++k) {
      int i = 4 * t + k;
      if (i >= uFirst && i < uColumns && (f[k] > most || (best == 0 && f[k] == most))) { most = f[k]; best = i; }
    }
  }
  return best;
}
vec4 cornerValues(ivec4 v, int i) {
  int texels = (uColumns + 3) / 4, t = i / 4, k = i % 4;
  return vec4(texelFetch(uFields, v.x * texels + t)[k], texelFetch(uFields, v.y * texels + t)[k],
              texelFetch(uFields, v.z * texels + t)[k], texelFetch(uFields, v.w * texels + t)[k]);
}
void main() {
  ivec4 v = texelFetch(uTets, vTet);
  if (v.x < 0) discard;
  vec3 a = texelFetch(uPositions, v.x).xyz;
  mat3 edges = mat3(texelFetch(uPositions, v.y).xyz - a, texelFetch(uPositions, v.z).xyz - a,
                    texelFetch(uPositions, v.w).xyz - a);
  mat3 inverted = inverse(edges);
  vec3 d = uParallel > 0.5 ? uForward : normalize(vPosition - uEye);
  vec3 x = inverted * (vPosition - a), r = inverted * d;
  vec4 at = vec4(1.0 - x.x - x.y - x.z, x), rate = vec4(-r.x - r.y - r.z, r);
  if (owner(v, at) != 0) discard;
  float leave = 3e38;
  for (int k = 0; k < 4; ++k) if (rate[k] < 0.0) leave = min(leave, max(0.0, -at[k] / rate[k]));
  int found = 0;
  for (int i = 1; i <= uSteps && found == 0; ++i) found = owner(v, at + (leave * float(i) / float(uSteps)) * rate);
  if (found == 0) discard;
  vec4 g = cornerValues(v, 0) - cornerValues(v, found);
  vec3 n = (g.yzw - g.x) * inverted;
  oNormal = vec4(n * inversesqrt(max(dot(n, n), 1e-30)), -float(found) - 1.0);
}
)";

gl::Texture bufferTexture(gl::Buffer& buffer, const void* data, std::size_t bytes, GLenum format) {
  buffer = gl::Buffer::make();
  glBindBuffer(GL_TEXTURE_BUFFER, buffer.id());
  glBufferData(GL_TEXTURE_BUFFER, static_cast<GLsizeiptr>(bytes), data, GL_STATIC_DRAW);
  gl::Texture texture = gl::Texture::make();
  glBindTexture(GL_TEXTURE_BUFFER, texture.id());
  glTexBuffer(GL_TEXTURE_BUFFER, format, buffer.id());
  return texture;
}

}  // namespace

struct PaperVolume::Impl {
  gl::Program program;
  gl::Buffer positionData, tetData, fieldData, corners;
  gl::Texture positions, tets, fields, normal, depth;
  gl::Framebuffer frame;
  gl::VertexArray array;
  GLsizei cornerCount = 0;
  mesh::Box box;
  int columns = 0;
  bool fatIsCandidate = true;
  int width = 0;
  int height = 0;
};

PaperVolume::PaperVolume(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
PaperVolume::PaperVolume(PaperVolume&&) noexcept = default;
PaperVolume& PaperVolume::operator=(PaperVolume&&) noexcept = default;
PaperVolume::~PaperVolume() = default;

Result<PaperVolume> PaperVolume::create(const VolumeItem& item, int width, int height) {
  EC_REQUIRE(item.geometry != nullptr && item.fields != nullptr);
  auto impl = std::make_unique<Impl>();
  auto program = gl::Program::build("paper volume", kVertex, kFragment);
  if (!program) return passOn(program);
  impl->program = std::move(*program);
  impl->width = width;
  impl->height = height;
  impl->box = item.geometry->box();
  impl->columns = static_cast<int>(item.fields->cols());
  impl->fatIsCandidate = item.fatIsCandidate;
  const mesh::TetMesh& mesh = item.geometry->mesh();
  const mesh::Vector3 origin = impl->box.centre();

  std::vector<float> positions(4 * static_cast<std::size_t>(mesh.V.rows()), 0.0f);
  std::vector<std::uint8_t> isFat(static_cast<std::size_t>(mesh.V.rows()));
  const auto texels = static_cast<std::size_t>((impl->columns + 3) / 4);
  std::vector<float> fields(4 * texels * static_cast<std::size_t>(mesh.V.rows()), 0.0f);
  parallelFor(mesh.V.rows(), [&](std::int64_t v) {
    const auto i = static_cast<std::size_t>(v);
    for (Eigen::Index c = 0; c < 3; ++c)
      positions[4 * i + static_cast<std::size_t>(c)] = static_cast<float>(mesh.V(v, c) - origin(c));
    for (Eigen::Index c = 0; c < item.fields->cols(); ++c)
      fields[4 * texels * i + static_cast<std::size_t>(c)] =
          static_cast<float>((*item.fields)(v, c));
    isFat[i] = tissue::ownerOf(item.fields->row(v), item.fatIsCandidate) == kFat;
  });
  std::vector<std::int32_t> tets(mesh.T.data(), mesh.T.data() + mesh.T.size());
  std::vector<std::array<std::uint32_t, 2>> corners;
  corners.reserve(12 * static_cast<std::size_t>(mesh.T.rows()));
  for (Eigen::Index t = 0; t < mesh.T.rows(); ++t) {
    bool fat = true;
    for (int k = 0; k < 4; ++k) fat = fat && isFat[static_cast<std::size_t>(mesh.T(t, k))] != 0;
    if (fat) tets[static_cast<std::size_t>(4 * t)] = -1 - mesh.T(t, 0);
    for (const auto& face : mesh::kTetFace)
      for (const int c : face)
        corners.push_back(
            {static_cast<std::uint32_t>(mesh.T(t, c)), static_cast<std::uint32_t>(t)});
  }
  impl->positions = bufferTexture(impl->positionData, positions.data(),
                                  positions.size() * sizeof(float), GL_RGBA32F);
  impl->fields =
      bufferTexture(impl->fieldData, fields.data(), fields.size() * sizeof(float), GL_RGBA32F);
  impl->tets =
      bufferTexture(impl->tetData, tets.data(), tets.size() * sizeof(std::int32_t), GL_RGBA32I);
  impl->array = gl::VertexArray::make();
  impl->corners = gl::Buffer::make();
  glBindVertexArray(impl->array.id());
  glBindBuffer(GL_ARRAY_BUFFER, impl->corners.id());
  glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(corners.size() * sizeof(corners[0])),
               corners.data(), GL_STATIC_DRAW);
  glEnableVertexAttribArray(0);
  glVertexAttribIPointer(0, 2, GL_UNSIGNED_INT, sizeof(corners[0]), nullptr);
  glBindVertexArray(0);
  impl->cornerCount = static_cast<GLsizei>(corners.size());

  impl->normal = gl::makeTexture2D(GL_RGBA16F, width, height);
  impl->depth = gl::makeTexture2D(GL_DEPTH_COMPONENT32F, width, height);
  auto frame = gl::makeFramebuffer({&impl->normal}, &impl->depth);
  if (!frame) return passOn(frame);
  impl->frame = std::move(*frame);
  return PaperVolume(std::move(impl));
}

void PaperVolume::draw(const Camera& camera) {
  const mesh::Vector3 origin = impl_->box.centre();
  const EyeAxes axes = eyeAxes(camera);
  const Eigen::Matrix4f m =
      viewProjection(camera, impl_->width, impl_->height, impl_->box, origin).cast<float>();
  glBindFramebuffer(GL_FRAMEBUFFER, impl_->frame.id());
  glViewport(0, 0, impl_->width, impl_->height);
  glClearColor(0.0f, 0.0f, 0.0f, 0.0f);
  glDepthMask(GL_TRUE);
  glDepthFunc(GL_LESS);
  glDisable(GL_BLEND);
  glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
  glEnable(GL_DEPTH_TEST);
  glFrontFace(GL_CCW);
  glCullFace(GL_BACK);
  glEnable(GL_CULL_FACE);
  const gl::Program& p = impl_->program;
  p.use();
  const mesh::Vector3 eye = camera.eye - origin;
  const auto floats = [](const mesh::Vector3& v) {
    return std::vector<float>{static_cast<float>(v.x()), static_cast<float>(v.y()),
                              static_cast<float>(v.z())};
  };
  p.setMatrix("uViewProjection", m.data());
  p.set("uEye", floats(eye), 3);
  p.set("uForward", floats(-axes.back), 3);
  p.set("uParallel", camera.fovDeg <= 0.0 ? 1.0f : 0.0f);
  p.set("uColumns", impl_->columns);
  p.set("uFirst", impl_->fatIsCandidate ? 0 : 1);
  p.set("uSteps", kSteps);
  p.setTexture("uPositions", 0, GL_TEXTURE_BUFFER, impl_->positions);
  p.setTexture("uTets", 1, GL_TEXTURE_BUFFER, impl_->tets);
  p.setTexture("uFields", 2, GL_TEXTURE_BUFFER, impl_->fields);
  glBindVertexArray(impl_->array.id());
  glDrawArrays(GL_TRIANGLES, 0, impl_->cornerCount);
  glDisable(GL_CULL_FACE);
  glFinish();
}

TissueImage PaperVolume::read() const {
  TissueImage image(impl_->width, impl_->height);
  std::vector<float> texels(4 * image.tissue.size());
  glBindFramebuffer(GL_FRAMEBUFFER, impl_->frame.id());
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glReadPixels(0, 0, impl_->width, impl_->height, GL_RGBA, GL_FLOAT, texels.data());
  for (int y = 0; y < impl_->height; ++y)
    for (int x = 0; x < impl_->width; ++x) {
      const float* texel = &texels[4 * image.index(x, impl_->height - 1 - y)];
      if (texel[3] > -0.5f) continue;
      const std::size_t i = image.index(x, y);
      image.tissue[i] = TissueId(static_cast<std::int64_t>(-texel[3]));
      image.normal[i] = Eigen::Vector3f(texel[0], texel[1], texel[2]).normalized();
    }
  return image;
}

}  // namespace ecorche::render
