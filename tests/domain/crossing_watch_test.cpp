#include <ecorche/domain/crossing_watch.h>

#include <array>
#include <catch2/catch.hpp>

using namespace ecorche;
using namespace ecorche::domain;
using mesh::Vector3;

namespace {

using Triangle = std::array<Vector3, 3>;

constexpr int kMiddle = 100;  // number of the vertex that a split makes
const Vector3 kA(0, 0, 0);
const Vector3 kB(1, 0, 0);
const Vector3 kC(1, 1, 0);
const Vector3 kD(0, 1, 0);

// A square in the plane z = 0, faces 0 and 1, and other triangles after it
TaggedSurface squareAnd(const std::vector<Triangle>& others) {
  TaggedSurface out;
  const auto count = static_cast<Eigen::Index>(others.size());
  out.V.resize(4 + 3 * count, 3);
  out.V.topRows(4) << kA.transpose(), kB.transpose(), kC.transpose(), kD.transpose();
  out.F.resize(2 + count, 3);
  out.F.topRows(2) << 0, 1, 2, 0, 2, 3;
  for (Eigen::Index i = 0; i < count; ++i) {
    for (int k = 0; k < 3; ++k)
      out.V.row(4 + 3 * i + k) =
          others[static_cast<std::size_t>(i)][static_cast<std::size_t>(k)].transpose();
    out.F.row(2 + i) << 4 + 3 * i, 5 + 3 * i, 6 + 3 * i;
  }
  out.tag.assign(static_cast<std::size_t>(out.F.rows()), 0);
  return out;
}

// The square's diagonal split at a point; resampling has numbered the new faces by then
struct Split {
  std::array<std::int32_t, 4> before{0, 1, 50, 51};
  std::array<NewFace, 4> after;
  explicit Split(const Vector3& at)
      : after{NewFace{0, {{0, 1, kMiddle}, {kA, kB, at}}},
              NewFace{1, {{kMiddle, 2, 3}, {at, kC, kD}}},
              NewFace{50, {{1, 2, kMiddle}, {kB, kC, at}}},
              NewFace{51, {{0, kMiddle, 3}, {kA, at, kD}}}} {}
  [[nodiscard]] SurfaceStep step() const { return {before, after}; }
};

const Triangle kThrough{Vector3(0.8, 0.3, -1), Vector3(0.9, 0.3, -1), Vector3(0.85, 0.3, 1)};
const Triangle kAbove{Vector3(0.3, 0.3, 0.1), Vector3(0.7, 0.7, 0.1), Vector3(0.5, 0.5, 0.9)};

}  // namespace

TEST_CASE("a split is judged by the faces that were there before it") {
  const Split flat({0.5, 0.5, 0});
  const Split lifted({0.5, 0.5, 0.5});
  CHECK(CrossingWatch(squareAnd({})).allows(flat.step()));
  CHECK(CrossingWatch(squareAnd({})).allows(lifted.step()));
  CHECK(CrossingWatch(squareAnd({kAbove})).allows(flat.step()));
  CHECK_FALSE(CrossingWatch(squareAnd({kAbove})).allows(lifted.step()));
  // What crosses already may stay as it is, but nothing may come to it
  CHECK(CrossingWatch(squareAnd({kThrough})).allows(flat.step()));
  CHECK_FALSE(CrossingWatch(squareAnd({kThrough, kAbove})).allows(lifted.step()));
}

TEST_CASE("a watch that followed a split knows the new faces") {
  CrossingWatch watch(squareAnd({kAbove}));
  watch.follow(Split({0.5, 0.5, 0}).step());
  CHECK_FALSE(watch.allows(Split({0.5, 0.5, 0.5}).step()));
  CHECK(watch.allows(Split({0.4, 0.6, 0.0}).step()));
  // Nor do they count as others to the step that takes them away
  watch.follow(Split({0.5, 0.5, 0.5}).step());
  CHECK(watch.allows(Split({0.5, 0.5, 0.5}).step()));
  CHECK(watch.allows(Split({0.5, 0.5, 0}).step()));
}
