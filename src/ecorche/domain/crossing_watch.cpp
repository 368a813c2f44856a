#include <ecorche/core/index.h>
#include <ecorche/domain/crossing_watch.h>

#include <algorithm>
#include <limits>

namespace ecorche::domain {

namespace {

using mesh::FaceCorners;

mesh::Box boxOf(const FaceCorners& face) {
  const auto& [a, b, c] = face.at;
  return {a.cwiseMin(b).cwiseMin(c), a.cwiseMax(b).cwiseMax(c)};
}

}  // namespace

CrossingWatch::CrossingWatch(const TaggedSurface& surface) : tree_(mesh::boundingBox(surface.V)) {
  faces_.reserve(static_cast<std::size_t>(surface.F.rows()));
  for (Eigen::Index f = 0; f < surface.F.rows(); ++f)
    put(static_cast<std::int32_t>(f), mesh::faceCorners(surface.V, surface.F, f));
}

void CrossingWatch::put(std::int32_t face, const FaceCorners& corners) {
  if (toIndex(face) >= faces_.size()) faces_.resize(toIndex(face) + 1);
  faces_[toIndex(face)] = corners;
  // Faces without area meet nothing, as in mesh::selfIntersections
  if (!mesh::isDegenerate(corners)) tree_.add(face, boxOf(corners));
}

int CrossingWatch::meeting(std::span<const FaceCorners> faces, const SurfaceStep& step,
                           int limit) const {
  int count = 0;
  for (std::size_t i = 0; i < faces.size() && count < limit; ++i) {
    if (mesh::isDegenerate(faces[i])) continue;
    tree_.visit(boxOf(faces[i]), [&](std::int32_t other) {
      if (std::ranges::find(step.before, other) == step.before.end())
        count += mesh::facesMeet(faces[i], faces_[toIndex(other)]) ? 1 : 0;
      return count >= limit;
    });
    for (std::size_t j = 0; j < i && count < limit; ++j) {
      if (!mesh::isDegenerate(faces[j])) count += mesh::facesMeet(faces[i], faces[j]) ? 1 : 0;
    }
  }
  return count;
}

bool CrossingWatch::allows(const SurfaceStep& step) const {
  std::vector<FaceCorners> after;
  for (const NewFace& face : step.after) after.push_back(face.corners);
  if (meeting(after, step, 1) == 0) return true;
  std::vector<FaceCorners> before;
  // After a split the step takes away faces that were never laid
  for (const std::int32_t face : step.before) {
    if (tree_.holds(face)) before.push_back(faces_[toIndex(face)]);
  }
  const int now = meeting(before, step, std::numeric_limits<int>::max());
  return now > 0 && meeting(after, step, now + 1) <= now;
}

void CrossingWatch::follow(const SurfaceStep& step) {
  for (const std::int32_t face : step.before) tree_.remove(face);
  for (const NewFace& face : step.after) put(face.face, face.corners);
}

}  // namespace ecorche::domain
