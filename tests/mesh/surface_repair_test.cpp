#include <ecorche/mesh/read_mesh.h>
#include <ecorche/mesh/surface_check.h>
#include <ecorche/mesh/surface_query.h>
#include <ecorche/mesh/surface_repair.h>
#include <ecorche/mesh/weld.h>

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <filesystem>
#include <limits>
#include <random>

#include "mesh/repairs.h"
#include "support/paths.h"

using namespace ecorche;
using namespace ecorche::mesh;

TEST_CASE("a sound surface comes back as it was, and a repaired one needs no repair") {
  const SurfaceMesh m = test::torus(3, 1, 30, 20);
  const auto r = repair(m);
  REQUIRE(r);
  CHECK(r->mesh.V == m.V);
  CHECK(r->mesh.F == m.F);
  CHECK(r->findings.empty());

  SurfaceMesh bad = unwelded(ball());
  dropFace(bad, 7);
  std::swap(bad.F(3, 0), bad.F(3, 1));
  const auto once = repair(bad, {.holeRel = 0.15});
  checkWhole(once, volumeOf(ball()));
  const auto twice = repair(once->mesh);
  REQUIRE(twice);
  CHECK(twice->mesh.V == once->mesh.V);
  CHECK(twice->mesh.F == once->mesh.F);
  CHECK(twice->findings.empty());
}

TEST_CASE("certain faults are repaired, each is said") {
  SurfaceMesh m = ball();
  const double volume = volumeOf(m);
  SECTION("faces that share no vertices") {
    const auto r = repair(unwelded(m));
    checkWhole(r, volume);
    CHECK(r->mesh.V.rows() == m.V.rows());
    CHECK(repaired(*r, "duplicate-vertices"));
  }
  SECTION("cracks narrower than the tolerance") {
    SurfaceMesh cracked = unwelded(m);
    std::mt19937 random(4);
    std::uniform_real_distribution<double> shake(-3e-6, 3e-6);
    for (auto& x : cracked.V.reshaped()) x += shake(random);
    const auto r = repair(cracked);
    checkWhole(r, volume);
    CHECK(repaired(*r, "crack"));
    const auto strict = repair(cracked, {.weldRel = 0});
    REQUIRE(strict);
    CHECK_FALSE(checkSurface(strict->mesh).isSound());
  }
  SECTION("random faces turned over") {
    std::mt19937 random(5);
    for (Eigen::Index f = 0; f < m.F.rows(); ++f) {
      if (random() % 3 == 0) std::swap(m.F(f, 0), m.F(f, 2));
    }
    const auto r = repair(m);
    checkWhole(r, volume);
    CHECK(repaired(*r, "inconsistent-orientation"));
  }
  SECTION("inside out") {
    m.F.col(0).swap(m.F.col(1));
    const auto r = repair(m);
    checkWhole(r, volume);
    CHECK(repaired(*r, "inward"));
  }
  SECTION("some faces twice, some turned over as well, some collapsed") {
    addFace(m, m.F(0, 0), m.F(0, 1), m.F(0, 2));
    addFace(m, m.F(9, 2), m.F(9, 1), m.F(9, 0));
    addFace(m, m.F(9, 2), m.F(9, 1), m.F(9, 0));
    addFace(m, 3, 3, 5);
    const auto r = repair(m);
    checkWhole(r, volume);
    CHECK(repaired(*r, "duplicate-faces"));
    CHECK(repaired(*r, "degenerate-faces"));
    CHECK(r->mesh.F.rows() == m.F.rows() - 4);
  }
  SECTION("all faces twice, once for each side") {
    const SurfaceMesh once = m;
    for (Eigen::Index f = 0; f < once.F.rows(); ++f)
      addFace(m, once.F(f, 1), once.F(f, 0), once.F(f, 2));
    const auto r = repair(m);
    checkWhole(r, volume);
    CHECK(r->mesh.F.rows() == once.F.rows());
  }
  SECTION("a face without area between two others") {
    // The middle of an edge is a vertex on one side only; a flat triangle makes up for it
    SurfaceMesh box = test::box({0, 0, 0}, {1, 1, 1});
    box.V.conservativeResize(9, 3);
    box.V.row(8) = 0.5 * (box.V.row(1) + box.V.row(2));
    box.F.row(0) << 0, 2, 8;
    addFace(box, 0, 8, 1);
    addFace(box, 1, 8, 2);
    REQUIRE(checkSurface(box).degenerateFaces == 1);
    const auto r = repair(box);
    checkWhole(r, 1.0);
    CHECK(repaired(*r, "degenerate-faces"));
  }
  SECTION("small holes") {
    dropFace(m, 100);
    dropFace(m, 300);
    const auto r = repair(m, {.holeRel = 0.15});
    checkWhole(r, volume);
    CHECK(repaired(*r, "hole"));
    CHECK(r->mesh.V.rows() == m.V.rows());
  }
  SECTION("specks and stray faces") {
    m = joined({m, test::sphere({2, 0, 0}, 5e-4, 0), test::sphere({0, 2, 0}, 0.2, 1)}, "ball");
    addFace(m, 0, 50, 0);
    m.V.conservativeResize(m.V.rows() + 3, 3);
    m.V.bottomRows(3) << 3, 3, 3, 3.02, 3, 3, 3, 3.02, 3;
    const auto last = static_cast<std::int32_t>(m.V.rows());
    addFace(m, last - 3, last - 2, last - 1);
    m.parts.clear();
    const auto r = repair(m);
    REQUIRE(r);
    CHECK(checkSurface(r->mesh).components.size() == 2);
    CHECK(checkSurface(r->mesh).isSound());
    CHECK(repaired(*r, "speck"));
  }
  SECTION("two boxes put together share a wall: it goes") {
    // Faces of the wall match, corner by corner
    SurfaceMesh left = test::box({0, 0, 0}, {1, 1, 1});
    SurfaceMesh right = left;
    right.V.col(0) = 2.0 - right.V.col(0).array();  // mirrored, so that the walls are cut alike
    right.F.col(0).swap(right.F.col(1));
    const SurfaceMesh two = joined({left, right}, "two");
    checkWhole(repair(two), 2.0);  // two closed pieces that touch are sound
    const auto r = repair(weldExact(two));
    checkWhole(r, 2.0);
    CHECK(r->mesh.F.rows() == 20);
    CHECK(checkSurface(r->mesh).components.size() == 1);
  }
  SECTION("two boxes that share an edge or a corner come apart there") {
    for (const Vector3& shift : {Vector3(1, 1, 0), Vector3(1, 1, 1)}) {
      const SurfaceMesh two = joined(
          {test::box({0, 0, 0}, {1, 1, 1}), test::box(shift, shift + Vector3::Ones())}, "two");
      SurfaceMesh touching = two;
      for (auto& v : touching.F.reshaped()) {
        for (int w = 0; w < 8; ++w) {
          if (v >= 8 && two.V.row(v) == two.V.row(w)) v = w;
        }
      }
      REQUIRE_FALSE(checkSurface(touching).isSound());
      const auto r = repair(touching);
      checkWhole(r, 2.0);
      CHECK(repaired(*r, "non-manifold"));
    }
  }
}

TEST_CASE("pieces within pieces keep their sides: a tooth in a jaw, a cavity in a skull") {
  const SurfaceMesh outer = test::sphere({0, 0, 0}, 2, 2);
  SurfaceMesh inner = test::sphere({0.1, 0, 0}, 1, 2);
  const auto turnAll = [](SurfaceMesh m) {
    m.F.col(0).swap(m.F.col(1));
    return m;
  };
  const double tooth = volumeOf(outer) + volumeOf(inner);
  const double skull = volumeOf(outer) - volumeOf(inner);
  checkWhole(repair(joined({outer, inner}, "jaw")), tooth);
  checkWhole(repair(turnAll(joined({inner, outer}, "jaw"))), tooth);
  const auto cavity = repair(joined({outer, turnAll(inner)}, "skull"));
  checkWhole(cavity, skull);
  CHECK(std::ranges::any_of(cavity->findings, [](const Finding& f) { return f.kind == "cavity"; }));
  checkWhole(repair(turnAll(joined({turnAll(inner), outer}, "skull"))), skull);
  // Side by side each counts for itself
  checkWhole(repair(joined({outer, turnAll(test::sphere({9, 0, 0}, 1, 2))}, "pair")), tooth);
}

TEST_CASE("a large hole is an error for a skin, a warning for a bone, and its place is named") {
  SurfaceMesh m = test::sphere({0, 0, 0}, 1, 3);
  std::vector<Eigen::Index> top;
  for (Eigen::Index f = m.F.rows() - 1; f >= 0; --f) {
    if (m.V(m.F(f, 0), 2) > 0.8 && m.V(m.F(f, 1), 2) > 0.8 && m.V(m.F(f, 2), 2) > 0.8)
      dropFace(m, f);
  }
  m.name = "skin.obj";
  const auto skin = repair(m, {.mustClose = true});
  REQUIRE_FALSE(skin);
  CHECK(skin.error().code == ErrorCode::SkinNotClosed);
  CHECK_THAT(skin.error().text(), Catch::Contains("skin.obj"));
  REQUIRE(skin.error().place.point);
  CHECK(skin.error().place.point->z() > 0.7);
  CHECK(skin.error().place.point->head<2>().norm() < 0.1);

  const auto bone = repair(m);
  REQUIRE(bone);
  CHECK(std::ranges::any_of(bone->findings, [](const Finding& f) {
    return f.kind == "hole" && f.severity == Severity::Warning;
  }));
  CHECK(volumeOf(bone->mesh) > 0);
  // Inside out, it is still turned
  m.F.col(0).swap(m.F.col(1));
  CHECK(volumeOf(repair(m)->mesh) > 0);
}

TEST_CASE("nothing to repair, and vertices that are no numbers, are errors") {
  CHECK(repair(SurfaceMesh{}).error().code == ErrorCode::MeshWithoutFaces);
  SurfaceMesh m = ball();
  m.F.resize(1, 3);
  m.F << 3, 3, 4;
  CHECK(repair(m).error().code == ErrorCode::MeshWithoutFaces);
  m = ball();
  m.V(3, 1) = std::nan("");
  const auto nowhere = repair(m);
  CHECK(nowhere.error().code == ErrorCode::NonFiniteVertex);
  CHECK(nowhere.error().message.starts_with("\"sphere\": vertex 4 is ("));
  RunContext run;
  run.cancel();
  CHECK(repairSurface(unwelded(ball()), {}, run).error().code == ErrorCode::Cancelled);
}

TEST_CASE("parts survive repair, faces of filled holes belong to their neighbours") {
  SurfaceMesh m = joined({ball(), test::sphere({5, 0, 0}, 1, 3)}, "two");
  // A face goes from the second part
  m.F.row(700) = m.F.row(701).eval();
  const auto r = repair(m, {.holeRel = 0.2});
  REQUIRE(r);
  REQUIRE(r->mesh.parts.size() == 2);
  for (std::size_t p = 0; p < 2; ++p) {
    const SurfaceMesh part = partOf(r->mesh, p);
    CHECK(checkSurface(part).isSound());
    CHECK(part.V.rows() == ball().V.rows());
  }
  CHECK(r->mesh.parts[0].name == "sphere");
}

TEST_CASE("any damage to a surface is survived, and what is said to be sound is sound") {
  for (unsigned seed = 0; seed < 150; ++seed) {
    INFO("seed " << seed);
    std::mt19937 random(seed);
    SurfaceMesh m = seed % 2 == 0 ? test::sphere({0, 0, 0}, 1, 2) : test::torus(3, 1, 12, 9);
    if (seed % 5 == 0) m = joined({m, test::box({0.5, 0.5, 0.5}, {4, 4, 4})}, "m");
    const int blows = 1 + int(random() % 12);
    const auto face = [&] { return Eigen::Index(random() % std::size_t(m.F.rows())); };
    const auto vertex = [&] { return std::int32_t(random() % std::size_t(m.V.rows())); };
    for (int b = 0; b < blows; ++b) {
      switch (random() % 7) {
        case 0:
          dropFace(m, face());
          break;
        case 1:
          addFace(m, vertex(), vertex(), vertex());
          break;
        case 2:
          m.F(face(), Eigen::Index(random() % 3)) = vertex();
          break;
        case 3:
          m.V.row(vertex()) = m.V.row(vertex()).eval();
          break;
        case 4:
          std::swap(m.F(face(), 0), m.F(face(), 1));
          break;
        case 5:
          m = random() % 4 == 0 ? unwelded(m) : m;
          break;
        case 6: {
          const auto f = face();
          m.V.row(m.F(f, 0)) = 0.5 * (m.V.row(m.F(f, 1)) + m.V.row(m.F(f, 2)));
          break;
        }
      }
      m.parts.clear();
    }
    const auto r = repair(m, {.holeRel = 0.3});
    if (!r) {
      CHECK((r.error().code == ErrorCode::MeshNotRepairable ||
             r.error().code == ErrorCode::MeshWithoutFaces));
      continue;
    }
    const SurfaceCheck check = checkSurface(r->mesh);
    CHECK(check.nonManifoldEdges == 0);
    CHECK(check.nonManifoldVertices == 0);
    CHECK(check.inconsistentEdges == 0);
    const bool warned = std::ranges::any_of(
        r->findings, [](const Finding& f) { return f.severity == Severity::Warning; });
    CHECK(check.isSound() == !warned);
  }
}

TEST_CASE("a bag of doubled faces on the outside of a surface is not taken for a wall") {
  // A box; on one of its faces a tent of doubled triangles
  SurfaceMesh m = test::box({0, 0, 0}, {1, 1, 1});
  m.V.conservativeResize(9, 3);
  m.V.row(8) << 0.5, 0.5, 2;
  const std::int32_t top[4] = {4, 5, 7, 6};
  for (int k = 0; k < 4; ++k) {
    addFace(m, top[k], top[(k + 1) % 4], 8);
    addFace(m, top[(k + 1) % 4], top[k], 8);
  }
  const auto r = repair(m);
  REQUIRE(r);
  CHECK(boundingBox(r->mesh).hi.z() == 2);
  // Box and tent are one solid now: the face between them bounds nothing
  CHECK(repaired(*r, "inner-wall"));
  CHECK(volumeOf(r->mesh) == Approx(1.0 + 1.0 / 3.0));
}

TEST_CASE("walls inside go, however many there are and wherever they meet") {
  const auto all = [](int x, int y, int z) { return 1 + x + 100 * (y + 100 * z); };
  const RepairOptions skin{.mustClose = true};
  for (const auto& [nx, ny, nz] : {std::array{2, 1, 1}, {3, 1, 1}, {100, 1, 1}, {5, 4, 3}}) {
    INFO(nx << " × " << ny << " × " << nz);
    const auto r = repair(test::rooms(nx, ny, nz, all), skin);
    checkWhole(r, nx * ny * nz);
    CHECK(repaired(*r, "inner-wall"));
    CHECK(r->mesh.F.rows() == 4 * (nx * ny + ny * nz + nz * nx));
  }
  SECTION("inside out") {
    SurfaceMesh m = test::rooms(4, 2, 1, all);
    m.F.col(0).swap(m.F.col(1));
    checkWhole(repair(m, skin), 8);
  }
  SECTION("walls around a hollow; the hollow stays") {
    const auto shell = [&](int x, int y, int z) {
      return x == 1 && y == 1 && z == 1 ? 0 : all(x, y, z);
    };
    const auto r = repair(test::rooms(3, 3, 3, shell), skin);
    checkWhole(r, 26);
    CHECK(checkSurface(r->mesh).components.size() == 2);
  }
  SECTION("with a face missing in the skin, another in a wall") {
    SurfaceMesh m = test::rooms(12, 2, 2, [](int x, int, int) { return 1 + x / 4; });
    Eigen::Index outer = -1;
    Eigen::Index wall = -1;
    for (Eigen::Index f = 0; f < m.F.rows(); ++f) {
      const Vector3 middle =
          (m.V.row(m.F(f, 0)) + m.V.row(m.F(f, 1)) + m.V.row(m.F(f, 2))).transpose() / 3;
      if (middle.x() == 4) wall = f;
      if (middle.z() == 2 && middle.x() > 5 && middle.x() < 6) outer = f;
    }
    REQUIRE(wall >= 0);
    REQUIRE(outer >= 0);
    dropFace(m, std::max(outer, wall));
    dropFace(m, std::min(outer, wall));
    const auto r = repair(m, skin);
    checkWhole(r, 48);
    CHECK(repaired(*r, "hole"));
  }
  SECTION("where the skin itself looks both ways nothing goes") {
    SurfaceMesh m = test::rooms(3, 1, 1, all);
    for (Eigen::Index f = 0; f < m.F.rows(); ++f) {
      const auto x = [&](int k) { return m.V(m.F(f, k), 0); };
      if (std::max({x(0), x(1), x(2)}) <= 1 && std::min({x(0), x(1), x(2)}) < 1)
        std::swap(m.F(f, 0), m.F(f, 1));
    }
    const auto r = repair(m);
    REQUIRE(r);
    CHECK_FALSE(repaired(*r, "inner-wall"));
  }
}

TEST_CASE("a crack all around is told as one, with its width; a hole beside others is not") {
  // The upper half of a ball lifted off the lower one
  SurfaceMesh m = unwelded(ball());
  for (Eigen::Index f = 0; f < m.F.rows(); ++f) {
    double middle = 0.0;
    for (int k = 0; k < 3; ++k) middle += m.V(m.F(f, k), 2) / 3;
    if (middle > 0.3) {
      for (int k = 0; k < 3; ++k) m.V(m.F(f, k), 2) += 0.004;
    }
  }
  const auto cracked = repair(m, {.mustClose = true});
  REQUIRE_FALSE(cracked);
  CHECK(cracked.error().code == ErrorCode::SkinNotClosed);
  CHECK(cracked.error().message.find("up to 4 mm apart") != std::string::npos);
  CHECK(cracked.error().message.find("merge vertices by that distance") != std::string::npos);
  CHECK(cracked.error().message.find("fill-holes") == std::string::npos);

  SurfaceMesh open = joined({ball(), ball()}, "two");
  open.parts.clear();
  open.V.bottomRows(ball().V.rows()).col(0).array() += 5.0;
  Eigen::Index kept = 0;
  for (Eigen::Index f = 0; f < open.F.rows(); ++f) {
    if (open.V(open.F(f, 0), 2) < 0.9) open.F.row(kept++) = open.F.row(f).eval();
  }
  open.F.conservativeResize(kept, 3);
  const auto holes = repair(open, {.mustClose = true});
  REQUIRE_FALSE(holes);
  CHECK(holes.error().message.find("fill-holes") != std::string::npos);
}

TEST_CASE("twenty thousand pieces are told apart, and those inside out turned") {
  // Small pyramids on a grid: closed, closed and inside out, open
  constexpr int kSide = 27;
  const SurfaceMesh box = test::box({0, 0, 0}, {1, 1, 1});
  Triangles pyramid(4, 3);
  pyramid << 0, 2, 1, 0, 1, 4, 0, 4, 2, 1, 2, 4;
  SurfaceMesh m;
  m.name = "crowd";
  m.V.resize(8 * kSide * kSide * kSide, 3);
  m.F.resize(4 * kSide * kSide * kSide, 3);
  Eigen::Index faces = 0;
  double volume = 0.0;
  for (int i = 0; i < kSide * kSide * kSide; ++i) {
    const Vector3 at = 2.0 * Vector3(i % kSide, i / kSide % kSide, i / kSide / kSide);
    m.V.middleRows(8 * i, 8) = box.V.rowwise() + at.transpose();
    const int kind = i % 3;
    for (int f = 0; f < (kind == 2 ? 3 : 4); ++f) {
      m.F.row(faces) = pyramid.row(f).array() + 8 * i;
      if (kind == 1) std::swap(m.F(faces, 0), m.F(faces, 1));
      ++faces;
    }
    if (kind != 2) volume += 1.0 / 6.0;
  }
  m.F.conservativeResize(faces, 3);
  const auto r = repair(m, {.holeRel = 0});
  REQUIRE(r);
  CHECK(repaired(*r, "inward"));
  double closed = 0.0;
  for (const auto& piece : checkSurface(r->mesh).components) {
    CHECK_FALSE(piece.inward);
    if (piece.closed) closed += piece.volume;
  }
  CHECK(closed == Approx(volume));
}

TEST_CASE("cracks close although something lies far away") {
  // Far away makes the tolerance large; what decides is the length of the border's edges
  SurfaceMesh cracked = unwelded(test::sphere({0, 0, 0}, 1, 5));
  std::mt19937 random(4);
  std::uniform_real_distribution<double> shake(-3e-6, 3e-6);
  for (auto& x : cracked.V.reshaped()) x += shake(random);
  SurfaceMesh m = joined({cracked, test::box({1e5, 0, 0}, {1.00000001e5, 1, 1})}, "far");
  m.parts.clear();
  const auto r = repair(m, {.speckRel = 0});
  REQUIRE(r);
  CHECK(checkSurface(r->mesh).isSound());
  CHECK(checkSurface(r->mesh).components.size() == 2);
}

TEST_CASE("the dog's bones are repaired, doubled ones too, and lose nothing") {
  if (!test::haveData("dog")) return;
  RunContext run;
  std::vector<std::string> unsound;
  for (const auto& entry : std::filesystem::directory_iterator(test::dataFolder() / "dog/bones")) {
    const auto bone = readMesh(entry.path(), {}, run);
    REQUIRE(bone);
    const auto r = repair(*bone);
    INFO(entry.path());
    REQUIRE(r);
    if (!checkSurface(r->mesh).isSound()) unsound.push_back(bone->name);
    if (r->findings.empty()) continue;
    const SurfaceQuery after(r->mesh);
    double lost = 0;
    for (Eigen::Index v = 0; v < bone->V.rows(); ++v) {
      const Vector3 p = bone->V.row(v).transpose();
      const double distance = after.distance(p);
      if (distance > lost && !after.inside(p)) lost = distance;
    }
    CHECK(lost < 1e-3);
  }
  // Pieces of the ribcage are bags of doubled faces on others: what closes them is no certain
  // repair
  CHECK((unsound.empty() || unsound == std::vector<std::string>{"BONERibcage"}));
}
