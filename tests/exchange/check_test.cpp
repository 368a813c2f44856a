#include <ecorche/core/files.h>
#include <ecorche/exchange/check_anatomy.h>
#include <ecorche/exchange/vtu.h>
#include <ecorche/mesh/read_mesh.h>
#include <ecorche/mesh/write_mesh.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <fstream>
#include <functional>

#include "exchange/sample_output.h"
#include "support/paths.h"

using namespace ecorche;
using exchange::CheckReport;
namespace fs = std::filesystem;

namespace {

CheckReport checked(const fs::path& folder) {
  RunContext run;
  auto report = exchange::checkOutput(folder, run);
  INFO((report ? "" : report.error().text()));
  REQUIRE(report);
  return *report;
}

std::vector<std::string> failedNames(const CheckReport& report) {
  std::vector<std::string> names;
  for (const auto& c : report.checks) {
    if (!c.pass) names.push_back(c.name);
  }
  return names;
}

// Writes the sample after `change` and tells which checks fail.
std::vector<std::string> failedAfter(const std::function<void(test::SampleOutput&)>& change,
                                     const std::function<void(const fs::path&)>& spoil = {}) {
  test::TempFolder temp;
  test::SampleOutput s = test::sample();
  change(s);
  test::writeSample(s, temp.path());
  if (spoil) spoil(temp.path());
  const CheckReport report = checked(temp.path());
  const auto names = failedNames(report);
  const auto error = exchange::failure(report, temp.path());
  CHECK(error.has_value() == !names.empty());
  if (error) {
    CHECK(error->code == ErrorCode::CheckFailed);
    for (const auto& n : names) CHECK(error->message.find(n) != std::string::npos);
  }
  return names;
}

bool has(const std::vector<std::string>& names, const std::string& name) {
  return std::ranges::find(names, name) != names.end();
}

// Surfaces that a changed labelling has.
void relabel(test::SampleOutput& s) {
  for (std::size_t i = 0; i < s.surfaces.size(); ++i) {
    s.surfaces[i] = test::surfaceOfLabel(
        s.shape.anatomy, TissueId{1 + static_cast<std::int64_t>(i)}, s.surfaces[i].name);
  }
}

// A tet of the muscle with id 2 well inside: all neighbours have the same label.
Eigen::Index innerTet(const test::SampleOutput& s) {
  const auto& a = s.shape.anatomy;
  for (Eigen::Index t = a.mesh.T.rows() / 2; t < a.mesh.T.rows(); ++t) {
    bool inner = a.label[static_cast<std::size_t>(t)].value == 2;
    for (int k = 0; k < 4; ++k) {
      const std::int32_t n = a.neighbours(t, k);
      inner = inner && n >= 0 && a.label[static_cast<std::size_t>(n)].value == 2;
    }
    if (inner) return t;
  }
  return -1;
}

void replaceIn(const fs::path& file, const std::string& from, const std::string& to) {
  std::string text = readFile(file).value();
  REQUIRE(text.find(from) != text.npos);
  text.replace(text.find(from), from.size(), to);
  std::ofstream(file, std::ios::binary | std::ios::trunc) << text;
}

}  // namespace

TEST_CASE("a whole output passes every check, and the figures are those of the model") {
  test::TempFolder temp;
  test::writeSample(test::sample(), temp.path());
  const CheckReport report = checked(temp.path());
  INFO(exchange::checkTable(report.checks));
  CHECK(report.pass());
  CHECK(report.checks.size() == 20);
  CHECK_FALSE(exchange::failure(report, temp.path()));
  CHECK(report.tets == test::sample().shape.anatomy.mesh.T.rows());
  REQUIRE(report.tissues.size() == 3);
  double sum = 0.0;
  for (const auto& t : report.tissues) sum += t.volumeCm3;
  CHECK(sum == Approx(1e6 * test::sample().shape.domain.volume).epsilon(1e-12));
  CHECK(report.tissues[1].components == 1);
  CHECK(exchange::printCheckReport(report).find("\"pass\": true") != std::string::npos);
}

TEST_CASE("either volume format is enough to check") {
  for (const char* formats : {"vtu", "mesh", "vtu,obj"}) {
    test::TempFolder temp;
    test::writeSample(test::sample(), temp.path(), exchange::parseFormats(formats).value());
    const CheckReport report = checked(temp.path());
    INFO(formats << "\n" << exchange::checkTable(report.checks));
    CHECK(report.pass());
  }
  test::TempFolder temp;
  test::writeSample(test::sample(), temp.path(), exchange::parseFormats("obj").value());
  RunContext run;
  CHECK(exchange::checkOutput(temp.path(), run).error().code == ErrorCode::FileMissing);
  CHECK(exchange::checkOutput(temp.path() / "none", run).error().code == ErrorCode::FileMissing);
}

TEST_CASE("each corruption is caught by the check that is made for it") {
  using Names = std::vector<std::string>;

  SECTION("a tet turned inside out") {
    const Names names = failedAfter([](test::SampleOutput& s) {
      auto& T = s.shape.anatomy.mesh.T;
      std::swap(T(innerTet(s), 0), T(innerTet(s), 1));
    });
    CHECK(has(names, "tets-positive"));
    CHECK(has(names, "faces-shared"));
  }
  SECTION("a tet without volume") {
    // Its top moved into its base: flat to the last bit, and its neighbours grow by what it lost
    const Names names = failedAfter([](test::SampleOutput& s) {
      auto& m = s.shape.anatomy.mesh;
      const Eigen::Index t = innerTet(s);
      m.V.row(m.T(t, 0)) = m.V.row(m.T(t, 1));
      relabel(s);
    });
    CHECK(has(names, "tets-positive"));
  }
  SECTION("a crack: one tet has its own copy of a vertex") {
    const Names names = failedAfter([](test::SampleOutput& s) {
      auto& a = s.shape.anatomy;
      const Eigen::Index t = innerTet(s);
      a.mesh.V.conservativeResize(a.mesh.V.rows() + 1, 3);
      a.mesh.V.row(a.mesh.V.rows() - 1) = a.mesh.V.row(a.mesh.T(t, 2));
      a.mesh.T(t, 2) = static_cast<std::int32_t>(a.mesh.V.rows() - 1);
      s.fibers.vertexFiber.conservativeResize(a.mesh.V.rows(), 3);
      s.fibers.vertexFiber.row(a.mesh.V.rows() - 1) = Eigen::Vector3d::UnitZ().transpose();
    });
    CHECK(has(names, "faces-marked"));
    CHECK(has(names, "surfaces-agree"));
    CHECK(has(names, "skin-deviation") == false);
  }
  SECTION("a tet lost") {
    const Names names = failedAfter([](test::SampleOutput& s) {
      auto& a = s.shape.anatomy;
      const Eigen::Index t = innerTet(s);
      const Eigen::Index last = a.mesh.T.rows() - 1;
      // The tet stays in memory's surfaces and marks, and is gone from the file
      a.mesh.T.row(t) = a.mesh.T.row(last);
      a.label[static_cast<std::size_t>(t)] = a.label[static_cast<std::size_t>(last)];
      s.fibers.tetFiber.row(t) = s.fibers.tetFiber.row(last);
      a.mesh.T.conservativeResize(last, 4);
      a.label.resize(static_cast<std::size_t>(last));
      s.fibers.tetFiber.conservativeResize(last, 3);
      a.neighbours = mesh::tetAdjacency(a.mesh.T).neighbours;
    });
    CHECK(has(names, "faces-marked"));
    CHECK(has(names, "surfaces-agree"));
  }
  SECTION("a tet twice") {
    const Names names = failedAfter([](test::SampleOutput& s) {
      auto& a = s.shape.anatomy;
      const Eigen::Index t = innerTet(s);
      a.mesh.T.row(t) = a.mesh.T.row(a.neighbours(t, 0));
    });
    CHECK(has(names, "faces-shared"));
    CHECK(has(names, "volumes-add-up"));
  }
  SECTION("a label that nobody knows") {
    const Names names = failedAfter([](test::SampleOutput& s) {
      s.shape.anatomy.label[static_cast<std::size_t>(innerTet(s))] = TissueId{9};
    });
    CHECK(has(names, "labels-known"));
    CHECK(has(names, "volumes-add-up"));
  }
  SECTION("two pieces of muscle that touch in an edge") {
    // Two tets of fat become muscle: only their common edge joins them to it
    const Names names = failedAfter([](test::SampleOutput& s) {
      auto& a = s.shape.anatomy;
      for (Eigen::Index t = 0; t < a.mesh.T.rows(); ++t) {
        if (a.label[static_cast<std::size_t>(t)] != kFat) continue;
        int touching = 0;
        bool face = false;
        for (Eigen::Index n = 0; n < a.mesh.T.rows(); ++n) {
          if (a.label[static_cast<std::size_t>(n)].value != 2) continue;
          int common = 0;
          for (int i = 0; i < 4; ++i) common += (a.mesh.T.row(n).array() == a.mesh.T(t, i)).any();
          face |= common == 3;
          touching += common == 2;
        }
        if (touching == 0 || face) continue;
        a.label[static_cast<std::size_t>(t)] = TissueId{2};
        s.fibers.tetFiber.row(t) = Eigen::Vector3d::UnitZ().transpose();
        break;
      }
      relabel(s);
    });
    CHECK(has(names, "muscles-manifold-edges"));
    CHECK(has(names, "muscles-connected"));
    CHECK_FALSE(has(names, "volumes-add-up"));
  }
  SECTION("a muscle in two pieces") {
    const Names names = failedAfter([](test::SampleOutput& s) {
      auto& a = s.shape.anatomy;
      for (Eigen::Index t = 0; t < a.mesh.T.rows(); ++t) {
        const double z = a.mesh.V(a.mesh.T(t, 0), 2);
        if (a.label[static_cast<std::size_t>(t)].value == 2 && z > 0.07 && z < 0.13) {
          a.label[static_cast<std::size_t>(t)] = kFat;
          s.fibers.tetFiber.row(t).setZero();
        }
      }
      relabel(s);
    });
    CHECK(has(names, "muscles-connected"));
    CHECK(has(names, "curves-inside"));
  }
  SECTION("a fibre of length 2, one that is not a number, one that is missing") {
    for (const double bad : {2.0, std::nan(""), 0.0}) {
      CHECK(failedAfter([&](test::SampleOutput& s) {
              s.fibers.tetFiber.row(innerTet(s)) *= bad;
            }) == Names{"fibers-unit"});
      CHECK(failedAfter([&](test::SampleOutput& s) {
              s.fibers.vertexFiber.row(s.shape.anatomy.mesh.T(innerTet(s), 0)) *= bad;
            }) == Names{"fibers-unit"});
    }
  }
  SECTION("fibres that run from insertion to origin") {
    const Names names = failedAfter([](test::SampleOutput& s) { s.fibers.tetFiber *= -1.0; });
    CHECK(names == Names{"fibers-follow-curves", "fibers-origin-to-insertion"});
  }
  SECTION("fibres across the muscle") {
    const Names names = failedAfter([](test::SampleOutput& s) {
      for (Eigen::Index t = 0; t < s.fibers.tetFiber.rows(); ++t) {
        if (!s.fibers.tetFiber.row(t).isZero())
          s.fibers.tetFiber.row(t) = Eigen::Vector3d(0.6, 0, 0.8).transpose();
      }
    });
    CHECK(names == Names{"fibers-follow-curves"});
  }
  SECTION("fibres that meet inside the muscle") {
    // Up in one layer of cells, down in the next
    const Names names = failedAfter([](test::SampleOutput& s) {
      for (Eigen::Index t = 0; t < s.fibers.tetFiber.rows(); ++t) {
        if (s.fibers.tetFiber.row(t).isZero()) continue;
        double z = 0.0;
        for (int k = 0; k < 4; ++k)
          z += 0.25 * s.shape.anatomy.mesh.V(s.shape.anatomy.mesh.T(t, k), 2);
        const bool odd = static_cast<int>(z / 0.2 * 16) % 2 == 1;
        s.fibers.tetFiber.row(t) << 0.0, 0.0, odd ? -1.0 : 1.0;
      }
    });
    CHECK(has(names, "fibers-no-extrema"));
  }
  SECTION("a surface with a vertex moved by one bit") {
    CHECK(failedAfter([](test::SampleOutput& s) {
            s.surfaces[1].V(7, 0) = std::nextafter(s.surfaces[1].V(7, 0), 1.0);
          }) == Names{"surfaces-agree"});
  }
  SECTION("a surface with a face missing") {
    CHECK(failedAfter([](test::SampleOutput& s) {
            s.surfaces[2].F.conservativeResize(s.surfaces[2].F.rows() - 1, 3);
          }) == Names{"surfaces-agree"});
  }
  SECTION("a surface file that is gone") {
    CHECK(failedAfter([](test::SampleOutput&) {},
                      [](const fs::path& folder) { fs::remove(folder / "fat.obj"); }) ==
          Names{"files-complete"});
  }
  SECTION("a triangle mark that is lost") {
    // References stay aligned: the last triangle is dropped from the count and from the list
    CHECK(failedAfter([](test::SampleOutput&) {},
                      [](const fs::path& folder) {
                        std::string text = readFile(folder / "anatomy.mesh").value();
                        const auto at = text.find("Triangles\n") + 10;
                        const auto count = std::stol(text.substr(at));
                        const auto end = text.find("\nTetrahedra");
                        const auto before = text.rfind('\n', end - 1);
                        text.erase(before, end - before);
                        text.replace(at, std::to_string(count).size(), std::to_string(count - 1));
                        std::ofstream(folder / "anatomy.mesh", std::ios::trunc) << text;
                      }) == Names{"faces-marked"});
  }
  SECTION("two volume files that differ in one digit") {
    const Names names =
        failedAfter([](test::SampleOutput&) {},
                    [](const fs::path& folder) {
                      std::string text = readFile(folder / "anatomy.mesh").value();
                      const auto row = text.find('\n', text.find("Vertices\n") + 9) + 1;
                      const auto digit = text.find_first_of("12345678", row);
                      text[digit] = static_cast<char>(text[digit] + 1);
                      std::ofstream(folder / "anatomy.mesh", std::ios::trunc) << text;
                    });
    CHECK(names == Names{"formats-agree"});
  }
  SECTION("a skin that is 0.2 % of the diagonal away, a bone that is") {
    CHECK(failedAfter([](test::SampleOutput& s) {
            s.skin.V.col(0).array() += 0.002 * s.shape.domain.skinDiagonal;
          }) == Names{"skin-deviation"});
    CHECK(failedAfter([](test::SampleOutput& s) {
            s.bones[0].V.col(2).array() -= 0.002 * s.shape.domain.skinDiagonal;
          }) == Names{"bone-deviation"});
  }
  SECTION("a curve that leaves its muscle") {
    const Names names = failedAfter([](test::SampleOutput& s) {
      s.tissues[0] =
          test::muscleAlong(s.tissues[0].name, {{-0.01, 0, 0}, {0.02, 0, 0.1}, {-0.01, 0, 0.2}});
    });
    CHECK(has(names, "curves-inside"));
  }
  SECTION("names that are not those of the model") {
    CHECK(failedAfter([](test::SampleOutput&) {},
                      [](const fs::path& folder) {
                        replaceIn(folder / "model.json", "\"biceps brachii\"",
                                  "\"triceps brachii\"");
                      }) == Names{"labels-known"});
  }
  SECTION("a report with another volume") {
    const auto spoil = [](double factor) {
      return [factor](const fs::path& folder) {
        exchange::Report report;
        report.tissues = checked(folder).tissues;
        report.tissues[1].volumeCm3 *= factor;
        REQUIRE(exchange::writeReport(folder / "report.json", report));
      };
    };
    CHECK(failedAfter([](test::SampleOutput&) {}, spoil(1.0)).empty());
    CHECK(failedAfter([](test::SampleOutput&) {}, spoil(1.000001)) == Names{"report-agrees"});
  }
}

TEST_CASE("files that cannot be read are errors with their name, not failed checks") {
  test::TempFolder temp;
  test::writeSample(test::sample(), temp.path());
  const std::string good = readFile(temp.path() / "anatomy.vtu").value();
  std::ofstream(temp.path() / "anatomy.vtu", std::ios::binary | std::ios::trunc)
      << good.substr(0, good.size() - 1000);
  RunContext run;
  const auto report = exchange::checkOutput(temp.path(), run);
  REQUIRE_FALSE(report);
  CHECK(report.error().code == ErrorCode::FileTruncated);
  CHECK(report.error().place.file.find("anatomy.vtu") != std::string::npos);
}
