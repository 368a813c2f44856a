#include <ecorche/core/files.h>

#include <catch2/catch.hpp>
#include <cstdlib>
#include <map>
#include <nlohmann/json.hpp>

#include "exchange/sample_output.h"
#include "support/paths.h"

using namespace ecorche;

namespace {

// Debian's own interpreter: it is the one that has Debian's meshio and vtk.
constexpr const char* kPython = "/usr/bin/python3";

bool haveReaders() {
  const std::string command = std::string(kPython) + " -c 'import meshio, vtk' 2>/dev/null";
  if (std::system(command.c_str()) == 0) return true;
  WARN(
      "SKIPPED: python3-meshio or python3-vtk9 is not installed; other people's readers were not "
      "tried");
  return false;
}

}  // namespace

TEST_CASE("meshio and vtk see the points, tets, tissues, names, volumes and fibres that we wrote") {
  if (!haveReaders()) return;
  test::TempFolder temp;
  const test::SampleOutput sample = test::makeSample();
  const auto written = test::writeSample(sample, temp.path() / "out");
  const std::string command = std::string(kPython) + " " + ECORCHE_SOURCE_DIR +
                              "/tests/exchange/read_back.py " + (temp.path() / "out").string() +
                              " > " + (temp.path() / "seen.json").string();
  REQUIRE(std::system(command.c_str()) == 0);
  const auto seen = nlohmann::json::parse(readFile(temp.path() / "seen.json").value());

  const envelope::Anatomy& a = sample.shape.anatomy;
  std::map<std::int32_t, double> volumes;
  for (Eigen::Index t = 0; t < a.mesh.T.rows(); ++t) {
    volumes[a.label[static_cast<std::size_t>(t)].value] += mesh::signedVolume(a.mesh, t);
  }
  for (const char* reader : {"meshio_vtu", "vtk", "meshio_medit"}) {
    INFO(reader << " " << seen.at(reader).dump());
    const auto& s = seen.at(reader);
    CHECK(s.at("points") == a.mesh.V.rows());
    CHECK(s.at("tets") == a.mesh.T.rows());
    CHECK(s.at("smallest").get<double>() > 0.0);
    CHECK(s.at("most_tets_on_a_face") == 2);
    CHECK(s.at("boundary_faces") == a.boundaryF.rows());
    CHECK(s.at("volumes").size() == volumes.size());
    for (const auto& [id, volume] : volumes) {
      CHECK(s.at("volumes").at(std::to_string(id)).get<double>() == Approx(volume).epsilon(1e-12));
    }
  }
  for (const char* reader : {"meshio_vtu", "vtk"}) {
    INFO(reader);
    const auto& s = seen.at(reader);
    CHECK(s.at("names") ==
          nlohmann::json{{"fat", 1}, {"biceps brachii", 2}, {"triceps <lateral> & \"long\"", 3}});
    CHECK(s.at("worst_fiber_norm").get<double>() < 1e-12);
    for (int c = 0; c < 3; ++c) {
      const auto k = static_cast<std::size_t>(c);
      CHECK(s.at("fiber_sum").at(k).get<double>() ==
            Approx(sample.fibers.tetFiber.col(c).sum()).epsilon(1e-9).margin(1e-9));
      CHECK(s.at("vertex_fiber_sum").at(k).get<double>() ==
            Approx(sample.fibers.vertexFiber.col(c).sum()).epsilon(1e-9).margin(1e-9));
    }
  }
  // Every reference that the report explains has triangles, and no other
  CHECK(seen.at("meshio_medit").at("triangles").size() == written.references.size());
  for (const auto& m : written.references) {
    CHECK(seen.at("meshio_medit").at("triangles").contains(std::to_string(m.reference)));
  }
}
