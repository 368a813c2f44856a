#pragma once

#include <ecorche/core/result.h>
#include <ecorche/render/scene.h>
#include <ecorche/render/tissue_image.h>

#include <memory>

namespace ecorche::render {

/// The paper's way to draw a volume [ABLSJ21 §3.6], for comparison only: every tet as four
/// triangles; a fragment whose ray enters in fat marches to the exit in even steps, asking all
/// fields, until it finds a muscle. Backs are culled and tets that are all fat know it, both of
/// which the paper leaves open. Knows neither clip plane nor hidden muscles.
class PaperVolume {
 public:
  static constexpr int kSteps = 16;  ///< of a march; the paper names no number

  /// Needs the context that is current to stay so. @errors NoGraphics
  [[nodiscard]] static Result<PaperVolume> create(const VolumeItem& item, int width, int height);
  PaperVolume(PaperVolume&&) noexcept;
  PaperVolume& operator=(PaperVolume&&) noexcept;
  ~PaperVolume();

  /// Draws and waits for the card.
  void draw(const Camera& camera);
  [[nodiscard]] TissueImage read() const;

 private:
  struct Impl;
  explicit PaperVolume(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace ecorche::render
