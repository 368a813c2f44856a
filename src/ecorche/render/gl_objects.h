#pragma once

// Private to render's sources: the only room that issues OpenGL calls.

#include <ecorche/core/result.h>
#include <epoxy/gl.h>

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace ecorche::render::gl {

/// A name that OpenGL gave and that is given back at the end; moves, never copies. Needs its
/// context current.
template <class Kind>
class Object {
 public:
  Object() = default;
  [[nodiscard]] static Object make() {
    Object made;
    Kind::create(&made.id_);
    return made;
  }
  Object(Object&& other) noexcept : id_(std::exchange(other.id_, 0)) {}
  Object& operator=(Object&& other) noexcept {
    std::swap(id_, other.id_);
    return *this;
  }
  ~Object() {
    if (id_ != 0) Kind::destroy(&id_);
  }
  [[nodiscard]] GLuint id() const { return id_; }
  explicit operator bool() const { return id_ != 0; }

 private:
  GLuint id_ = 0;
};

struct BufferKind {
  static void create(GLuint* id) { glGenBuffers(1, id); }
  static void destroy(const GLuint* id) { glDeleteBuffers(1, id); }
};
struct TextureKind {
  static void create(GLuint* id) { glGenTextures(1, id); }
  static void destroy(const GLuint* id) { glDeleteTextures(1, id); }
};
struct FramebufferKind {
  static void create(GLuint* id) { glGenFramebuffers(1, id); }
  static void destroy(const GLuint* id) { glDeleteFramebuffers(1, id); }
};
struct VertexArrayKind {
  static void create(GLuint* id) { glGenVertexArrays(1, id); }
  static void destroy(const GLuint* id) { glDeleteVertexArrays(1, id); }
};
struct QueryKind {
  static void create(GLuint* id) { glGenQueries(1, id); }
  static void destroy(const GLuint* id) { glDeleteQueries(1, id); }
};

using Buffer = Object<BufferKind>;
using Texture = Object<TextureKind>;
using Framebuffer = Object<FramebufferKind>;
using VertexArray = Object<VertexArrayKind>;
using Query = Object<QueryKind>;

/// A vertex and a fragment shader, linked. Uniforms are found by name; a name the compiler dropped
/// is ignored.
class Program {
 public:
  Program() = default;
  /// @errors NoGraphics with the driver's words, where it refuses our GLSL 3.30
  [[nodiscard]] static Result<Program> build(const std::string& name, const std::string& vertex,
                                             const std::string& fragment);
  Program(Program&& other) noexcept : id_(std::exchange(other.id_, 0)) {}
  Program& operator=(Program&& other) noexcept {
    std::swap(id_, other.id_);
    return *this;
  }
  ~Program() {
    if (id_ != 0) glDeleteProgram(id_);
  }

  void use() const { glUseProgram(id_); }
  [[nodiscard]] GLint location(const char* uniform) const {
    return glGetUniformLocation(id_, uniform);
  }
  void set(const char* uniform, int value) const;
  void set(const char* uniform, float value) const;
  void set(const char* uniform, const std::vector<float>& values, int components) const;
  void setMatrix(const char* uniform, const float* columns, int count = 1) const;
  /// Binds a texture to a unit and the sampler to that unit.
  void setTexture(const char* uniform, int unit, GLenum target, const Texture& texture) const;

 private:
  GLuint id_ = 0;
};

/// A texture of one level, nearest filter, clamped.
[[nodiscard]] Texture makeTexture2D(GLenum internalFormat, int width, int height);

/// Depth maps in one array, compared while sampled, bilinear; outside: lit.
[[nodiscard]] Texture makeShadowMaps(int size, int layers);

/// Colour textures in order and a depth texture (or none). @errors NoGraphics
[[nodiscard]] Result<Framebuffer> makeFramebuffer(const std::vector<const Texture*>& colours,
                                                  const Texture* depth);

}  // namespace ecorche::render::gl
