#pragma once

#include <ecorche/core/result.h>

#include <memory>
#include <string>

namespace ecorche::render {

/// An OpenGL 3.3 core context that needs no display, made current on this thread for as long as it
/// lives; what was current before comes back afterwards.
///
/// Tried in turn: EGL on Mesa's surfaceless platform, EGL on a graphics device, EGL's default
/// display. Mesa's llvmpipe answers where there is no graphics card.
class OffscreenContext {
 public:
  /// @errors NoGraphics, with what was tried and the way out
  [[nodiscard]] static Result<OffscreenContext> create();
  OffscreenContext(OffscreenContext&&) noexcept;
  OffscreenContext& operator=(OffscreenContext&&) noexcept;
  ~OffscreenContext();

  /// Who draws: "llvmpipe (LLVM 15.0.6, 256 bits), OpenGL 3.3".
  [[nodiscard]] const std::string& description() const;

 private:
  struct Impl;
  explicit OffscreenContext(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace ecorche::render
