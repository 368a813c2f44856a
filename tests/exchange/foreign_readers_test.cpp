#include <catch2/catch.hpp>
#include <map>

#include "exchange/sample_output.h"
#include "support/python.h"

using namespace ecorche;

TEST_CASE("meshio and vtk see the points, tets, tissues, names, volumes and fibres that we wrote") {
  if (!test::haveReaders()) return;
  test::TempFolder temp;
  const test::SampleOutput sample = test::makeSample();
  const auto written = test::writeSample(sample, temp.path() / "out");
  const auto seen = test::pythonOn("exchange/read_back.py", temp.path() / "out");

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
