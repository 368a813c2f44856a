#include <ecorche/tissue/cross_section.h>
#include <ecorche/tissue/segmentation.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <numeric>

#include "support/generated_domain.h"

using namespace ecorche;
using namespace ecorche::tissue;
using mesh::Vector3;

TEST_CASE("of equal fields the lowest muscle wins and fat loses") {
  using Row = Eigen::RowVectorXd;
  CHECK(ownerOf(Row{{0.5, 0.5, 0.5}}, true) == TissueId(2));
  CHECK(ownerOf(Row{{0.5, 0.2, 0.5}}, true) == TissueId(3));
  CHECK(ownerOf(Row{{0.6, 0.2, 0.5}}, true) == kFat);
  CHECK(ownerOf(Row{{0.6, 0.2, 0.5}}, false) == TissueId(3));
  CHECK(ownerOf(Row{{0.0, 0.0, 0.0}}, false) == TissueId(2));
  CHECK(ownerOf(Row{{0.0}}, true) == kFat);
}

namespace {

TissueFields fieldsOf(const mesh::TetMesh& mesh,
                      const std::vector<std::function<double(const Vector3&)>>& f) {
  TissueFields out;
  out.values.resize(mesh.V.rows(), Eigen::Index(f.size()));
  for (Eigen::Index v = 0; v < mesh.V.rows(); ++v) {
    for (std::size_t i = 0; i < f.size(); ++i)
      out.values(v, Eigen::Index(i)) = f[i](mesh.V.row(v).transpose());
  }
  return out;
}

}  // namespace

TEST_CASE("volumes and cross-sections of linear fields are exact and add up") {
  test::Grid grid;
  grid.cells = {7, 6, 5};
  grid.jitter = 0.2;
  const mesh::TetMesh mesh = test::kuhnGrid(grid);
  // Three half-spaces: x < 0.37 is fat; of the rest, y > 0.52 is muscle 2, y < 0.52 muscle 3
  const auto fields = fieldsOf(mesh, {[](const Vector3& p) { return 10.0 * (0.37 - p.x()); },
                                      [](const Vector3& p) { return p.y() - 0.52; },
                                      [](const Vector3& p) { return 0.52 - p.y(); }});
  const auto volume = tissueVolumes(mesh, fields);
  // Fat where 10 (0.37 − x) > |y − 0.52|
  const double tilt = 0.1 * (0.5 * 0.52 * 0.52 + 0.5 * 0.48 * 0.48);
  CHECK(volume[0] == Approx(0.37 - tilt));
  CHECK(volume[1] == Approx(0.48 * 0.63 + 0.1 * 0.5 * 0.48 * 0.48));
  CHECK(volume[2] == Approx(0.52 * 0.63 + 0.1 * 0.5 * 0.52 * 0.52));
  CHECK(volume[0] + volume[1] + volume[2] == Approx(1.0).epsilon(1e-12));

  const auto area = crossSectionAreas(mesh, fields, TissueId(2), Vector3::Zero(), Vector3::UnitX(),
                                      {0.2, 0.5, 0.9});
  CHECK(area[0] == Approx(0.0).margin(1e-12));
  CHECK(area[1] == Approx(0.48));
  CHECK(area[2] == Approx(0.48));
}

TEST_CASE("fields that are equal everywhere leave no volume behind") {
  test::Grid grid;
  grid.cells = {3, 3, 3};
  const mesh::TetMesh mesh = test::kuhnGrid(grid);
  const auto half = [](const Vector3& p) { return p.x() - 0.4; };
  const auto fields = fieldsOf(mesh, {[](const Vector3&) { return 0.0; }, half, half});
  const auto volume = tissueVolumes(mesh, fields);
  CHECK(volume[0] == Approx(0.4));
  CHECK(volume[1] == Approx(0.6));
  CHECK(volume[2] == Approx(0.0).margin(1e-12));
}

TEST_CASE("fields that are all zero at the corners on skin cost no more than others") {
  // One tet whose first corner lies on skin: forty muscles are 0 there, and small elsewhere
  mesh::TetMesh mesh;
  mesh.V.resize(4, 3);
  mesh.V << 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1;
  mesh.T.resize(1, 4);
  mesh.T << 0, 1, 2, 3;
  TissueFields fields;
  fields.values.resize(4, 41);
  for (Eigen::Index i = 0; i < 41; ++i) {
    // In falling order everywhere but at the corner that all share: only fat and the first count
    const double f = std::pow(0.5, static_cast<double>(i));
    fields.values.col(i) << 0.0, f, 0.9 * f, 0.8 * f;
  }
  fields.values.col(0) << 0.3, 0.1, 0.1, 0.1;
  const auto volume = tissueVolumes(mesh, fields);
  CHECK(std::accumulate(volume.begin(), volume.end(), 0.0) == Approx(1.0 / 6.0).epsilon(1e-12));
  CHECK(volume[1] > 0.5 / 6.0);
  for (std::size_t i = 2; i < volume.size(); ++i) CHECK(volume[i] == 0.0);
}
