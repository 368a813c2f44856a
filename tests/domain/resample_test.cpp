#include <ecorche/domain/carve.h>
#include <ecorche/domain/resample.h>
#include <ecorche/domain/triangle_tree.h>
#include <ecorche/mesh/self_intersection.h>
#include <ecorche/mesh/surface_topology.h>
#include <support/shapes.h>

#include <catch2/catch.hpp>
#include <cmath>

using namespace ecorche;
using namespace ecorche::domain;
using mesh::Vector3;

namespace {

LengthField constant(double x) {
  return [x](const Vector3&) { return x; };
}

/// Both ways, as resampleWalls asks.
ResampleOptions asked(const LengthField& edgeLength, double tolerance) {
  return {.edgeLength = edgeLength,
          .tolerance = constant(tolerance),
          .loss = constant(1.5 * tolerance),
          .spacing = 2.0 * tolerance};
}

double meanEdge(const TaggedSurface& s) {
  double sum = 0.0;
  for (Eigen::Index f = 0; f < s.F.rows(); ++f) {
    for (int k = 0; k < 3; ++k) sum += (s.V.row(s.F(f, k)) - s.V.row(s.F(f, (k + 1) % 3))).norm();
  }
  return sum / static_cast<double>(3 * s.F.rows());
}

double farthest(const TaggedSurface& from, const TaggedSurface& to) {
  const TriangleTree tree(to.V, to.F);
  double far = 0.0;
  for (Eigen::Index f = 0; f < from.F.rows(); ++f) {
    Vector3 middle = Vector3::Zero();
    for (int k = 0; k < 3; ++k) {
      const Vector3 p = from.V.row(from.F(f, k)).transpose();
      middle += p / 3.0;
      far = std::max(far, std::sqrt(tree.closest(p).distance2));
    }
    far = std::max(far, std::sqrt(tree.closest(middle).distance2));
  }
  return far;
}

}  // namespace

TEST_CASE("resampling gives edges of the wanted length within the tolerance, coarser and finer") {
  const auto fine = tagged(test::sphere({0, 0, 0}, 1.0, 5), {BoundaryTag::Kind::Skin, 0});
  for (const double length : {0.02, 0.08, 0.15}) {
    RunContext run;
    const double tolerance = 0.01;
    const auto out = resample(fine, {}, asked(constant(length), tolerance), run);
    REQUIRE(out);
    CHECK(mesh::isClosed(out->F));
    CHECK(mesh::isManifold(out->F));
    CHECK(mesh::isOriented(out->F));
    CHECK(meanEdge(*out) == Approx(length).epsilon(0.15));
    CHECK(farthest(*out, fine) < 1.05 * tolerance);
    CHECK(farthest(fine, *out) < 1.5 * tolerance);
    CHECK(mesh::selfIntersections(out->V, out->F).empty());
  }
}

TEST_CASE("where the surface bends too much for the wanted length, edges stay shorter") {
  const auto fine = tagged(test::sphere({0, 0, 0}, 1.0, 5), {BoundaryTag::Kind::Skin, 0});
  RunContext run;
  const auto out = resample(fine, {}, asked(constant(1.0), 0.01), run);
  REQUIRE(out);
  CHECK(farthest(*out, fine) < 0.0105);
  // A sagitta of h²/8 within 0.01 allows edges of about 0.28
  CHECK(meanEdge(*out) < 0.4);
  CHECK(meanEdge(*out) > 0.1);
}

TEST_CASE("a box keeps its corners, edges and volume") {
  const auto box = tagged(test::box({0, 0, 0}, {1, 2, 3}), {BoundaryTag::Kind::Skin, 0});
  RunContext run;
  const auto out = resample(box, {}, asked(constant(0.2), 0.01), run);
  REQUIRE(out);
  CHECK(mesh::signedVolume(out->V, out->F) == Approx(6.0).epsilon(1e-9));
  CHECK(meanEdge(*out) == Approx(0.2).epsilon(0.2));
}

TEST_CASE("curves between tags stay, and planes stay planes") {
  CarveInput input;
  input.skin = test::sphere({0, 0, 0}, 1.0, 4);
  input.cutPlanes = {{"median", {0, 0.1, 0}, {0, 1, 0}}};
  RunContext run;
  const auto carved = carve(input, {.wrapTolerance = 0.01}, run);
  REQUIRE(carved);
  const auto out = resample(carved->surface, input.cutPlanes, asked(constant(0.1), 0.01), run);
  REQUIRE(out);
  CHECK(mesh::isManifold(out->F));
  double area = 0.0;
  for (Eigen::Index f = 0; f < out->F.rows(); ++f) {
    if (unpacked(out->tag[static_cast<std::size_t>(f)]).kind != BoundaryTag::Kind::CutPlane)
      continue;
    area += mesh::surfaceArea(out->V, out->F.row(f));
    for (int k = 0; k < 3; ++k) CHECK(out->V(out->F(f, k), 1) == 0.1);
  }
  CHECK(area == Approx(3.14159 * 0.99).epsilon(0.02));
}

TEST_CASE("an open surface is refused with a place") {
  auto open = tagged(test::sphere({0, 0, 0}, 1.0, 2), {BoundaryTag::Kind::Skin, 0});
  open.F.conservativeResize(open.F.rows() - 1, 3);
  open.tag.pop_back();
  RunContext run;
  const auto out = resample(open, {}, asked(constant(0.1), 0.01), run);
  REQUIRE_FALSE(out);
  CHECK(out.error().code == ErrorCode::MeshNotRepairable);
  CHECK(out.error().place.point.has_value());
}

TEST_CASE("needles whose corners lie on one line are split to an end") {
  // A box whose lid is cut into a fan from one corner, with points along the far side: nearly
  // collinear triangles of very different lengths, as cutting a skin at a plane leaves them
  mesh::SurfaceMesh lid = test::box({0, 0, 0}, {1, 1, 1});
  const auto base = lid.V.rows();
  constexpr int kPoints = 9;
  lid.V.conservativeResize(base + kPoints, 3);
  for (int i = 0; i < kPoints; ++i) lid.V.row(base + i) << std::pow(0.5, i + 1), 0.0, 1.0;
  // Edge (0,0,1)–(1,0,1) of the box gets the points
  std::int32_t a = -1, b = -1;
  for (Eigen::Index v = 0; v < base; ++v) {
    if (lid.V.row(v) == Eigen::RowVector3d(0, 0, 1)) a = static_cast<std::int32_t>(v);
    if (lid.V.row(v) == Eigen::RowVector3d(1, 0, 1)) b = static_cast<std::int32_t>(v);
  }
  std::vector<std::int32_t> chain{b};
  for (int i = 0; i < kPoints; ++i) chain.push_back(static_cast<std::int32_t>(base + i));
  chain.push_back(a);
  std::vector<Eigen::RowVector3i> faces;
  for (Eigen::Index f = 0; f < lid.F.rows(); ++f) {
    const Eigen::RowVector3i face = lid.F.row(f);
    int k = 0;
    while (k < 3 && !((face[k] == a && face[(k + 1) % 3] == b) ||
                      (face[k] == b && face[(k + 1) % 3] == a))) {
      ++k;
    }
    if (k == 3) {
      faces.push_back(face);
      continue;
    }
    const bool forward = face[k] == b;
    for (std::size_t i = 0; i + 1 < chain.size(); ++i) {
      const std::int32_t from = forward ? chain[i] : chain[i + 1];
      const std::int32_t to = forward ? chain[i + 1] : chain[i];
      faces.emplace_back(from, to, face[(k + 2) % 3]);
    }
  }
  lid.F.resize(static_cast<Eigen::Index>(faces.size()), 3);
  for (std::size_t f = 0; f < faces.size(); ++f) lid.F.row(static_cast<Eigen::Index>(f)) = faces[f];

  const auto walls = tagged(lid, {BoundaryTag::Kind::Skin, 0});
  RunContext run;
  const auto length = [](const Vector3& p) { return 0.02 + 0.3 * (p - Vector3(0.2, 0, 1)).norm(); };
  const auto out = resample(walls, {}, asked(length, 0.002), run);
  REQUIRE(out);
  CHECK(mesh::isClosed(out->F));
  CHECK(mesh::signedVolume(out->V, out->F) == Approx(1.0).epsilon(1e-9));
  CHECK(out->F.rows() < 20000);
}

TEST_CASE("bumps that coarse triangles could cut off are kept within the loss") {
  // Every step moves the surface by less than the tolerance; many of them would add up
  auto bumpy = tagged(test::sphere({0, 0, 0}, 1.0, 6), {BoundaryTag::Kind::Skin, 0});
  for (Eigen::Index v = 0; v < bumpy.V.rows(); ++v) {
    const auto p = bumpy.V.row(v);
    bumpy.V.row(v) *=
        1.0 + 0.05 * std::sin(14 * p.x()) * std::sin(14 * p.y()) * std::cos(14 * p.z());
  }
  RunContext run;
  const double tolerance = 0.01;
  const auto out = resample(bumpy, {}, asked(constant(0.3), tolerance), run);
  REQUIRE(out);
  CHECK(farthest(bumpy, *out) <= 1.5 * tolerance);
  CHECK(out->F.rows() < bumpy.F.rows() / 4);
}
