#include <ecorche/render/slice.h>

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <map>
#include <numbers>

#include "render/scenes.h"

using namespace ecorche;
using mesh::Vector3;
using render::ClipPlane;

namespace {

// A unit cube of n³ cells of six tets each (Kuhn); label 2 where x < 0.5, else 3.
struct LabelledCube {
  mesh::TetMesh tets;
  std::vector<TissueId> labels;
  mesh::TetNeighbours neighbours;
};

LabelledCube labelledCube(int n) {
  LabelledCube cube;
  const auto vertex = [&](int i, int j, int k) { return (i * (n + 1) + j) * (n + 1) + k; };
  cube.tets.V.resize((n + 1) * (n + 1) * (n + 1), 3);
  for (int i = 0; i <= n; ++i)
    for (int j = 0; j <= n; ++j)
      for (int k = 0; k <= n; ++k) cube.tets.V.row(vertex(i, j, k)) = Vector3(i, j, k) / n;
  std::vector<std::array<int, 4>> tets;
  constexpr int kOrders[6][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {0, 2, 1}, {2, 1, 0}, {1, 0, 2}};
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j)
      for (int k = 0; k < n; ++k)
        for (int o = 0; o < 6; ++o) {
          int at[3] = {i, j, k};
          std::array<int, 4> t{};
          t[0] = vertex(i, j, k);
          for (int s = 0; s < 3; ++s) {
            ++at[kOrders[o][s]];
            t[static_cast<std::size_t>(s) + 1] = vertex(at[0], at[1], at[2]);
          }
          if (o >= 3) std::swap(t[2], t[3]);
          tets.push_back(t);
          cube.labels.push_back(TissueId{2 * i < n ? 2 : 3});
        }
  cube.tets.T.resize(static_cast<Eigen::Index>(tets.size()), 4);
  for (std::size_t t = 0; t < tets.size(); ++t)
    for (int c = 0; c < 4; ++c)
      cube.tets.T(static_cast<Eigen::Index>(t), c) = tets[t][static_cast<std::size_t>(c)];
  cube.neighbours = mesh::tetAdjacency(cube.tets.T).neighbours;
  return cube;
}

double borderLength(const render::TetSlice& slice, TissueId one, TissueId other) {
  double sum = 0.0;
  for (const auto& b : slice.borders)
    if (b.one == one && b.other == other) sum += (b.to - b.from).norm();
  return sum;
}

}  // namespace

TEST_CASE("a slice of labelled tets has the areas and borders of the bodies it cuts") {
  const LabelledCube cube = labelledCube(6);
  // Through vertices (z = 0.5) and between them
  for (const double z : {0.5, 0.41}) {
    const auto slice = render::sliceTets(cube.tets, cube.labels, cube.neighbours,
                                         {{0.0, 0.0, z}, Vector3::UnitZ()});
    INFO("z " << z);
    CHECK(slice.area.at(TissueId{2}) == Approx(0.5));
    CHECK(slice.area.at(TissueId{3}) == Approx(0.5));
    CHECK(mesh::surfaceArea(slice.mesh.V, slice.mesh.F) == Approx(1.0));
    CHECK(static_cast<Eigen::Index>(slice.label.size()) == slice.mesh.F.rows());
    CHECK(borderLength(slice, TissueId{3}, TissueId{2}) == Approx(1.0));
    CHECK(borderLength(slice, TissueId{2}, kNoTissue) == Approx(2.0));
    CHECK(borderLength(slice, TissueId{3}, kNoTissue) == Approx(2.0));
  }
  // Across a corner: an equilateral triangle
  const double d = 0.35;
  const auto corner = render::sliceTets(cube.tets, cube.labels, cube.neighbours,
                                        {{d, 0.0, 0.0}, Vector3(1.0, 1.0, 1.0)});
  CHECK(mesh::surfaceArea(corner.mesh.V, corner.mesh.F) ==
        Approx(std::sqrt(3.0) / 4.0 * 2.0 * d * d));
  // Beside the body: nothing
  CHECK(render::sliceTets(cube.tets, cube.labels, cube.neighbours,
                          {{0.0, 0.0, 2.0}, Vector3::UnitZ()})
            .mesh.empty());
}

TEST_CASE("a slice is conforming, flat, and faces what was taken away") {
  const LabelledCube cube = labelledCube(5);
  const ClipPlane plane{{0.4, 0.5, 0.6}, Vector3(0.3, -0.5, 0.8)};
  const auto slice = render::sliceTets(cube.tets, cube.labels, cube.neighbours, plane);
  std::map<std::pair<int, int>, int> edges;
  for (Eigen::Index f = 0; f < slice.mesh.F.rows(); ++f) {
    const Vector3 a = slice.mesh.V.row(slice.mesh.F(f, 0));
    const Vector3 b = slice.mesh.V.row(slice.mesh.F(f, 1));
    const Vector3 c = slice.mesh.V.row(slice.mesh.F(f, 2));
    CHECK((b - a).cross(c - a).dot(plane.normal) <= 1e-15);
    CHECK(std::abs((a - plane.point).dot(plane.normal)) < 1e-12);
    for (int k = 0; k < 3; ++k)
      ++edges[std::minmax(slice.mesh.F(f, k), slice.mesh.F(f, (k + 1) % 3))];
  }
  int open = 0;
  for (const auto& [edge, count] : edges) {
    CHECK(count <= 2);
    open += count == 1 ? 1 : 0;
  }
  // Open edges are those where the body ends
  int ends = 0;
  for (const auto& b : slice.borders) ends += b.other == kNoTissue ? 1 : 0;
  CHECK(open == ends);
}

TEST_CASE("the cut through a closed surface is filled: balls, shells, either orientation") {
  const auto outer = test::ball({0.2, 0.1, -0.3}, 1.0, 96);
  const Vector3 normal = Vector3(0.4, -0.2, 0.7).normalized();
  for (const double off : {0.0, 0.35, -0.8}) {
    const ClipPlane plane{Vector3(0.2, 0.1, -0.3) + off * normal, normal};
    const double expected = std::numbers::pi * (1.0 - off * off);
    const auto slice = render::sliceSurface(*outer, plane);
    CHECK(slice.area == Approx(expected).epsilon(2e-3));
    CHECK(mesh::surfaceArea(slice.mesh.V, slice.mesh.F) == Approx(slice.area).epsilon(1e-9));
    double length = 0.0;
    for (const auto& s : slice.outline) length += (s[1] - s[0]).norm();
    CHECK(length == Approx(2.0 * std::sqrt(std::numbers::pi * expected)).epsilon(2e-3));
  }
  // A shell: the hollow stays empty; the inner ball may face either way
  for (const bool inward : {false, true}) {
    auto inner = *test::ball({0.2, 0.1, -0.3}, 0.5, 96);
    if (inward) inner.F.col(0).swap(inner.F.col(1));
    const auto shell = mesh::joined({*outer, inner}, "shell");
    const auto slice = render::sliceSurface(shell, {{0.2, 0.1, -0.3}, normal});
    CHECK(slice.area == Approx(std::numbers::pi * 0.75).epsilon(2e-3));
  }
  CHECK(render::sliceSurface(*outer, {{9.0, 0.0, 0.0}, normal}).mesh.empty());
}

TEST_CASE("a capped ball that is cut shows a disc in the cap's colour") {
  render::Scene scene;
  auto ball = test::item(test::ball(Vector3::Zero(), 1.0), {0.1f, 0.1f, 0.6f, 1.0f});
  ball.capped = true;
  ball.capColour = render::Rgba{0.7f, 0.1f, 0.1f, 1.0f};
  scene.surfaces = {ball};
  scene.clip = ClipPlane{{0.0, -0.4, 0.0}, Vector3::UnitY()};  // what is nearer to the eye goes
  RunContext run;
  const int size = 100;
  const auto image =
      render::renderPicture(scene, test::straightCamera(4.0), test::plainOptions(size, size), run);
  REQUIRE(image);
  const double disc = 0.25 * size * std::sqrt(1.0 - 0.16);
  for (int y = 0; y < size; ++y)
    for (int x = 0; x < size; ++x) {
      const double r = std::hypot(x + 0.5 - 0.5 * size, y + 0.5 - 0.5 * size);
      const auto& p = image->at(x, y);
      if (r < disc - 1.5) CHECK(p[0] > p[2] + 40);
      if (r > disc + 1.2 && r < 0.25 * size - 1.5) CHECK(p[2] > p[0]);
    }
}

TEST_CASE("slice items carry a colour per face and are not clipped away") {
  const LabelledCube cube = labelledCube(4);
  const auto slice = render::sliceTets(cube.tets, cube.labels, cube.neighbours,
                                       {{0.0, 0.3, 0.0}, Vector3::UnitY()});
  const std::vector<render::Rgba> colours{
      {}, {}, {0.6f, 0.1f, 0.1f, 1.0f}, {0.1f, 0.1f, 0.6f, 1.0f}};
  render::Scene scene;
  scene.surfaces = {render::sliceItem(slice, colours)};
  scene.lines = {render::sliceBorders(slice)};
  scene.clip = ClipPlane{{0.0, 0.3, 0.0}, Vector3::UnitY()};
  auto camera = test::straightCamera(1.2);
  camera.eye = {0.5, -5.0, 0.5};
  camera.target = {0.5, 0.0, 0.5};
  RunContext run;
  const auto image = render::renderPicture(scene, camera, test::plainOptions(60, 60), run);
  REQUIRE(image);
  CHECK(image->at(15, 30)[0] > image->at(15, 30)[2] + 40);
  CHECK(image->at(45, 30)[2] > image->at(45, 30)[0] + 40);
  // The border between them is dark
  int darkest = 255;
  for (int x = 27; x < 33; ++x)
    darkest = std::min<int>(darkest, std::max(image->at(x, 30)[0], image->at(x, 30)[2]));
  CHECK(darkest < 130);
}
