#pragma once

#include <ecorche/core/files.h>
#include <ecorche/mesh/write_mesh.h>
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <string>

#include "support/paths.h"
#include "support/shapes.h"

namespace ecorche::test {

/// The smallest anatomy that is one, on disk: an egg for a skin, a bone in its middle, two muscles
/// beside the bone. 8000 tets; a build takes about a second. Tests spoil its files.
///
///   limb.ecorche  skin.obj  bone.obj
class SmallProject {
 public:
  /// Half axes [m], the long one along z.
  static constexpr double kSkin[3] = {0.05, 0.045, 0.15};
  static constexpr double kBone[3] = {0.009, 0.009, 0.11};

  SmallProject() {
    write("skin.obj", egg(kSkin, 3));
    write("bone.obj", egg(kBone, 2));
    write("limb.ecorche", text());
  }

  [[nodiscard]] const std::filesystem::path& folder() const { return temp_.path(); }
  [[nodiscard]] std::filesystem::path at(const std::string& name) const { return folder() / name; }

  void write(const std::string& name, const mesh::SurfaceMesh& surface) const {
    REQUIRE(mesh::writeObj(surface, at(name)));
  }
  void write(const std::string& name, const std::string& bytes) const {
    REQUIRE(writeFileWhole(at(name), bytes));
  }

  /// The project file, one thing a line.
  static std::string text() {
    return R"({
  "schema": 1,
  "name": "limb",
  "unit": "m",
  "skin": {"file": "skin.obj"},
  "bones": [{"name": "humerus", "file": "bone.obj"}],
  "settings": {"fat": 0.3, "tets": 8000},
  "tissues": [
    {"name": "flexor", "kind": "muscle",
     "curves": [{"points": [{"at": [0.006, 0, -0.08], "tissue": 1}, {"at": [0.026, 0, 0], "tissue": 1}, {"at": [0.006, 0, 0.08], "tissue": 1}],
                 "start": {"on": "bone", "name": "humerus"}, "end": {"on": "bone", "name": "humerus"}}]},
    {"name": "extensor", "kind": "muscle",
     "curves": [{"points": [{"at": [-0.006, 0, -0.08], "tissue": 1}, {"at": [-0.026, 0, 0], "tissue": 1}, {"at": [-0.006, 0, 0.08], "tissue": 1}],
                 "start": {"on": "bone", "name": "humerus"}, "end": {"on": "bone", "name": "humerus"}}]}
  ]
}
)";
  }

  /// The same project file with one spot changed.
  static std::string textWith(const std::string& old, const std::string& fresh) {
    std::string out = text();
    const auto spot = out.find(old);
    REQUIRE(spot != std::string::npos);
    return out.replace(spot, old.size(), fresh);
  }

  static mesh::SurfaceMesh egg(const double (&axes)[3], int levels) {
    mesh::SurfaceMesh m = sphere(mesh::Vector3::Zero(), 1.0, levels);
    for (int k = 0; k < 3; ++k) m.V.col(k) *= axes[k];
    return m;
  }

 private:
  TempFolder temp_;
};

}  // namespace ecorche::test
