#include <ecorche/mesh/operators.h>
#include <ecorche/tissue/curve_trace.h>

#include <catch2/catch.hpp>
#include <random>

#include "support/generated_domain.h"
#include "tissue/curves.h"

using namespace ecorche;
using namespace ecorche::tissue;
using domain::BoundaryTag;
using domain::Domain;
using mesh::Vector3;
using test::muscle;

namespace {

Domain box(int cells = 10, double jitter = 0.2) {
  test::Grid grid;
  grid.cells = {cells, cells, cells};
  grid.jitter = jitter;
  return test::boxDomain(grid);
}

// The unit box with a slab of bone taken out: 0.4 < x < 0.6, 0 < y < 0.8
Domain boxWithBone() {
  test::Grid grid;
  grid.cells = {20, 10, 10};
  mesh::TetMesh mesh = test::kuhnGrid(grid);
  std::vector<Eigen::Index> kept;
  for (Eigen::Index t = 0; t < mesh.T.rows(); ++t) {
    const Vector3 c = mesh.V(mesh.T.row(t), Eigen::all).colwise().mean().transpose();
    if (!(c.x() > 0.4 && c.x() < 0.6 && c.y() < 0.8)) kept.push_back(t);
  }
  mesh.T = mesh::Tets(mesh.T(kept, Eigen::all));
  Domain out = test::domainOf(std::move(mesh), [](const Vector3& c, const Vector3&) -> BoundaryTag {
    const bool inner =
        c.x() > 0.3 && c.x() < 0.7 && c.y() > 0.01 && c.y() < 0.99 && c.z() > 0.01 && c.z() < 0.99;
    return {inner ? BoundaryTag::Kind::Bone : BoundaryTag::Kind::Skin, 0};
  });
  out.boneNames = {"slab"};
  return out;
}

double tracedLength(const CoreSamples& cores) {
  double sum = 0.0;
  for (const CoreSample& s : cores.samples) sum += s.length;
  return sum;
}

Vector3 pointOf(const Domain& domain, const CoreSample& s) {
  Vector3 p = Vector3::Zero();
  for (int k = 0; k < 4; ++k)
    p += s.barycentric[k] * domain.mesh.V.row(domain.mesh.T(s.tet, k)).transpose();
  return p;
}

Error errorOf(const Domain& domain, const std::vector<CurveTissue>& tissues) {
  RunContext run;
  const auto cores = traceCurves(domain, tissues, {}, run);
  REQUIRE_FALSE(cores.has_value());
  return cores.error();
}

}  // namespace

TEST_CASE("pieces of a curve add up to its length and lie in their tets") {
  const Domain domain = box();
  std::mt19937_64 random(4);
  std::uniform_real_distribution<double> unit(0.05, 0.95);
  for (int round = 0; round < 200; ++round) {
    std::vector<Vector3> points;
    for (int k = 0; k < 2 + round % 4; ++k)
      points.emplace_back(unit(random), unit(random), unit(random));
    INFO("round " << round);
    const CurveTissue m = muscle("m", points);
    RunContext run;
    const auto cores = traceCurves(domain, {m}, {}, run);
    if (!cores.has_value()) {  // a bend may swing out of the box
      REQUIRE(cores.error().code == ErrorCode::CurveOutsideSkin);
      continue;
    }
    // Bends as sharp as cusps are measured to six digits
    REQUIRE(tracedLength(*cores) ==
            Approx(m.curves[0].spline.length() * cores->coveredShare[0]).epsilon(1e-6));
    double before = -1.0;
    for (const CoreSample& s : cores->samples) {
      REQUIRE(s.u > before);
      before = s.u;
      REQUIRE(s.barycentric.minCoeff() >= 0.0);
      REQUIRE((pointOf(domain, s) - m.curves[0].spline.at(s.u)).norm() <
              5e-3);  // a twentieth of an edge, in the sharpest bends
    }
  }
}

TEST_CASE("a curve along grid lines, through vertices and edges, is covered once") {
  const Domain domain = box(8, 0.0);
  for (const auto& ends : std::vector<std::pair<Vector3, Vector3>>{
           {{0.125, 0.5, 0.5}, {0.875, 0.5, 0.5}},
           {{0.125, 0.125, 0.125}, {0.875, 0.875, 0.875}},
           {{0.125, 0.125, 0.5}, {0.875, 0.875, 0.5}},
           {{0.125, 0.25, 0.5}, {0.875, 0.625, 0.75}},
           {{0.0, 0.0, 0.0}, {1.0, 1.0, 1.0}},
           {{0.0, 0.0, 0.5}, {0.0, 1.0, 0.5}}}) {  // in the skin itself
    const CurveTissue m = muscle("m", {ends.first, ends.second});
    RunContext run;
    const auto cores = traceCurves(domain, {m}, {}, run);
    REQUIRE(cores.has_value());
    CHECK(tracedLength(*cores) == Approx((ends.second - ends.first).norm()).epsilon(1e-9));
    CHECK(cores->coveredShare[0] == Approx(1.0).epsilon(1e-9));
  }
}

TEST_CASE("a curve through bone loses what lies in it, and says so") {
  const Domain domain = boxWithBone();
  const CurveTissue m = muscle("vastus", {{0.1, 0.42, 0.53}, {0.9, 0.42, 0.53}});
  RunContext run;
  const auto cores = traceCurves(domain, {m}, {}, run);
  REQUIRE(cores.has_value());
  CHECK(cores->coveredShare[0] == Approx(0.75).epsilon(1e-6));
  CHECK(tracedLength(*cores) == Approx(0.6).epsilon(1e-6));
  REQUIRE(cores->findings.size() == 1);
  CHECK(cores->findings[0].severity == Severity::Warning);
  CHECK(cores->findings[0].object == "vastus");
  CHECK(cores->findings[0].size == Approx(0.2).epsilon(1e-6));
  CHECK(cores->findings[0].message.find("slab") != std::string::npos);
}

TEST_CASE("an end inside bone is how muscles attach") {
  const Domain domain = boxWithBone();
  RunContext run;
  const auto cores =
      traceCurves(domain, {muscle("m", {{0.5, 0.4, 0.5}, {0.95, 0.4, 0.5}})}, {}, run);
  REQUIRE(cores.has_value());
  CHECK(cores->coveredShare[0] == Approx(0.35 / 0.45).epsilon(1e-6));
}

TEST_CASE("an end within the tolerance outside the skin is taken") {
  const Domain domain = box();
  RunContext run;
  const double out = 0.9 * kOutsideTolerance * domain.skinDiagonal;
  const auto cores =
      traceCurves(domain, {muscle("m", {{-out, 0.4, 0.5}, {0.95, 0.4, 0.5}})}, {}, run);
  REQUIRE(cores.has_value());
  CHECK(cores->coveredShare[0] == Approx(0.95 / (0.95 + out)).epsilon(1e-6));
}

TEST_CASE("a curve that leaves the skin is an error that names muscle, curve and point") {
  const Domain domain = box();
  CurveTissue m = muscle("gracilis", {{0.2, 0.5, 0.5}, {0.5, 0.5, 1.2}, {0.8, 0.5, 0.5}});
  m.curves[0].name = "front";
  const Error error = errorOf(domain, {m});
  CHECK(error.code == ErrorCode::CurveOutsideSkin);
  CHECK(error.message.find("gracilis") != std::string::npos);
  CHECK(error.message.find("front") != std::string::npos);
  REQUIRE(error.place.point.has_value());
  CHECK(error.place.point->z() > 1.15);
  CHECK(errorOf(domain, {muscle("m", {{0.5, 0.5, 0.5}, {0.5, 0.5, 1.05}})}).code ==
        ErrorCode::CurveOutsideSkin);
  CHECK(errorOf(domain, {muscle("m", {{0.5, -0.05, 0.5}, {0.5, 0.5, 0.5}})}).code ==
        ErrorCode::CurveOutsideSkin);
}

TEST_CASE("behind a cut plane a curve is lost, not wrong") {
  test::Grid grid;
  const Domain domain =
      test::domainOf(test::kuhnGrid(grid), [](const Vector3& c, const Vector3&) -> BoundaryTag {
        return {c.y() < 1e-9 ? BoundaryTag::Kind::CutPlane : BoundaryTag::Kind::Skin, 0};
      });
  RunContext run;
  const auto cores =
      traceCurves(domain, {muscle("m", {{0.5, -0.5, 0.5}, {0.5, 0.5, 0.5}})}, {}, run);
  REQUIRE(cores.has_value());
  CHECK(cores->coveredShare[0] == Approx(0.5).epsilon(1e-6));
}

TEST_CASE("curves that cannot be traced have their own errors") {
  const Domain domain = box();
  CHECK(errorOf(domain, {muscle("m", {{2.0, 0.5, 0.5}, {3.0, 0.5, 0.5}})}).code ==
        ErrorCode::CurveOutsideDomain);
  CurveTissue none;
  none.name = "soleus";
  const Error error = errorOf(domain, {none});
  CHECK(error.code == ErrorCode::MuscleWithoutCurve);
  CHECK(error.message.find("soleus") != std::string::npos);
  CurveTissue empty;
  empty.name = "m";
  empty.curves.emplace_back();
  CHECK(errorOf(domain, {empty}).code == ErrorCode::ZeroLengthCurve);
}

TEST_CASE("a cancelled trace stops with Cancelled") {
  RunContext run;
  run.cancel();
  const auto cores = traceCurves(box(), {muscle("m", {{0.1, 0.5, 0.5}, {0.9, 0.5, 0.5}})}, {}, run);
  REQUIRE_FALSE(cores.has_value());
  CHECK(cores.error().code == ErrorCode::Cancelled);
}

TEST_CASE("where tets are finer than the core, rows spread over its rim and keep the length") {
  const Domain domain = box(20);
  RunContext run;
  TissueOptions options;
  options.coreRadius = 0.08;
  const CurveTissue m = muscle("m", {{0.2, 0.5, 0.5}, {0.8, 0.55, 0.45}});
  const auto cores = traceCurves(domain, {m}, options, run);
  REQUIRE(cores.has_value());
  CHECK(tracedLength(*cores) == Approx(m.curves[0].spline.length()).epsilon(1e-9));
  for (const CoreSample& s : cores->samples) {
    REQUIRE((pointOf(domain, s) - m.curves[0].spline.at(s.u)).norm() == Approx(0.08));
  }
}
