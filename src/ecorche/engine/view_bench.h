#pragma once

#include <ecorche/engine/build.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace ecorche::engine {

struct ViewBenchOptions {
  std::optional<std::int64_t> tets;  ///< instead of the project's
  int width = 1280;                  ///< [pixels]
  int height = 720;                  ///< [pixels]
  int frames = 24;                   ///< while the view turns once around
  bool paper = true;                 ///< draw it the paper's way too, which takes its time
  char up = 'Z';                     ///< axis that points up in the model
  bool uniform = true;               ///< the domain that does not know the muscles too
};

/// Times of frames [s].
struct FrameTimes {
  double p50 = 0.0;
  double p95 = 0.0;
  double max = 0.0;
  double processor = 0.0;  ///< mean over all threads: does not grow when others use the machine
};

/// One domain, drawn straight from its fields.
struct ViewCase {
  std::string name;
  std::int64_t tets = 0;
  std::size_t muscles = 0;
  std::int64_t drawnTets = 0;  ///< on the card
  std::int64_t triangles = 0;  ///< in the last frame
  FrameTimes frame;            ///< bones, muscles, curves, lit: what a window shows in motion
  FrameTimes steps;          ///< muscles alone, without light: what the paper's way is held against
  FrameTimes paper;          ///< muscles alone the paper's way, three frames; 0: not drawn
  double prepare = 0.0;      ///< geometry, once per domain [s]
  double firstUpload = 0.0;  ///< records of all tets made and sent [s]
  std::uint64_t fullBytes = 0;
  /// After a curve moved sideways by 1 % of the diagonal
  double editShare = 0.0;  ///< of vertices where a field changed by more than 1e-3 of the largest
  std::uint64_t editBytes = 0;
  double editUpload = 0.0;  ///< changed records made and sent [s]
  double pick = 0.0;        ///< a ray that meets a muscle, mean [s]
  /// Against the ray caster at half the size: three sides, whole and cut, all tissues and half
  double sameTissue = 1.0;       ///< least share of pixels
  double normalsClose = 1.0;     ///< least share of those whose normals are within 3°
  double paperSameTissue = 1.0;  ///< the paper's way, whole, least of three sides
};

/// How fast and how right the preview is, on a domain that knows the muscles and on one that does
/// not (uniform but for its walls).
/// @errors  those of build; NoGraphics; Cancelled
[[nodiscard]] Result<std::vector<ViewCase>> benchView(const model::Project& project,
                                                      const ViewBenchOptions& options,
                                                      RunContext& run);

}  // namespace ecorche::engine
