#include <ecorche/core/files.h>
#include <ecorche/core/parallel.h>
#include <ecorche/exchange/file_names.h>
#include <ecorche/exchange/medit.h>
#include <ecorche/exchange/vtu.h>
#include <ecorche/mesh/read_mesh.h>

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <fstream>
#include <random>

#include "exchange/sample_output.h"
#include "support/paths.h"

using namespace ecorche;
using exchange::AnatomyFile;
using exchange::readMedit;
using exchange::readVtu;

namespace {

std::vector<std::int32_t> ids(const std::vector<TissueId>& labels) {
  std::vector<std::int32_t> out;
  for (const TissueId id : labels) out.push_back(id.value);
  return out;
}

void overwrite(const std::filesystem::path& file, const std::string& bytes) {
  std::ofstream(file, std::ios::binary | std::ios::trunc) << bytes;
}

}  // namespace

TEST_CASE("what is written to VTU and MEDIT is read back to the last bit") {
  test::TempFolder temp;
  const auto written = test::writeSample(test::sample(), temp.path());
  const auto vtu = readVtu(temp.path() / "anatomy.vtu");
  REQUIRE(vtu);
  const envelope::Anatomy& a = test::sample().shape.anatomy;
  CHECK(vtu->mesh.V == a.mesh.V);
  CHECK(vtu->mesh.T == a.mesh.T);
  CHECK(vtu->tissue == ids(a.label));
  CHECK(vtu->tetFiber == test::sample().fibers.tetFiber);
  CHECK(vtu->vertexFiber == test::sample().fibers.vertexFiber);
  REQUIRE(vtu->names.size() == 3);
  CHECK(vtu->names[0] == exchange::TissueName{1, "fat"});
  CHECK(vtu->names[2] == exchange::TissueName{3, "triceps <lateral> & \"long\""});

  const auto medit = readMedit(temp.path() / "anatomy.mesh");
  REQUIRE(medit);
  CHECK(medit->mesh.V == a.mesh.V);
  CHECK(medit->mesh.T == a.mesh.T);
  CHECK(medit->tissue == ids(a.label));

  // Boundary faces as they were, then one triangle per inner face between tissues
  CHECK(medit->F.topRows(a.boundaryF.rows()) == a.boundaryF);
  std::vector<std::string> kinds;
  for (const auto& m : written.references)
    kinds.push_back(m.kind + " " + m.name + (m.other.empty() ? "" : " | " + m.other));
  CHECK(kinds ==
        std::vector<std::string>{"skin skin", "bone upper bone", "bone lower bone",
                                 "interface biceps brachii | fat",
                                 "interface triceps <lateral> & \"long\" | fat",
                                 "interface triceps <lateral> & \"long\" | biceps brachii"});
  // Interfaces of a muscle with its share of the boundary close its surface
  double volume = 0.0;
  for (Eigen::Index t = 0; t < a.mesh.T.rows(); ++t) {
    if (a.label[static_cast<std::size_t>(t)].value == 3) volume += mesh::signedVolume(a.mesh, t);
  }
  double enclosed = 0.0;
  for (Eigen::Index f = 0; f < medit->F.rows(); ++f) {
    const auto& m = written.references[static_cast<std::size_t>(
        medit->reference[static_cast<std::size_t>(f)] - 1)];
    const bool own =
        m.kind == "interface"
            ? m.index == 3
            : a.label[static_cast<std::size_t>(a.boundaryTet[static_cast<std::size_t>(f)])].value ==
                  3;
    if (!own) continue;
    enclosed +=
        medit->mesh.V.row(medit->F(f, 0))
            .dot(medit->mesh.V.row(medit->F(f, 1)).cross(medit->mesh.V.row(medit->F(f, 2)))) /
        6.0;
  }
  CHECK(enclosed == Approx(volume).epsilon(1e-12));
}

TEST_CASE("numbers of any size survive both formats") {
  std::mt19937_64 random(7);
  mesh::TetMesh mesh;
  mesh.V.resize(400, 3);
  for (Eigen::Index i = 0; i < mesh.V.size(); ++i) {
    const double exponent = std::uniform_real_distribution(-300.0, 300.0)(random);
    mesh.V.data()[i] = std::uniform_real_distribution(-1.0, 1.0)(random) * std::pow(10.0, exponent);
  }
  mesh.V.row(0) << 0.0, -0.0, 5e-324;
  mesh.V.row(1) << 1.7976931348623157e308, -2.2250738585072014e-308, 0.1;
  mesh.T.resize(100, 4);
  for (Eigen::Index i = 0; i < mesh.T.size(); ++i) mesh.T.data()[i] = static_cast<std::int32_t>(i);
  const std::vector<TissueId> tissue(100, kFat);
  const std::vector<exchange::TissueName> names{{1, "fat"}};
  test::TempFolder temp;
  REQUIRE(exchange::writeVtu(temp.path() / "a.vtu", {mesh, tissue, names}));
  REQUIRE(exchange::writeMedit(temp.path() / "a.mesh", mesh, tissue, {}, names));
  const auto vtu = readVtu(temp.path() / "a.vtu");
  const auto medit = readMedit(temp.path() / "a.mesh");
  REQUIRE(vtu);
  REQUIRE(medit);
  const auto sameBits = [&](const mesh::Positions& V) {
    return std::memcmp(V.data(), mesh.V.data(),
                       sizeof(double) * static_cast<std::size_t>(V.size())) == 0;
  };
  CHECK(sameBits(vtu->mesh.V));
  CHECK(sameBits(medit->mesh.V));
  CHECK(vtu->tetFiber.rows() == 0);
  CHECK(vtu->vertexFiber.rows() == 0);
}

TEST_CASE("tendon is carried where there is one") {
  test::SampleOutput s = test::sample();
  s.fibers.tendon.assign(s.shape.anatomy.label.size(), 0);
  s.fibers.tendon[5] = 1;
  test::TempFolder temp;
  test::writeSample(s, temp.path());
  const auto vtu = readVtu(temp.path() / "anatomy.vtu");
  REQUIRE(vtu);
  CHECK(vtu->tendon == s.fibers.tendon);
}

TEST_CASE("formats that were not asked for are not written") {
  test::TempFolder temp;
  const auto formats = exchange::parseFormats("mesh,obj");
  REQUIRE(formats);
  test::writeSample(test::sample(), temp.path(), *formats);
  CHECK_FALSE(std::filesystem::exists(temp.path() / "anatomy.vtu"));
  CHECK(std::filesystem::exists(temp.path() / "anatomy.mesh"));
  CHECK(std::filesystem::exists(temp.path() / "muscles" / "biceps_brachii.obj"));
  CHECK(exchange::parseFormats("vtu,fbx").error().code == ErrorCode::UnknownName);
  CHECK(exchange::parseFormats("").error().code == ErrorCode::UnknownName);
}

TEST_CASE("surfaces and originals are written under safe names and read back exactly") {
  test::TempFolder temp;
  const auto written = test::writeSample(test::sample(), temp.path());
  CHECK(written.tissueFiles == std::vector<std::string>{"fat.obj", "muscles/biceps_brachii.obj",
                                                        "muscles/triceps__lateral_____long_.obj"});
  RunContext run;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto back = mesh::readMesh(temp.path() / written.tissueFiles[i], {}, run);
    REQUIRE(back);
    CHECK(back->V == test::sample().surfaces[i].V);
    CHECK(back->F == test::sample().surfaces[i].F);
  }
  CHECK(std::filesystem::exists(temp.path() / "skin.obj"));
  CHECK(std::filesystem::exists(temp.path() / "bones" / "lower_plate.obj"));
}

TEST_CASE("file names are safe everywhere and never collide") {
  const auto names =
      exchange::fileNames({"Biceps", "biceps", "m. glut\xC3\xA9us", "../../etc/passwd", "", ".",
                           "con", "COM1.x", "a/b", "a b", "-rf", std::string(300, 'x')});
  CHECK(names[0] == "Biceps");
  CHECK(names[1] == "biceps-2");
  CHECK(names[2] == "m._glut_us");
  CHECK(names[3] == "_.._.._etc_passwd");
  CHECK(names[4] == "_");
  CHECK(names[5] == "_-2");
  CHECK(names[6] == "_con");
  CHECK(names[7] == "_COM1.x");
  CHECK(names[8] == "a_b");
  CHECK(names[9] == "a_b-2");
  CHECK(names[10] == "_-rf");
  CHECK(names[11].size() == 100);
}

TEST_CASE("a broken VTU says what is wrong with it") {
  test::TempFolder temp;
  test::writeSample(test::sample(), temp.path());
  const auto file = temp.path() / "anatomy.vtu";
  const std::string good = readFile(file).value();
  const auto codeOf = [&](const std::string& bytes) {
    overwrite(file, bytes);
    const auto back = readVtu(file);
    REQUIRE_FALSE(back);
    CHECK(back.error().place.file == file.string());
    return back.error().code;
  };
  const auto changed = [&](const std::string& from, const std::string& to) {
    std::string bytes = good;
    REQUIRE(bytes.find(from) != bytes.npos);
    bytes.replace(bytes.find(from), from.size(), to);
    return bytes;
  };
  CHECK(readVtu(temp.path() / "none.vtu").error().code == ErrorCode::FileMissing);
  CHECK(codeOf("") == ErrorCode::FileEmpty);
  CHECK(codeOf("solid cube") == ErrorCode::FileUnknownFormat);
  CHECK(codeOf(good.substr(0, 300)) == ErrorCode::FileTruncated);
  CHECK(codeOf(good.substr(0, good.size() / 2)) == ErrorCode::FileTruncated);
  CHECK(codeOf(changed("<Points>", "<Points")) == ErrorCode::FileSyntax);
  CHECK(codeOf(changed("Name=\"connectivity\"", "Name=\"connections\"")) == ErrorCode::FileSyntax);
  CHECK(codeOf(changed("type=\"Float64\" Name=\"Points\"", "type=\"Float32\" Name=\"Points\"")) ==
        ErrorCode::FileUnknownFormat);
  CHECK(codeOf(changed("byte_order=\"LittleEndian\"", "byte_order=\"BigEndian\"")) ==
        ErrorCode::FileUnknownFormat);
  CHECK(codeOf(changed("NumberOfCells=\"", "NumberOfCells=\"9")) == ErrorCode::FileTruncated);
  CHECK(codeOf(changed("NumberOfCells=\"", "NumberOfCells=\"-")) == ErrorCode::FileSyntax);
  CHECK(codeOf(changed("offset=\"0\"", "offset=\"8\"")) == ErrorCode::FileSyntax);
}

TEST_CASE("a broken MEDIT file says what is wrong and in which line") {
  test::TempFolder temp;
  const auto file = temp.path() / "a.mesh";
  const std::string head = "MeshVersionFormatted 2\nDimension\n3\n# a comment\n";
  const std::string vertices = "Vertices\n4\n0 0 0 0\n1 0 0 0\n0 1 0 0\n0 0 1 0\n";
  const auto errorOf = [&](const std::string& bytes) {
    overwrite(file, bytes);
    const auto back = readMedit(file);
    REQUIRE_FALSE(back);
    return back.error();
  };
  overwrite(file, head + vertices + "RequiredVertices\n1\n2\nTetrahedra 1\n1 2 3 4 7\nEnd\n");
  const auto good = readMedit(file);
  REQUIRE(good);
  CHECK(good->tissue == std::vector<std::int32_t>{7});
  CHECK(good->mesh.T(0, 3) == 3);

  CHECK(errorOf("v 0 0 0\n").code == ErrorCode::FileUnknownFormat);
  CHECK(errorOf(head + "Vertices\n4\n0 0 0 0\n1 0 0 0\n").code == ErrorCode::FileTruncated);
  CHECK(errorOf(head + vertices + "Tetrahedra\n1\n1 2 3 4 7\n").code == ErrorCode::FileTruncated);
  CHECK(errorOf(head + "Vertices\n99999999\n0 0 0 0\n").code == ErrorCode::FileTruncated);
  CHECK(errorOf("MeshVersionFormatted 2\nDimension 2\n").code == ErrorCode::FileSyntax);
  CHECK(errorOf(head + vertices + "Tetrahedra\n1\n1 2 3 4 7\nVertices\n1\n0 0 0 0\nEnd\n").code ==
        ErrorCode::FileSyntax);
  const Error outside = errorOf(head + vertices + "Tetrahedra\n1\n1 2 3 5 7\nEnd\n");
  CHECK(outside.code == ErrorCode::FileSyntax);
  CHECK(outside.place.line == 13);
  CHECK(errorOf(head + vertices + "Tetrahedra\n1\n1 2 x 4 7\nEnd\n").code == ErrorCode::FileSyntax);
}

TEST_CASE("files have the same bytes whatever the number of threads") {
  std::vector<std::string> medit;
  for (const int threads : {1, 2}) {
    const ThreadLimit limit(threads);
    test::TempFolder temp;
    test::writeSample(test::sample(), temp.path());
    medit.push_back(readFile(temp.path() / "anatomy.mesh").value());
  }
  CHECK(medit[0] == medit[1]);
}

TEST_CASE("a folder that cannot be written is an error with a name") {
  RunContext run;
  const auto written =
      exchange::writeOutput("/nonexistent/folder", test::sample().contents(), {}, run);
  REQUIRE_FALSE(written);
  CHECK(written.error().code == ErrorCode::FileNotWritable);
}

TEST_CASE("any bytes give a mesh that hangs together or an error") {
  // A small file of each kind with bytes changed, cut out and doubled at random
  test::TempFolder temp;
  test::writeSample(test::makeSample("m", {10, 10, 2}), temp.path());
  std::mt19937_64 random(5);
  const auto whole = [](const AnatomyFile& a) {
    const bool corners =
        a.mesh.T.rows() == 0 || (a.mesh.T.minCoeff() >= 0 && a.mesh.T.maxCoeff() < a.mesh.V.rows());
    const bool faces = a.F.rows() == 0 || (a.F.minCoeff() >= 0 && a.F.maxCoeff() < a.mesh.V.rows());
    return corners && faces && static_cast<Eigen::Index>(a.tissue.size()) == a.mesh.T.rows() &&
           static_cast<Eigen::Index>(a.reference.size()) == a.F.rows();
  };
  for (const char* name : {"anatomy.vtu", "anatomy.mesh"}) {
    const std::string good = readFile(temp.path() / name).value();
    for (int k = 0; k < 400; ++k) {
      std::string bytes = good;
      const int changes = 1 + k % 4;
      for (int c = 0; c < changes && !bytes.empty(); ++c) {
        // Headers matter most
        const std::size_t range =
            k % 2 == 0 ? std::min<std::size_t>(bytes.size(), 2500) : bytes.size();
        const std::size_t at = random() % range;
        const std::size_t length = 1 + random() % 40;
        switch (random() % 3) {
          case 0:
            bytes[at] = static_cast<char>(random());
            break;
          case 1:
            bytes.erase(at, length);
            break;
          default:
            bytes.insert(at, bytes.substr(at, length));
            break;
        }
      }
      if (bytes.empty()) continue;
      const auto file = temp.path() / "spoilt";
      overwrite(file, bytes);
      const auto back = std::string_view(name) == "anatomy.vtu" ? readVtu(file) : readMedit(file);
      if (back) REQUIRE(whole(*back));
    }
  }
}
