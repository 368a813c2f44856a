#include <ecorche/mesh/read_mesh.h>
#include <ecorche/mesh/surface_check.h>
#include <ecorche/mesh/surface_query.h>
#include <ecorche/model/project_file.h>

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <numbers>
#include <tuple>

#include "support/paths.h"

namespace ecorche {
namespace {

using mesh::SurfaceMesh;

std::filesystem::path exampleFolder() {
  return std::filesystem::path(ECORCHE_SOURCE_DIR) / "examples";
}

// Faces of one part, or the whole mesh where no part is named.
SurfaceMesh partOf(const SurfaceMesh& whole, const std::string& name) {
  if (name.empty()) return whole;
  for (const mesh::Part& part : whole.parts) {
    if (part.name != name) continue;
    return mesh::compacted({name, whole.V, whole.F.middleRows(part.firstFace, part.faceCount), {}});
  }
  FAIL("no part " << name);
  return {};
}

struct Example {
  model::Project project;
  SurfaceMesh skin;
  std::map<std::string, SurfaceMesh> bones;
};

Example load(const std::filesystem::path& file) {
  RunContext run;
  auto project = model::loadProject(file);
  if (!project) FAIL(project.error().text());
  Example example{*project, {}, {}};

  std::map<std::filesystem::path, SurfaceMesh> files;
  auto surface = [&](const model::MeshRef& ref) {
    const auto path = model::meshPath(*project, ref);
    if (!files.contains(path)) {
      auto read = mesh::readMesh(path, {.metresPerUnit = model::metresPerUnit(*project, ref)}, run);
      if (!read) FAIL(read.error().text());
      files[path] = *read;
    }
    return partOf(files[path], ref.part);
  };
  example.skin = surface(project->skin);
  for (const model::Bone& bone : project->bones) example.bones[bone.name] = surface(bone.mesh);
  return example;
}

// A project on the dog, with meshes from where script/fetch-dog would copy them.
Example loadDog(const char* name) {
  auto project = model::loadProject(exampleFolder() / "dog" / name);
  if (!project) FAIL(project.error().text());
  RunContext run;
  Example example{*project, {}, {}};
  auto read = [&](const std::filesystem::path& file) {
    auto surface = mesh::readMesh(file, {}, run);
    if (!surface) FAIL(surface.error().text());
    return *surface;
  };
  example.skin = read(test::dataFolder() / "dog" / "SKINbody.stl");
  for (const model::Bone& bone : project->bones) {
    const auto file = std::filesystem::path(bone.mesh.file).filename();
    example.bones[bone.name] = read(test::dataFolder() / "dog" / "bones" / file);
  }
  return example;
}

std::vector<std::filesystem::path> shippedProjects() {
  std::vector<std::filesystem::path> found;
  for (const char* folder : {"arm", "architectures"})
    for (const auto& entry : std::filesystem::directory_iterator(exampleFolder() / folder))
      if (entry.path().extension() == ".ecorche") found.push_back(entry.path());
  std::sort(found.begin(), found.end());
  return found;
}

// One closed piece that faces outward and does not cut itself.
void requireSound(const SurfaceMesh& surface, const std::string& name) {
  INFO(name);
  const auto check = mesh::checkSurface(surface, {.selfIntersections = true});
  CHECK(check.isSound());
  CHECK(check.selfIntersections == 0);
  REQUIRE(check.components.size() == 1);
  CHECK_FALSE(check.components[0].inward);
}

// Smallest distance from the vertices of `from` to `to`; negative where one of them is inside.
double roomBetween(const SurfaceMesh& from, const mesh::SurfaceQuery& to, const mesh::Box& toBox) {
  double room = 1.0;
  for (Eigen::Index v = 0; v < from.V.rows(); ++v) {
    const mesh::Vector3 p = from.V.row(v);
    if (((p - toBox.hi).array() > 0.01).any() || ((toBox.lo - p).array() > 0.01).any()) continue;
    room = std::min(room, to.signedDistance(p));
  }
  return room;
}

struct CurveChecks {
  double bone = 0.0015;  ///< least distance to any bone away from the ends [m]
  double skin = 0.002;   ///< least depth below the skin away from the ends [m]
};

// Ends on their bones; in between inside the skin and outside every bone.
void checkCurves(const Example& example, const CurveChecks& checks) {
  const mesh::SurfaceQuery skin(example.skin);
  std::map<std::string, mesh::SurfaceQuery> bones;
  std::map<std::string, mesh::Box> boxes;
  for (const auto& [name, surface] : example.bones) {
    bones.emplace(name, mesh::SurfaceQuery(surface));
    boxes[name] = mesh::boundingBox(surface);
  }

  for (const model::Tissue& tissue : example.project.tissues) {
    for (std::size_t c = 0; c < tissue.curves.size(); ++c) {
      const model::Curve& curve = tissue.curves[c];
      INFO(model::curveLabel(tissue, c));
      for (const auto& [support, at] : {std::pair(curve.start, curve.points.front().at),
                                        std::pair(curve.end, curve.points.back().at)}) {
        if (support.on == model::Support::On::Bone)
          CHECK(bones.at(support.name).distance(at) < 0.001);
      }

      // No fibre can follow a curve that doubles back
      for (std::size_t k = 1; k + 1 < curve.points.size(); ++k) {
        const mesh::Vector3 before = (curve.points[k].at - curve.points[k - 1].at).normalized();
        const mesh::Vector3 after = (curve.points[k + 1].at - curve.points[k].at).normalized();
        CHECK(before.dot(after) > std::cos(115.0 * std::numbers::pi / 180.0));
      }

      const mesh::Spline spline = model::splineOf(curve);
      CHECK(spline.length() > 0.005);
      for (double u : spline.sample(0.002).u) {
        const mesh::Vector3 p = spline.at(u);
        const double fromEnd = std::min(spline.lengthTo(u), spline.length() - spline.lengthTo(u));
        const bool inner = fromEnd > 0.010;
        const double depth = -skin.signedDistance(p);
        if (depth < (inner ? checks.skin : 0.0)) CHECK(depth >= (inner ? checks.skin : 0.0));
        if (fromEnd < 0.003) continue;
        for (const auto& [name, query] : bones) {
          if (((p - boxes[name].hi).array() > 0.01).any()) continue;
          if (((boxes[name].lo - p).array() > 0.01).any()) continue;
          const double room = query.signedDistance(p);
          const double wanted = inner ? checks.bone : -0.0003;
          if (room < wanted) {
            INFO(name << ", " << 1000 * fromEnd << " mm from the end");
            CHECK(room >= wanted);
          }
        }
      }
    }
  }
}

}  // namespace

TEST_CASE("meshes of shipped examples are closed, clean and apart from one another") {
  for (const auto& file : shippedProjects()) {
    INFO(file.filename());
    const Example example = load(file);
    requireSound(example.skin, "skin");
    const mesh::SurfaceQuery skin(example.skin);
    for (const auto& [name, bone] : example.bones) {
      requireSound(bone, name);
      double deepest = 1.0;
      for (Eigen::Index v = 0; v < bone.V.rows(); ++v)
        deepest = std::min(deepest, -skin.signedDistance(bone.V.row(v)));
      INFO(name);
      CHECK(deepest > 0.002);
      const mesh::SurfaceQuery query(bone);
      const mesh::Box box = mesh::boundingBox(bone);
      for (const auto& [otherName, other] : example.bones) {
        if (otherName == name) continue;
        INFO(otherName);
        CHECK(roomBetween(other, query, box) > 0.001);
      }
    }
  }
}

TEST_CASE("curves of shipped examples start and end on bone and run between skin and bones") {
  for (const auto& file : shippedProjects()) {
    INFO(file.filename());
    checkCurves(load(file), {});
  }
}

TEST_CASE("the arm is what it says") {
  const auto arm = model::loadProject(exampleFolder() / "arm" / "arm.ecorche");
  REQUIRE(arm);
  auto heads = [&](const char* name) {
    const auto tissue = model::findTissue(*arm, name);
    REQUIRE(tissue);
    return arm->tissues[*tissue].curves.size();
  };
  CHECK(arm->tissues.size() >= 14);
  CHECK(heads("biceps_brachii") == 2);
  CHECK(heads("triceps_brachii") == 3);
  CHECK(heads("deltoid") == 3);
  CHECK(std::any_of(arm->tissues.begin(), arm->tissues.end(), [](const model::Tissue& tissue) {
    return tissue.anisotropy.lambda2 != tissue.anisotropy.lambda3;
  }));
}

TEST_CASE("the mirrored arm is symmetric, its half is half of it") {
  const Example whole = load(exampleFolder() / "arm" / "arm-mirrored.ecorche");
  const auto half = model::loadProject(exampleFolder() / "arm" / "arm-half.ecorche");
  REQUIRE(half);
  CHECK(half->skin == whole.project.skin);

  // Every vertex of the skin has its mirror image, to the last digit
  std::vector<std::array<double, 3>> left, right;
  for (Eigen::Index v = 0; v < whole.skin.V.rows(); ++v) {
    const mesh::Vector3 p = whole.skin.V.row(v);
    left.push_back({p.x(), p.y(), p.z()});
    right.push_back({p.x(), p.y() == 0.0 ? 0.0 : -p.y(), p.z()});
  }
  std::sort(left.begin(), left.end());
  std::sort(right.begin(), right.end());
  CHECK(left == right);

  // A muscle that crosses the plane is the half's curve and its image
  for (const model::Tissue& tissue : half->tissues) {
    const auto place = model::findTissue(whole.project, tissue.name);
    REQUIRE(place);
    const model::Tissue& full = whole.project.tissues[*place];
    for (std::size_t c = 0; c < tissue.curves.size(); ++c) {
      if (tissue.curves[c].start.on != model::Support::On::Plane) {
        CHECK(full.curves[c] == tissue.curves[c]);
        continue;
      }
      const mesh::Spline ending = model::splineOf(tissue.curves[c]);
      const mesh::Spline through = model::splineOf(full.curves[c]);
      INFO(model::curveLabel(full, c));
      CHECK(through.length() == Approx(2 * ending.length()).epsilon(1e-6));
      const double middle = 0.5 * through.lastParameter();
      CHECK((through.at(middle + 0.5) - ending.at(0.5)).norm() < 1e-6);
    }
  }
}

TEST_CASE("curves of the hind limb start and end on bone and run between skin and bones") {
  if (!test::haveData("dog")) return;
  const Example example = loadDog("hind-limb.ecorche");
  CHECK(example.project.tissues.size() >= 24);
  checkCurves(example, {.bone = 0.001, .skin = 0.002});
}

TEST_CASE("the projects to measure on are what they say, with curves from bone to bone") {
  if (!test::haveData("dog")) return;
  for (const auto& [name, muscles, planes] :
       {std::tuple("left-39.ecorche", 39, 1), {"bench-150.ecorche", 150, 0}}) {
    INFO(name);
    const Example example = loadDog(name);
    const model::Project& project = example.project;
    CHECK(static_cast<int>(project.tissues.size()) == muscles);
    CHECK(static_cast<int>(project.cutPlanes.size()) == planes);
    CHECK(project.bones.size() == 172);

    const mesh::SurfaceQuery skin(example.skin);
    std::map<std::string, mesh::SurfaceQuery> bones;
    std::map<std::string, mesh::Box> boxes;
    for (const auto& [bone, surface] : example.bones) {
      bones.emplace(bone, mesh::SurfaceQuery(surface));
      boxes[bone] = mesh::boundingBox(surface);
    }
    for (const model::Tissue& tissue : project.tissues) {
      CHECK(tissue.kind == model::Tissue::Kind::Muscle);
      for (std::size_t c = 0; c < tissue.curves.size(); ++c) {
        const model::Curve& curve = tissue.curves[c];
        INFO(model::curveLabel(tissue, c));
        for (const auto& [support, at] : {std::pair(curve.start, curve.points.front().at),
                                          std::pair(curve.end, curve.points.back().at)}) {
          CHECK(support.on == model::Support::On::Bone);
          if (support.on == model::Support::On::Bone)
            CHECK(bones.at(support.name).distance(at) < 1e-4);
        }
        const mesh::Spline spline = model::splineOf(curve);
        double outside = 0.0, inBone = 0.0;
        const auto samples = spline.sample(0.001);
        for (const mesh::Vector3& p : samples.point) {
          if (!skin.inside(p)) outside += 1.0;
          for (const auto& [bone, query] : bones) {
            const mesh::Box& box = boxes.at(bone);
            if (((p - box.hi).array() > 0.0).any() || ((box.lo - p).array() > 0.0).any()) continue;
            if (query.signedDistance(p) < -0.001) inBone += 1.0;
          }
        }
        CHECK(outside == 0.0);
        CHECK(inBone <= 0.01 * static_cast<double>(samples.point.size()));
      }
    }
  }
}

}  // namespace ecorche
