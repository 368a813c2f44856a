#include <ecorche/exchange/report.h>

#include <catch2/catch.hpp>

#include "support/paths.h"

using namespace ecorche;
using exchange::Report;

namespace {

Report sampleReport() {
  Report r;
  r.program = "ecorche 0.1.0";
  r.project = "arm";
  r.sourceUnit = "cm";
  r.skinDiagonal = 0.7071067811865476;
  r.domainVolumeCm3 = 2345.678901234567;
  r.domainTets = 203118;
  r.domainVertices = 38011;
  r.freeVertices = 29384;
  r.tets = 412881;
  r.vertices = 77012;
  exchange::TissueFigures biceps;
  biceps.id = 2;
  biceps.name = "biceps brachii \xC3\xA9";
  biceps.kind = "muscle";
  biceps.side = "left";
  biceps.file = "muscles/biceps_brachii.obj";
  biceps.volumeCm3 = 143.1 / 3;
  biceps.areaCm2 = 120.5;
  biceps.components = 1;
  biceps.tets = 12034;
  biceps.attachments = {{"origin", "bone", "scapula", 3.25, {0.1, 0.2, 1.0 / 3.0}},
                        {"", "bone", "humerus", 0.02, {0, 0, 0}}};
  biceps.fibers = exchange::FiberFigures{12.3, 1.1, 98, 4.5, 0.0001, 0.002};
  r.tissues = {{1, "fat", "fat", "", "", "fat.obj", 1000.0, 900.0, 3, 200000, {}, {}}, biceps};
  r.tissuesPerTet = {0.8, 0.18, 0.02};
  r.envelope = {81004, 1204, 17, 1, 3, 120, 1.3e-7, 0, 2, 4.5e-6, 3};
  r.quality = {0.3, 178.2, {10, 20, 30, 40, 50, 60}, 1e-17};
  r.checks = {{"tets-positive", true, 0, 0, "0 of 412881 tets", "", {}},
              {"curves-inside", false, 0.9, 0.95, "90 % of biceps", "biceps",
               Eigen::Vector3d(0.1, 0.2, 0.3)}};
  r.references = {{1, "skin", "skin", "", 0, 0}, {2, "interface", "biceps", "fat", 2, 1}};
  r.findings = {{Severity::Repaired, "hole", "femur", "filled a hole of 3 edges",
                 Eigen::Vector3d(1, 2, 3), 0.001},
                {Severity::Note, "fibers-spread", "biceps", "4 tets", std::nullopt, 0.0}};
  r.stages = {{"tetrahedra", 5.25}, {"tissue fields", 1.125}};
  r.totalSeconds = 9.5;
  r.peakMemoryBytes = 1234567890123;
  r.peakWorkerMemoryBytes = 345678901;
  r.machine = {"Some CPU @ 2 GHz", 2, 2, "OpenBLAS 0.3.21"};
  return r;
}

}  // namespace

TEST_CASE("a report survives the way to its file and back") {
  test::TempFolder temp;
  const Report report = sampleReport();
  REQUIRE(exchange::writeReport(temp.path() / "report.json", report));
  const auto back = exchange::readReport(temp.path() / "report.json");
  REQUIRE(back);
  // Every field is printed, so equal text is equal content
  CHECK(exchange::printReport(*back) == exchange::printReport(report));
  CHECK(back->tissues[1].volumeCm3 == report.tissues[1].volumeCm3);
  CHECK(back->tissues[1].attachments[0].centroid == report.tissues[1].attachments[0].centroid);
  CHECK(back->checks[1].point->y() == 0.2);
  CHECK(back->findings[0].severity == Severity::Repaired);
  CHECK_FALSE(back->findings[1].point);
  CHECK(back->peakMemoryBytes == 1234567890123);
}

TEST_CASE("a damaged report says whether it is no JSON, lacks a key or holds the wrong thing") {
  const auto codeOf = [](const std::string& text) {
    return exchange::parseReport(text, "report.json").error().code;
  };
  std::string text = exchange::printReport(sampleReport());
  CHECK(codeOf(text.substr(0, 500)) == ErrorCode::FileSyntax);
  CHECK(codeOf("{}") == ErrorCode::MissingKey);
  text.replace(text.find("\"tets\": 203118"), 14, "\"tets\": \"many\"");
  CHECK(codeOf(text) == ErrorCode::WrongType);
  CHECK(codeOf("[1, 2]") != ErrorCode::FileMissing);
}

TEST_CASE("the table names every muscle, every check and every stage, in columns") {
  const std::string table = exchange::reportTable(sampleReport());
  for (const char* word : {"arm", "biceps brachii \xC3\xA9", "scapula 3.2", "humerus <0.1",
                           "12.3 \xC2\xB1 1.1", "203,118", "29,384", "tets-positive", "FAILED",
                           "tissue fields", "filled a hole", "1 note", "OpenBLAS"}) {
    INFO(word << "\n" << table);
    CHECK(table.find(word) != std::string::npos);
  }
}
