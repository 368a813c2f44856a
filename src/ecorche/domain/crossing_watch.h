#pragma once

#include <ecorche/domain/face_octree.h>
#include <ecorche/domain/surface_step.h>
#include <ecorche/domain/tagged_surface.h>

#include <vector>

namespace ecorche::domain {

/// A surface that is being replaced face by face, watched for steps after which it would cut
/// itself. Exact, so what was free of crossings stays free of them.
class CrossingWatch {
 public:
  explicit CrossingWatch(const TaggedSurface& surface);

  /// Would no more faces meet than before? What crosses already may be made better step by step.
  [[nodiscard]] bool allows(const SurfaceStep& step) const;
  void follow(const SurfaceStep& step);

 private:
  void put(std::int32_t face, const mesh::FaceCorners& corners);
  /// Pairs of faces that meet, one of them or both among `faces`, those of the step before left out
  /// as the other; counted up to `limit`.
  [[nodiscard]] int meeting(std::span<const mesh::FaceCorners> faces, const SurfaceStep& step,
                            int limit) const;

  std::vector<mesh::FaceCorners> faces_;  // by number
  FaceOctree tree_;
};

}  // namespace ecorche::domain
