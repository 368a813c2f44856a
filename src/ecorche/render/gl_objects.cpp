#include <ecorche/core/contract.h>
#include <ecorche/render/gl_objects.h>
#include <fmt/format.h>

namespace ecorche::render::gl {
namespace {

struct Shader {
  GLuint id = 0;
  explicit Shader(GLenum kind) : id(glCreateShader(kind)) {}
  ~Shader() { glDeleteShader(id); }
  Shader(const Shader&) = delete;
  Shader& operator=(const Shader&) = delete;
};

Result<void> compile(const Shader& shader, const std::string& name, const std::string& source) {
  const char* text = source.c_str();
  glShaderSource(shader.id, 1, &text, nullptr);
  glCompileShader(shader.id);
  GLint good = GL_FALSE;
  glGetShaderiv(shader.id, GL_COMPILE_STATUS, &good);
  if (good) return {};
  std::string words(2000, '\0');
  GLsizei length = 0;
  glGetShaderInfoLog(shader.id, static_cast<GLsizei>(words.size()), &length, words.data());
  words.resize(static_cast<std::size_t>(length));
  return fail(ErrorCode::NoGraphics,
              fmt::format("the graphics driver refuses the shader \"{}\": {}; try Mesa's software "
                          "renderer with LIBGL_ALWAYS_SOFTWARE=1",
                          name, words));
}

}  // namespace

Result<Program> Program::build(const std::string& name, const std::string& vertex,
                               const std::string& fragment) {
  const Shader v(GL_VERTEX_SHADER);
  const Shader f(GL_FRAGMENT_SHADER);
  if (auto ok = compile(v, name + ".vert", vertex); !ok) return passOn(ok);
  if (auto ok = compile(f, name + ".frag", fragment); !ok) return passOn(ok);

  Program program;
  program.id_ = glCreateProgram();
  glAttachShader(program.id_, v.id);
  glAttachShader(program.id_, f.id);
  glLinkProgram(program.id_);
  glDetachShader(program.id_, v.id);
  glDetachShader(program.id_, f.id);
  GLint good = GL_FALSE;
  glGetProgramiv(program.id_, GL_LINK_STATUS, &good);
  if (good) return program;
  std::string words(2000, '\0');
  GLsizei length = 0;
  glGetProgramInfoLog(program.id_, static_cast<GLsizei>(words.size()), &length, words.data());
  words.resize(static_cast<std::size_t>(length));
  return fail(ErrorCode::NoGraphics,
              fmt::format("the graphics driver cannot link the shader \"{}\": {}; try Mesa's "
                          "software renderer with LIBGL_ALWAYS_SOFTWARE=1",
                          name, words));
}

void Program::set(const char* uniform, int value) const {
  glUniform1i(glGetUniformLocation(id_, uniform), value);
}

void Program::set(const char* uniform, float value) const {
  glUniform1f(glGetUniformLocation(id_, uniform), value);
}

void Program::set(const char* uniform, const std::vector<float>& values, int components) const {
  const GLint at = glGetUniformLocation(id_, uniform);
  const auto count = static_cast<GLsizei>(values.size()) / components;
  switch (components) {
    case 2:
      glUniform2fv(at, count, values.data());
      break;
    case 3:
      glUniform3fv(at, count, values.data());
      break;
    case 4:
      glUniform4fv(at, count, values.data());
      break;
    default:
      EC_REQUIRE(components >= 2 && components <= 4);
  }
}

void Program::setMatrix(const char* uniform, const float* columns, int count) const {
  glUniformMatrix4fv(glGetUniformLocation(id_, uniform), count, GL_FALSE, columns);
}

void Program::setTexture(const char* uniform, int unit, GLenum target,
                         const Texture& texture) const {
  glActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(unit));
  glBindTexture(target, texture.id());
  set(uniform, unit);
}

Texture makeTexture2D(GLenum internalFormat, int width, int height) {
  const bool depth = internalFormat == GL_DEPTH_COMPONENT32F;
  Texture texture = Texture::make();
  glBindTexture(GL_TEXTURE_2D, texture.id());
  const bool whole = internalFormat == GL_RG32UI;
  glTexImage2D(GL_TEXTURE_2D, 0, static_cast<GLint>(internalFormat), width, height, 0,
               depth   ? GL_DEPTH_COMPONENT
               : whole ? GL_RG_INTEGER
                       : GL_RGBA,
               whole ? GL_UNSIGNED_INT : GL_FLOAT, nullptr);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  return texture;
}

Texture makeShadowMaps(int size, int layers) {
  Texture texture = Texture::make();
  glBindTexture(GL_TEXTURE_2D_ARRAY, texture.id());
  glTexImage3D(GL_TEXTURE_2D_ARRAY, 0, GL_DEPTH_COMPONENT32F, size, size, layers, 0,
               GL_DEPTH_COMPONENT, GL_FLOAT, nullptr);
  const float lit[] = {1.0f, 1.0f, 1.0f, 1.0f};
  glTexParameterfv(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_BORDER_COLOR, lit);
  glTexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  glTexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  glTexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_BORDER);
  glTexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_BORDER);
  glTexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
  glTexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_COMPARE_FUNC, GL_LEQUAL);
  return texture;
}

Result<Framebuffer> makeFramebuffer(const std::vector<const Texture*>& colours,
                                    const Texture* depth) {
  Framebuffer framebuffer = Framebuffer::make();
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer.id());
  std::vector<GLenum> targets;
  for (const Texture* colour : colours) {
    targets.push_back(GL_COLOR_ATTACHMENT0 + static_cast<GLenum>(targets.size()));
    glFramebufferTexture2D(GL_FRAMEBUFFER, targets.back(), GL_TEXTURE_2D, colour->id(), 0);
  }
  if (depth)
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, depth->id(), 0);
  if (targets.empty()) {
    glDrawBuffer(GL_NONE);
    glReadBuffer(GL_NONE);
  } else {
    glDrawBuffers(static_cast<GLsizei>(targets.size()), targets.data());
  }
  const GLenum status = glCheckFramebufferStatus(GL_FRAMEBUFFER);
  if (status != GL_FRAMEBUFFER_COMPLETE)
    return fail(
        ErrorCode::NoGraphics,
        fmt::format("the graphics driver cannot draw into our buffers (status {:#x}); try a "
                    "smaller picture or LIBGL_ALWAYS_SOFTWARE=1",
                    status));
  return framebuffer;
}

}  // namespace ecorche::render::gl
