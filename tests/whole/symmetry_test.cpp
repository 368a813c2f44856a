// A half model, cut at its plane of symmetry, is half of the whole.

#include <ecorche/engine/build.h>
#include <ecorche/model/project_file.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>

#include "support/small_project.h"

using namespace ecorche;
namespace fs = std::filesystem;

namespace {

/// Volume of every muscle by name, after the tets [m³].
std::map<std::string, double> volumesOf(const model::Project& project, std::int64_t tets) {
  RunContext run;
  const auto build = engine::build(project, {.tets = tets, .useCache = false}, run);
  if (!build) FAIL(build.error().text());
  std::map<std::string, double> out;
  for (std::size_t i = 0; i < build->tissues.size(); ++i)
    out[build->tissues[i].name] = build->measures[i + 1].volume;
  return out;
}

// Tissues on both sides of the plane are one in the whole
bool isHalved(const model::Tissue& inHalf, const model::Project& whole) {
  const model::Tissue& inWhole = whole.tissues[model::findTissue(whole, inHalf.name).value()];
  return inWhole.curves.size() > inHalf.curves.size() ||
         std::ranges::any_of(inHalf.curves, [](const model::Curve& c) {
           return c.start.on == model::Support::On::Plane || c.end.on == model::Support::On::Plane;
         });
}

void compare(const model::Project& half, const model::Project& whole, std::int64_t tets) {
  const auto inHalf = volumesOf(half, tets);
  const auto inWhole = volumesOf(whole, 2 * tets);
  for (const model::Tissue& tissue : half.tissues) {
    const double expected = inWhole.at(tissue.name) / (isHalved(tissue, whole) ? 2.0 : 1.0);
    const double off = inHalf.at(tissue.name) / expected - 1.0;
    INFO(tissue.name << ": " << 1e6 * inHalf.at(tissue.name) << " cm³, half of the whole has "
                     << 1e6 * expected);
    CHECK(std::abs(off) <= 0.02);
  }
}

model::Project load(const fs::path& file) {
  auto project = model::loadProject(file);
  if (!project) FAIL(project.error().text());
  return *project;
}

}  // namespace

TEST_CASE("half an egg is half of the egg, muscles across the plane too") {
  const test::SmallProject p;
  model::Project whole = load(p.at("limb.ecorche"));
  // One muscle with a head on each side, one that crosses. A muscle of one side alone would be
  // another thing: in the half it leans against its own image, in the whole against a rival
  model::Tissue& pair = whole.tissues[0];
  pair.curves[0].points = {
      {{0.005, 0.007, -0.05}, 1.0}, {{0, 0.026, 0}, 1.2}, {{-0.005, 0.007, 0.05}, 1.0}};
  pair.curves.push_back(pair.curves[0]);
  for (model::ControlPoint& point : pair.curves[1].points) point.at.y() *= -1.0;
  model::Curve& across = whole.tissues[1].curves[0];
  across.points = {
      {{0.03, -0.015, 0.02}, 1.0}, {{0.033, 0.0, 0.02}, 1.2}, {{0.03, 0.015, 0.02}, 1.0}};
  across.start = across.end = {};

  model::Project half = whole;
  half.cutPlanes.push_back(
      {"median", model::CutPlane::Kind::Symmetry, model::Vector3::Zero(), model::Vector3::UnitY()});
  half.tissues[0].curves.pop_back();
  model::Curve& cut = half.tissues[1].curves[0];
  cut.points.erase(cut.points.begin());
  cut.start = {model::Support::On::Plane, "median"};
  compare(half, whole, 40000);
}

TEST_CASE("half of the mirrored arms is half of them") {
  const fs::path arm = fs::path(ECORCHE_SOURCE_DIR) / "examples" / "arm";
  compare(load(arm / "arm-half.ecorche"), load(arm / "arm-mirrored.ecorche"), 320000);
}
