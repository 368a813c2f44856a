#include "exchange/sample_output.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

namespace ecorche::test {

using mesh::Vector3;

mesh::SurfaceMesh surfaceOfLabel(const envelope::Anatomy& anatomy, TissueId id, std::string name) {
  std::vector<std::array<std::int32_t, 3>> faces;
  for (Eigen::Index t = 0; t < anatomy.mesh.T.rows(); ++t) {
    if (anatomy.label[static_cast<std::size_t>(t)] != id) continue;
    for (int k = 0; k < 4; ++k) {
      const std::int32_t n = anatomy.neighbours(t, k);
      if (n >= 0 && anatomy.label[static_cast<std::size_t>(n)] == id) continue;
      faces.push_back({anatomy.mesh.T(t, mesh::kTetFace[k][0]),
                       anatomy.mesh.T(t, mesh::kTetFace[k][1]),
                       anatomy.mesh.T(t, mesh::kTetFace[k][2])});
    }
  }
  mesh::SurfaceMesh surface;
  surface.name = std::move(name);
  surface.V = anatomy.mesh.V;
  surface.F.resize(static_cast<Eigen::Index>(faces.size()), 3);
  for (std::size_t f = 0; f < faces.size(); ++f) {
    for (std::size_t c = 0; c < 3; ++c)
      surface.F(static_cast<Eigen::Index>(f), static_cast<Eigen::Index>(c)) = faces[f][c];
  }
  return mesh::compacted(surface);
}

namespace {

// A plate under or over the limb that touches it with one face.
mesh::SurfaceMesh plate(std::string name, double z0, double z1) {
  ShapeRecipe recipe;
  recipe.cells = {2, 2, 1};
  recipe.map = [=](const Vector3& g) {
    return Vector3(0.1 * (g.x() - 0.5), 0.1 * (g.y() - 0.5), z0 + (z1 - z0) * g.z());
  };
  return surfaceOfLabel(makeShape(recipe).anatomy, kFirstMuscle, std::move(name));
}

}  // namespace

SampleOutput makeSample(const std::string& firstName, std::array<int, 3> cells) {
  ShapeRecipe recipe;
  recipe.cells = cells;
  recipe.map = [](const Vector3& g) {
    // Irrational steps: coordinates that no short decimal holds
    Vector3 p = 0.03 * roundedSection(g);
    p.z() = 0.2 * std::pow(g.z(), 1.0001);
    return p;
  };
  recipe.label = [](const Vector3& g) {
    const double x = 2.0 * g.x() - 1.0;
    const double y = 2.0 * g.y() - 1.0;
    if (std::max(std::abs(x), std::abs(y)) > 0.8) return kFat;
    return TissueId{x < 0.0 ? 2 : 3};
  };
  SampleOutput s;
  s.shape = makeShape(recipe);
  s.tissues = {
      muscleAlong(firstName, {{-0.01, 0, 0}, {-0.011, 0, 0.1}, {-0.01, 0, 0.2}}),
      muscleAlong("triceps <lateral> & \"long\"", {{0.01, 0, 0}, {0.011, 0, 0.1}, {0.01, 0, 0.2}})};
  RunContext run;
  auto fibers = fiber::computeFibers(s.shape.anatomy, s.shape.domain, s.tissues,
                                     {boneToBone(), boneToBone()}, {}, run);
  REQUIRE(fibers);
  s.fibers = std::move(*fibers);
  s.surfaces.push_back(surfaceOfLabel(s.shape.anatomy, kFat, "fat"));
  for (std::size_t i = 0; i < s.tissues.size(); ++i) {
    s.surfaces.push_back(surfaceOfLabel(s.shape.anatomy, TissueId{2 + static_cast<std::int64_t>(i)},
                                        s.tissues[i].name));
  }
  s.skin.name = "skin";
  s.skin.V = s.shape.anatomy.mesh.V;
  s.skin.F = s.shape.anatomy.boundaryF;
  s.skin = mesh::compacted(s.skin);
  s.bones = {plate("lower plate", -0.02, 0.0), plate("upper plate", 0.2, 0.22)};
  return s;
}

exchange::WrittenOutput writeSample(const SampleOutput& sample, const std::filesystem::path& folder,
                                    const exchange::OutputFormats& formats) {
  std::filesystem::create_directories(folder);
  SampleOutput copy = sample;
  copy.originals = {{"skin", "skin", &copy.skin},
                    {"lower plate", "bone", &copy.bones[0]},
                    {"upper plate", "bone", &copy.bones[1]}};
  RunContext run;
  auto written = exchange::writeOutput(folder, copy.contents(), formats, run);
  INFO((written ? "" : written.error().text()));
  REQUIRE(written);
  return *written;
}

}  // namespace ecorche::test
