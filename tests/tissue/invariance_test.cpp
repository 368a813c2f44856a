#include <ecorche/core/parallel.h>
#include <ecorche/tissue/curve_trace.h>
#include <ecorche/tissue/segmentation.h>
#include <ecorche/tissue/tissue_solver.h>

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cstring>
#include <map>

#include "support/generated_domain.h"
#include "tissue/curves.h"

using namespace ecorche;
using namespace ecorche::tissue;
using domain::Domain;
using mesh::Vector3;
using test::muscle;

namespace {

Domain limb() { return test::cylinderDomain(1.0, 2.0, 14, 21); }

// Three muscles, one of two heads, one anisotropic, and a filler
std::vector<CurveTissue> threeTissues() {
  CurveTissue biceps = muscle("biceps", {{0.5, 0.1, 0.1}, {0.6, 0.0, 1.0}, {0.4, -0.1, 1.9}}, 1.2);
  biceps.curves.push_back(
      muscle("", {{0.3, 0.4, 0.1}, {0.45, 0.3, 1.0}, {0.4, 0.0, 1.8}}).curves[0]);
  CurveTissue triceps = muscle("triceps", {{-0.5, 0.1, 0.1}, {-0.6, -0.1, 1.0}, {-0.4, 0.1, 1.9}});
  triceps.curves[0].values = {0.6, 1.5, 0.6};
  triceps.anisotropy = {1.0, 0.4, 0.3};
  CurveTissue filler = muscle("belly", {{0.0, -0.5, 0.5}, {0.0, -0.5, 1.5}});
  filler.filler = true;
  return {biceps, triceps, filler};
}

std::vector<CurveTissue> movedTissues(std::vector<CurveTissue> list, const Eigen::Matrix3d& R,
                                      double scale, const Vector3& shift) {
  for (CurveTissue& t : list) {
    for (TissueCurve& c : t.curves) {
      std::vector<Vector3> points = c.spline.points();
      for (Vector3& p : points) p = scale * (R * p) + shift;
      c.spline = mesh::Spline(points);
    }
  }
  return list;
}

bool sameBytes(const FieldMatrix& a, const FieldMatrix& b) {
  return a.rows() == b.rows() && a.cols() == b.cols() &&
         std::memcmp(a.data(), b.data(), sizeof(double) * std::size_t(a.size())) == 0;
}

}  // namespace

TEST_CASE("a model 1024 times as large has the same fields to the last bit") {
  const Domain small = limb();
  const Domain large = test::moved(small, Eigen::Matrix3d::Identity(), 1024.0, Vector3::Zero());
  const auto a = test::solved(small, threeTissues());
  const auto b = test::solved(
      large, movedTissues(threeTissues(), Eigen::Matrix3d::Identity(), 1024.0, Vector3::Zero()));
  CHECK((a.values - b.values).cwiseAbs().maxCoeff() < 1e-12);
  const auto va = tissueVolumes(small.mesh, a);
  const auto vb = tissueVolumes(large.mesh, b);
  for (std::size_t i = 0; i < va.size(); ++i)
    CHECK(vb[i] / large.volume == Approx(va[i] / small.volume).epsilon(1e-12));
}

TEST_CASE("fields travel with a model that is turned and moved") {
  const Eigen::Matrix3d R =
      Eigen::AngleAxisd(1.1, Vector3(1, -2, 0.5).normalized()).toRotationMatrix();
  const Vector3 shift(3.0, -7.0, 2.0);
  const auto a = test::solved(limb(), threeTissues());
  const auto b =
      test::solved(test::moved(limb(), R, 1.0, shift), movedTissues(threeTissues(), R, 1.0, shift));
  CHECK((a.values - b.values).cwiseAbs().maxCoeff() < 1e-7);
}

TEST_CASE("permuting the muscles permutes the fields") {
  const auto list = threeTissues();
  const auto a = test::solved(limb(), list);
  const auto b = test::solved(limb(), {list[2], list[0], list[1]});
  CHECK((a.values.col(0) - b.values.col(0)).cwiseAbs().maxCoeff() < 1e-12);
  CHECK((a.values.col(1) - b.values.col(2)).cwiseAbs().maxCoeff() < 1e-12);
  CHECK((a.values.col(2) - b.values.col(3)).cwiseAbs().maxCoeff() < 1e-12);
  CHECK((a.values.col(3) - b.values.col(1)).cwiseAbs().maxCoeff() < 1e-12);
}

TEST_CASE("fields are linear in tissue values, and nobody else's") {
  auto list = threeTissues();
  list[1].curves[0].values = {1.0, 0.25, 0.5};
  const auto a = test::solved(limb(), list);
  list[1].curves[0].values = {0.5, 2.0, 1.0};
  const auto b = test::solved(limb(), list);
  list[1].curves[0].values = {2.5, 6.25, 3.5};  // a + 3 b
  const auto c = test::solved(limb(), list);
  CHECK((a.values.col(2) + 3.0 * b.values.col(2) - c.values.col(2)).cwiseAbs().maxCoeff() < 1e-11);
  CHECK((a.values.col(1) - c.values.col(1)).cwiseAbs().maxCoeff() < 1e-12);
  TissueOptions fatter;
  fatter.fat = 0.6;
  const auto d = test::solved(limb(), list, fatter);
  CHECK((d.values.col(0) - 2.0 * c.values.col(0)).cwiseAbs().maxCoeff() < 1e-12);
}

TEST_CASE("without fat, fat is no candidate and takes no volume") {
  TissueOptions options;
  options.fat = 0.0;
  const Domain domain = limb();
  const auto fields = test::solved(domain, threeTissues(), options);
  CHECK_FALSE(fields.fatIsCandidate);
  const auto volume = tissueVolumes(domain.mesh, fields);
  CHECK(volume[0] == 0.0);
  CHECK(volume[1] + volume[2] + volume[3] == Approx(domain.volume).epsilon(1e-9));
}

TEST_CASE("every muscle holds its own curves, and fields keep to their range on sound tets") {
  const Domain domain = limb();
  RunContext run;
  const auto cores = traceCurves(domain, threeTissues(), {}, run);
  REQUIRE(cores.has_value());
  const auto fields = solveTissueFields(domain, *cores, threeTissues(), {}, run);
  REQUIRE(fields.has_value());
  std::map<TissueId, double> inside;
  std::map<TissueId, double> total;
  for (const CoreSample& s : cores->samples) {
    total[s.tissue] += s.length;
    if (ownerAt(domain.mesh, *fields, s.tet, s.barycentric) == s.tissue)
      inside[s.tissue] += s.length;
  }
  CHECK(total.size() == threeTissues().size());
  for (const auto& [tissue, length] : total) CHECK(inside[tissue] > 0.95 * length);
  CHECK(fields->undershoot < 0.01);
  CHECK(fields->overshoot < 0.01);
  CHECK(fields->maxValue == 1.5);
  CHECK(fields->findings.empty());
}

TEST_CASE("the same bytes come out of every run, on one thread and on two") {
  const auto a = test::solved(limb(), threeTissues());
  for (const int threads : {1, 2, 1, 2}) {
    const ThreadLimit limit(threads);
    CHECK(sameBytes(a.values, test::solved(limb(), threeTissues()).values));
  }
}

TEST_CASE("a factor on all threads agrees to rounding") {
  const auto a = test::solved(limb(), threeTissues());
  const auto b = test::solved(limb(), threeTissues(), {.factorThreads = 0});
  CHECK((a.values - b.values).cwiseAbs().maxCoeff() < 1e-12);
}

TEST_CASE("a part of the domain that nothing holds is an error with its place") {
  // Two boxes apart; the second has bone all around
  test::Grid grid;
  grid.cells = {4, 4, 4};
  mesh::TetMesh mesh = test::kuhnGrid(grid);
  const auto vertexCount = std::int32_t(mesh.V.rows());
  mesh::TetMesh both;
  both.V.resize(2 * mesh.V.rows(), 3);
  both.V << mesh.V, mesh.V.rowwise() + Eigen::RowVector3d(5, 0, 0);
  both.T.resize(2 * mesh.T.rows(), 4);
  both.T << mesh.T, (mesh.T.array() + vertexCount).matrix();
  const Domain domain =
      test::domainOf(std::move(both), [](const Vector3& c, const Vector3&) -> domain::BoundaryTag {
        return {c.x() > 3.0 ? domain::BoundaryTag::Kind::Bone : domain::BoundaryTag::Kind::Skin, 0};
      });
  RunContext run;
  const std::vector<CurveTissue> one{muscle("m", {{0.2, 0.5, 0.5}, {0.8, 0.5, 0.5}})};
  const auto cores = traceCurves(domain, one, {}, run);
  REQUIRE(cores.has_value());
  const auto fields = solveTissueFields(domain, *cores, one, {}, run);
  REQUIRE_FALSE(fields.has_value());
  CHECK(fields.error().code == ErrorCode::ComponentWithoutSkin);
  REQUIRE(fields.error().place.point.has_value());
  CHECK(fields.error().place.point->x() >= 5.0);

  // A curve through it holds it
  const std::vector<CurveTissue> two{one[0], muscle("n", {{5.2, 0.5, 0.5}, {5.8, 0.5, 0.5}})};
  const auto held = test::solved(domain, two);
  CHECK(held.values.col(2).maxCoeff() == Approx(1.0).epsilon(1e-6));
}

TEST_CASE("slivers are capped and reported, and the rest of the field stays what it was") {
  Domain domain = limb();
  const auto before = test::solved(domain, threeTissues());
  // Flatten one tet away from the curves: pull a corner into the plane of the other three
  Eigen::Index t = 0;
  while (mesh::Vector3(domain.mesh.V(domain.mesh.T.row(t), Eigen::all).colwise().mean().transpose())
                 .head<2>()
                 .norm() > 0.2 ||
         domain.mesh.V(domain.mesh.T(t, 0), 2) < 0.9) {
    ++t;
  }
  const Vector3 flat =
      (domain.mesh.V.row(domain.mesh.T(t, 1)) + domain.mesh.V.row(domain.mesh.T(t, 2)) +
       domain.mesh.V.row(domain.mesh.T(t, 3)))
          .transpose() /
      3.0;
  domain.mesh.V.row(domain.mesh.T(t, 0)) = flat.transpose();
  const auto after = test::solved(domain, threeTissues());
  REQUIRE_FALSE(after.findings.empty());
  CHECK(after.findings[0].kind == "sliver-energy");
  CHECK(after.values.allFinite());
  CHECK((after.values - before.values).cwiseAbs().maxCoeff() < 0.3);
}

TEST_CASE("cancelled before or while solving, the answer is Cancelled") {
  const Domain domain = limb();
  RunContext calm;
  const auto cores = traceCurves(domain, threeTissues(), {}, calm);
  REQUIRE(cores.has_value());
  RunContext* running = nullptr;
  RunContext run([&](std::string_view stage, double fraction) {
    if (stage == "tissue fields" && fraction >= 0.5) running->cancel();
  });
  running = &run;
  const auto fields = solveTissueFields(domain, *cores, threeTissues(), {}, run);
  REQUIRE_FALSE(fields.has_value());
  CHECK(fields.error().code == ErrorCode::Cancelled);
  RunContext before;
  before.cancel();
  const auto none = TissueSolver::create(domain, before);
  REQUIRE_FALSE(none.has_value());
  CHECK(none.error().code == ErrorCode::Cancelled);
}

TEST_CASE("curves traced from what is kept are those traced afresh, to the last bit") {
  const Domain domain = limb();
  const CurveWalker walker(domain);
  RunContext run;
  KeptTraces kept;
  auto list = threeTissues();
  TissueOptions options;
  const auto same = [](const CoreSamples& a, const CoreSamples& b) {
    REQUIRE(a.samples.size() == b.samples.size());
    REQUIRE(a.nearCurves.size() == b.nearCurves.size());
    for (std::size_t i = 0; i < a.samples.size(); ++i) {
      const CoreSample &p = a.samples[i], &q = b.samples[i];
      CHECK((p.tissue == q.tissue && p.curve == q.curve && p.tet == q.tet && p.u == q.u &&
             p.weight == q.weight && p.barycentric == q.barycentric && p.length == q.length));
    }
    for (std::size_t i = 0; i < a.nearCurves.size(); ++i) {
      const NearCurve &p = a.nearCurves[i], &q = b.nearCurves[i];
      CHECK((p.vertex == q.vertex && p.sample == q.sample && p.error == q.error));
    }
    CHECK(a.coveredShare == b.coveredShare);
    CHECK(a.findings.size() == b.findings.size());
  };
  const auto check = [&] {
    same(traceCurves(walker, domain, list, options, run, kept).value(),
         traceCurves(walker, domain, list, options, run).value());
  };
  check();
  check();
  // A head moved, tissues in another order, one gone, another core
  std::vector<Vector3> points = list[0].curves[1].spline.points();
  points[1].x() += 0.02;
  list[0].curves[1].spline = mesh::Spline(points);
  check();
  std::swap(list[0], list[2]);
  check();
  list.erase(list.begin() + 1);
  check();
  list[0].coreRadius = 0.01;
  check();
  options.alpha = 5.0;
  check();
  // A curve at fault is told each time, and the next right one is taken
  const auto right = list;
  list[0].curves[0].spline = mesh::Spline({{5, 5, 5}, {6, 6, 6}});
  list[0].curves[0].values = {1.0, 1.0};
  for (int k = 0; k < 2; ++k) {
    const auto wrong = traceCurves(walker, domain, list, options, run, kept);
    REQUIRE_FALSE(wrong);
    CHECK(wrong.error().code == ErrorCode::CurveOutsideDomain);
  }
  list = right;
  check();
}
