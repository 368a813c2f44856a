#include <ecorche/render/offscreen.h>
#include <epoxy/egl.h>
#include <epoxy/gl.h>
#include <fmt/format.h>

#include <array>
#include <vector>

namespace ecorche::render {

struct OffscreenContext::Impl {
  EGLDisplay display = EGL_NO_DISPLAY;
  EGLContext context = EGL_NO_CONTEXT;
  std::string description;

  EGLDisplay displayBefore = EGL_NO_DISPLAY;
  EGLSurface drawBefore = EGL_NO_SURFACE;
  EGLSurface readBefore = EGL_NO_SURFACE;
  EGLContext contextBefore = EGL_NO_CONTEXT;

  // Displays are shared by the whole process and are not terminated: another context may live on
  // the same one.
  ~Impl() {
    if (context == EGL_NO_CONTEXT) return;
    eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    eglDestroyContext(display, context);
    if (contextBefore != EGL_NO_CONTEXT)
      eglMakeCurrent(displayBefore, drawBefore, readBefore, contextBefore);
  }
};

namespace {

struct Candidate {
  std::string name;
  EGLDisplay display = EGL_NO_DISPLAY;
};

// libepoxy ends the process when a function is called that nobody provides, so every extension is
// asked for first.
std::vector<Candidate> displays() {
  std::vector<Candidate> found;
  const auto clientHas = [](const char* extension) {
    return epoxy_has_egl_extension(EGL_NO_DISPLAY, extension);
  };
  if (clientHas("EGL_EXT_platform_base")) {
    if (clientHas("EGL_MESA_platform_surfaceless"))
      found.push_back({"surfaceless", eglGetPlatformDisplayEXT(EGL_PLATFORM_SURFACELESS_MESA,
                                                               EGL_DEFAULT_DISPLAY, nullptr)});
    if (clientHas("EGL_EXT_platform_device") && clientHas("EGL_EXT_device_enumeration")) {
      std::array<EGLDeviceEXT, 8> devices{};
      EGLint count = 0;
      if (eglQueryDevicesEXT(static_cast<EGLint>(devices.size()), devices.data(), &count))
        for (EGLint i = 0; i < count; ++i)
          found.push_back(
              {fmt::format("device {}", i),
               eglGetPlatformDisplayEXT(EGL_PLATFORM_DEVICE_EXT,
                                        devices[static_cast<std::size_t>(i)], nullptr)});
    }
  }
  found.push_back({"default display", eglGetDisplay(EGL_DEFAULT_DISPLAY)});
  return found;
}

EGLContext contextOn(EGLDisplay display) {
  EGLint major = 0;
  EGLint minor = 0;
  if (display == EGL_NO_DISPLAY || !eglInitialize(display, &major, &minor)) return EGL_NO_CONTEXT;
  if (!epoxy_has_egl_extension(display, "EGL_KHR_surfaceless_context") ||
      !eglBindAPI(EGL_OPENGL_API))
    return EGL_NO_CONTEXT;

  EGLConfig config = EGL_NO_CONFIG_KHR;
  if (!epoxy_has_egl_extension(display, "EGL_KHR_no_config_context")) {
    const EGLint wanted[] = {EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT, EGL_SURFACE_TYPE, EGL_PBUFFER_BIT,
                             EGL_NONE};
    EGLint count = 0;
    if (!eglChooseConfig(display, wanted, &config, 1, &count) || count == 0) return EGL_NO_CONTEXT;
  }
  const EGLint attributes[] = {EGL_CONTEXT_MAJOR_VERSION,
                               3,
                               EGL_CONTEXT_MINOR_VERSION,
                               3,
                               EGL_CONTEXT_OPENGL_PROFILE_MASK,
                               EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                               EGL_NONE};
  return eglCreateContext(display, config, EGL_NO_CONTEXT, attributes);
}

}  // namespace

OffscreenContext::OffscreenContext(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
OffscreenContext::OffscreenContext(OffscreenContext&&) noexcept = default;
OffscreenContext& OffscreenContext::operator=(OffscreenContext&&) noexcept = default;
OffscreenContext::~OffscreenContext() = default;

const std::string& OffscreenContext::description() const { return impl_->description; }

Result<OffscreenContext> OffscreenContext::create() {
  auto impl = std::make_unique<Impl>();
  impl->displayBefore = eglGetCurrentDisplay();
  impl->drawBefore = eglGetCurrentSurface(EGL_DRAW);
  impl->readBefore = eglGetCurrentSurface(EGL_READ);
  impl->contextBefore = eglGetCurrentContext();

  std::string tried;
  for (const Candidate& candidate : displays()) {
    tried += (tried.empty() ? "" : ", ") + candidate.name;
    const EGLContext context = contextOn(candidate.display);
    if (context == EGL_NO_CONTEXT) continue;
    if (!eglMakeCurrent(candidate.display, EGL_NO_SURFACE, EGL_NO_SURFACE, context)) {
      eglDestroyContext(candidate.display, context);
      continue;
    }
    impl->display = candidate.display;
    impl->context = context;
    const auto* who = reinterpret_cast<const char*>(glGetString(GL_RENDERER));
    const int version = epoxy_gl_version();
    impl->description =
        fmt::format("{}, OpenGL {}.{}", who ? who : "unknown renderer", version / 10, version % 10);
    return OffscreenContext(std::move(impl));
  }
  return fail(
      ErrorCode::NoGraphics,
      fmt::format("no OpenGL 3.3 for pictures (tried EGL: {}); install Mesa's software renderer "
                  "(Debian: apt install libegl1 libgl1-mesa-dri) or a driver of the graphics "
                  "card, or leave the picture out",
                  tried));
}

}  // namespace ecorche::render
