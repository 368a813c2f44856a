#pragma once

#include <ecorche/core/result.h>
#include <ecorche/core/run_context.h>
#include <ecorche/render/image.h>
#include <ecorche/render/scene.h>
#include <ecorche/render/tissue_image.h>

#include <cstdint>
#include <memory>
#include <optional>

namespace ecorche::render {

struct PictureOptions {
  int width = 1600;   ///< [pixels]
  int height = 1000;  ///< [pixels]
  /// Passes that are averaged, each with its own place inside the pixel and its own lamps:
  /// anti-aliasing, soft shadows and ambient occlusion all come from this. 1 for a view in motion,
  /// 12 good, 32 for print.
  int samples = 12;
  /// For a view that is being turned or edited: a single pass, lit by lamps without shadow maps,
  /// clefts darkened by what the depth of the picture tells, edges smoothed. `samples` counts as 1.
  bool motion = false;
  /// Directions of light in a pass, each a shadow map, 4 to 16. Unset: 10, large scenes 8. Above
  /// 250,000 triangles two passes share their shadow maps, above 1.5 million four.
  std::optional<int> lightsPerPass;
  int shadowMapSize = 1024;  ///< [texels]
  float exposure = 1.15f;    ///< light on a surface turned to the lamps; 1: white stays white
  float outline = 0.28f;     ///< dark line where one thing passes before another. 0: none
  bool gradient = false;     ///< background darker towards the corners
  /// Up: a soft shadow on the ground under the lowest point. Unset: none.
  std::optional<mesh::Vector3> ground;
};

/// Draws scenes with OpenGL 3.3 core into whatever framebuffer is bound; knows no window.
///
/// Every pass draws shadow maps for a few directions, what is seen (colour, normal, depth), lights
/// it, lays the transparent surfaces over it by depth peeling, and adds the result to a sum. A
/// window calls pass() once a frame and shows the sum so far; it refines while nothing moves. Needs
/// the context it was made in to be current, and leaves bindings and switches of that context as it
/// likes.
class Renderer {
 public:
  /// @errors NoGraphics: no context is current, too old, or the driver refuses our shaders
  [[nodiscard]] static Result<Renderer> create();
  Renderer(Renderer&&) noexcept;
  Renderer& operator=(Renderer&&) noexcept;
  ~Renderer();

  /// Starts a picture. Meshes seen before with the same address and revision are not prepared
  /// again.
  /// @errors NoGraphics
  [[nodiscard]] Result<void> begin(const Scene& scene, const Camera& camera,
                                   const PictureOptions& options);
  /// Adds the next pass; false when all were there already.
  bool pass();
  /// What a pass sees and nothing more, waiting for the card: for readTissues() and for timing.
  void passUnlit();
  /// The mean of the passes so far, tone-mapped and sRGB-encoded, into the bound framebuffer at the
  /// viewport's origin.
  void resolve(int x = 0, int y = 0);
  /// The same as an image.
  [[nodiscard]] Image read();
  /// Which tissue of scene.volume the last pass saw where, and its normals.
  [[nodiscard]] TissueImage readTissues();

  /// What the last begin() and pass() sent to the graphics card for scene.volume.
  struct VolumeUploads {
    std::uint64_t content = 0;   ///< tets and fields that are new or changed [bytes]
    std::uint64_t view = 0;      ///< which of them this eye can see, front to back [bytes]
    std::int64_t tets = 0;       ///< on the card
    std::int64_t triangles = 0;  ///< drawn in the last pass
  };
  [[nodiscard]] VolumeUploads volumeUploads() const;

 private:
  struct Impl;
  explicit Renderer(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

/// A finished picture without any display. Same bytes every time on one machine.
///
/// @errors NoGraphics, Cancelled
[[nodiscard]] Result<Image> renderPicture(const Scene& scene, const Camera& camera,
                                          const PictureOptions& options, RunContext& run);

}  // namespace ecorche::render
