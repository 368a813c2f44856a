#include <ecorche/mesh/read_mesh.h>
#include <ecorche/mesh/weld.h>
#include <ecorche/mesh/write_mesh.h>

#include <catch2/catch.hpp>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <random>

#include "support/paths.h"
#include "support/shapes.h"

using namespace ecorche;
using namespace ecorche::mesh;
namespace fs = std::filesystem;

namespace {

Result<SurfaceMesh> read(const fs::path& file, double metresPerUnit = 1.0) {
  RunContext run;
  return readMesh(file, {.metresPerUnit = metresPerUnit}, run);
}

Result<SurfaceMesh> readText(const std::string& name, const std::string& bytes) {
  const test::TempFolder temp;
  std::ofstream(temp.path() / name, std::ios::binary) << bytes;
  return read(temp.path() / name);
}

// Random coordinates with all their digits, from tiny to huge.
SurfaceMesh scattered() {
  SurfaceMesh m = test::sphere({0.1, 0.2, 0.3}, 1.0, 2);
  std::mt19937 random(7);
  std::uniform_real_distribution<double> digits(-1, 1);
  std::uniform_int_distribution<int> exponent(-12, 9);
  for (auto& x : m.V.reshaped()) x = digits(random) * std::pow(10, exponent(random));
  return m;
}

void checkSame(const SurfaceMesh& a, const SurfaceMesh& b) {
  CHECK(a.V == b.V);
  CHECK(a.F == b.F);
}

struct Broken {
  const char* name;
  std::string bytes;
  ErrorCode code;
  int line;
};

void checkBroken(const Broken& b) {
  INFO(b.name << ": " << b.bytes.substr(0, 200));
  const auto mesh = readText(b.name, b.bytes);
  REQUIRE_FALSE(mesh);
  INFO(mesh.error().text());
  CHECK(name(mesh.error().code) == name(b.code));
  CHECK(mesh.error().place.line == b.line);
  CHECK_THAT(mesh.error().text(), Catch::Contains(b.name));
}

}  // namespace

TEST_CASE("OBJ, PLY and OFF come back to the last bit") {
  const test::TempFolder temp;
  const SurfaceMesh m = scattered();
  REQUIRE(writeObj(m, temp.path() / "leg.obj"));
  REQUIRE(writePly(m, temp.path() / "leg.ply"));
  REQUIRE(writeOff(m, temp.path() / "leg.off"));
  for (const char* file : {"leg.obj", "leg.ply", "leg.off"}) {
    INFO(file);
    const auto back = read(temp.path() / file);
    REQUIRE(back);
    checkSame(*back, m);
    CHECK(back->name == "leg");
  }
}

TEST_CASE("STL comes back welded, rounded to 32 bits") {
  const test::TempFolder temp;
  SurfaceMesh m = test::torus(3, 1, 24, 12);
  m.V = m.V.cast<float>().cast<double>().eval();
  REQUIRE(writeStl(m, temp.path() / "ring.stl"));
  const auto back = read(temp.path() / "ring.stl");
  REQUIRE(back);
  CHECK(back->V.rows() == m.V.rows());
  CHECK(back->F.rows() == m.F.rows());
  CHECK(signedVolume(back->V, back->F) == Approx(signedVolume(m.V, m.F)).epsilon(1e-12));
}

TEST_CASE("a file's unit is applied") {
  const test::TempFolder temp;
  const SurfaceMesh m = test::box({0, 0, 0}, {10, 20, 30});
  REQUIRE(writeObj(m, temp.path() / "box.obj"));
  const auto back = read(temp.path() / "box.obj", 0.01);
  REQUIRE(back);
  CHECK(boundingBox(*back).hi.isApprox(Vector3(0.1, 0.2, 0.3)));
}

TEST_CASE("OBJ: negative indices, polygons, textures, continued lines, foreign line ends") {
  const std::string corners = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
  for (const std::string face : {"f 1 2 3 4\n", "f -4 -3 -2 -1\n", "f 1/1 2/2 3/3 4/4\n",
                                 "f 1//1 2//1 3//1 4//1", "f 1/1/1 2/1/1 3/1/1 4/1/1\n",
                                 "f 1 2 \\\n3 4\n", "f 1 2 3 4 # a quad\n", "  f  1\t2 3  4  \n"}) {
    for (const bool windows : {false, true}) {
      std::string text = corners + face;
      if (windows) {
        for (std::size_t p = 0; (p = text.find('\n', p)) != text.npos; p += 2)
          text.replace(p, 1, "\r\n");
      }
      INFO(text);
      const auto m = readText("quad.obj", text);
      REQUIRE(m);
      CHECK(m->F.rows() == 2);
      CHECK(surfaceArea(m->V, m->F) == Approx(1.0));
      CHECK(m->parts.empty());
    }
  }
  // Old Macintosh line ends; faces before their vertices; numbers with signs, exponents, colours
  const auto mac = readText("tri.obj", "v 0 0 0\rv +1e0 0 0\rv 0 1.E+0 -0.0\rf 1 2 3\r");
  REQUIRE(mac);
  CHECK(surfaceArea(mac->V, mac->F) == Approx(0.5));
  REQUIRE(readText("tri.obj", "f 1 2 3\nv 0 0 0 1 0 0\nv 1 0 0 0.5 0.5 0.5\nv 0 1 0 1 1 1\n"));
}

TEST_CASE(
    "OBJ: objects make the parts where there are two, else groups do, and scattered groups are "
    "gathered") {
  const std::string v = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n";
  const auto groups = readText(
      "a.obj", v + "o leg\ng left femur\nf 1 2 3\ng tibia\nf 1 2 4\ng left femur\nf 2 3 4\n");
  REQUIRE(groups);
  REQUIRE(groups->parts.size() == 2);
  CHECK(groups->parts[0].name == "left femur");
  CHECK(groups->parts[0].faceCount == 2);
  CHECK(groups->parts[1].name == "tibia");
  CHECK(groups->F.row(2) == Eigen::RowVector3i(0, 1, 3));

  const auto objects =
      readText("b.obj", v + "o femur\ng m1\nf 1 2 3\ng m2\nf 1 2 4\no tibia\nf 2 3 4 1\n");
  REQUIRE(objects);
  REQUIRE(objects->parts.size() == 2);
  CHECK(objects->parts[0].name == "femur");
  CHECK(objects->parts[1].faceCount == 2);

  const auto loose = readText("c.obj", v + "f 1 2 3\ng\nf 1 2 4\ng tibia\nf 2 3 4\ng empty\n");
  REQUIRE(loose);
  REQUIRE(loose->parts.size() == 2);
  CHECK(loose->parts[0].name == "default");
  CHECK(loose->parts[0].faceCount == 2);

  SurfaceMesh two = joined({test::box({0, 0, 0}, {1, 1, 1}), test::sphere({3, 0, 0}, 1, 1)}, "two");
  const auto again = readText("two.obj", objText(two));
  REQUIRE(again);
  checkSame(*again, two);
  REQUIRE(again->parts.size() == 2);
  CHECK(again->parts[1].name == "sphere");
  CHECK(again->parts[1].firstFace == 12);
}

TEST_CASE("PLY: text and either byte order say the same, whatever else they hold") {
  const std::string header =
      "element vertex 4\nproperty uchar red\nproperty float x\nproperty double y\nproperty short "
      "z\n"
      "element edge 1\nproperty list uchar short ends\n"
      "element face 2\nproperty uchar flag\nproperty list uchar uint vertex_index\nproperty list "
      "int float texcoord\nend_header\n";
  const auto binary = [&](bool big) {
    std::string out =
        std::string("ply\nformat binary_") + (big ? "big" : "little") + "_endian 1.0\n" + header;
    const auto put = [&](auto x) {
      char b[sizeof x];
      std::memcpy(b, &x, sizeof x);
      if (big) std::reverse(b, b + sizeof x);
      out.append(b, sizeof x);
    };
    const auto vertex = [&](float x, double y, std::int16_t z) {
      put(std::uint8_t{9}), put(x), put(y), put(z);
    };
    vertex(0, 0, 0), vertex(1, 0, 0), vertex(1, 1, 0), vertex(0, 1, 300);
    put(std::uint8_t{2}), put(std::int16_t{0}), put(std::int16_t{1});
    put(std::uint8_t{0}), put(std::uint8_t{3}), put(0u), put(1u), put(2u), put(std::int32_t{1}),
        put(0.5f);
    put(std::uint8_t{0}), put(std::uint8_t{4}), put(0u), put(1u), put(2u), put(3u),
        put(std::int32_t{0});
    return out;
  };
  const std::string text =
      "ply\r\nformat ascii 1.0\r\ncomment by hand\r\n" + header +
      "9 0 0 0\n9 1 0 0\n9 1 1 0\n9 0 1 300\n2 0 1\n0 3 0 1 2 1 0.5\n0 4 0 1 2 3 0\n";
  const auto ascii = readText("a.ply", text);
  REQUIRE(ascii);
  CHECK(ascii->F.rows() == 3);
  CHECK(ascii->V(3, 2) == 300);
  for (const bool big : {false, true}) {
    const auto m = readText("b.ply", binary(big));
    REQUIRE(m);
    checkSame(*m, *ascii);
    const std::string bytes = binary(big);
    for (std::size_t cut = bytes.size() - 1; cut > bytes.size() - 90; cut -= 7) {
      checkBroken({"cut.ply", bytes.substr(0, cut), ErrorCode::FileTruncated, 0});
    }
  }
}

TEST_CASE("STL: text with several solids, odd case, and a binary file that calls itself solid") {
  const std::string facet =
      "facet normal 0 0 1\nOUTER LOOP\nvertex 0 0 0\nVERTEX 1 0 0\nvertex 0 1 "
      "0\nendloop\nendfacet\n";
  const auto one =
      readText("a.stl", "solid tibia left\n" + facet + facet + "endsolid tibia left\n");
  REQUIRE(one);
  CHECK(one->V.rows() == 3);
  CHECK(one->F.rows() == 2);
  CHECK(one->parts.empty());
  const auto two = readText(
      "b.stl", "solid tibia\n" + facet + "endsolid\nsolid\n" + facet + facet + "endsolid\n");
  REQUIRE(two);
  REQUIRE(two->parts.size() == 2);
  CHECK(two->parts[0].name == "tibia");
  CHECK(two->parts[1].faceCount == 2);

  // Exporters call every solid the same; each is a part that can be asked for
  const std::string rib = "solid rib\n" + facet + "endsolid\n";
  const auto ribs = readText("c.stl", rib + rib + "solid rib_2\n" + facet + "endsolid\n" + rib);
  REQUIRE(ribs);
  REQUIRE(ribs->parts.size() == 4);
  CHECK(ribs->parts[0].name == "rib");
  CHECK(ribs->parts[1].name == "rib_3");
  CHECK(ribs->parts[2].name == "rib_2");
  CHECK(ribs->parts[3].name == "rib_4");
  CHECK(ribs->parts[3].firstFace == 3);

  std::string liar = stlBytes(test::box({0, 0, 0}, {1, 1, 1}));
  liar.replace(0, 11, "solid facet");
  CHECK(readText("liar.stl", liar)->F.rows() == 12);
  CHECK(readText("liar.dat", liar)->F.rows() == 12);  // known by its size
  CHECK(readText("more.stl", liar + "trailing")->F.rows() == 12);
}

TEST_CASE("OFF: with and without keyword, colours, comments") {
  const std::string body =
      "4 2 0\n# corners\n0 0 0 255 0 0\n1 0 0\n1 1 0\n0 1 0\n\n3 0 1 2 0.5 0.5 0.5\n3 0 2 3\n";
  for (const std::string head :
       {"OFF\n", "OFF ", "COFF\n", "", "# note\nOFF # three dimensions\n"}) {
    const auto m = readText("a.off", head + body);
    INFO(head);
    REQUIRE(m);
    CHECK(surfaceArea(m->V, m->F) == Approx(1.0));
  }
}

TEST_CASE("content decides before the suffix") {
  const SurfaceMesh m = test::box({0, 0, 0}, {1, 1, 1});
  for (const auto& bytes : {plyBytes(m), offText(m)}) {
    CHECK(readText("wrong.obj", bytes)->F.rows() == 12);
    CHECK(readText("none", bytes)->F.rows() == 12);
  }
  CHECK(readText("none", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")->F.rows() == 1);
  CHECK(isMeshFile("A.STL"));
  CHECK(isMeshFile("b.glb"));
  CHECK_FALSE(isMeshFile("c.txt"));
}

TEST_CASE("files that are not there, empty or something else") {
  const test::TempFolder temp;
  CHECK(read(temp.path() / "no.obj").error().code == ErrorCode::FileMissing);
  CHECK(read(temp.path()).error().code == ErrorCode::FileNotReadable);
  for (const char* name : {"e.obj", "e.ply", "e.stl", "e.off", "e.glb", "e"}) {
    CHECK(readText(name, "").error().code == ErrorCode::FileEmpty);
  }
  const std::string png("\x89PNG\r\n\x1a\n\0\0\0\rIHDR", 16);
  for (const char* name : {"a.obj", "a.ply", "a.off", "a.png", "a"}) {
    checkBroken({name, png, ErrorCode::FileUnknownFormat, 0});
  }
  checkBroken({"a.txt", "Dear Sir,\nplease find enclosed\n", ErrorCode::FileUnknownFormat, 0});
  checkBroken({"a.stl", "Dear Sir,\nplease find enclosed\n", ErrorCode::FileUnknownFormat, 0});
}

TEST_CASE("broken OBJ files name the line") {
  const std::string v = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  for (const Broken& b : std::vector<Broken>{
           {"a.obj", v + "f 1 2 4\n", ErrorCode::FileSyntax, 4},
           {"a.obj", v + "f 1 2 -4\n", ErrorCode::FileSyntax, 4},
           {"a.obj", v + "f 1 2 0\n", ErrorCode::FileSyntax, 4},
           {"a.obj", v + "f 1 2 x\n", ErrorCode::FileSyntax, 4},
           {"a.obj", v + "f 1 2 3.5\n", ErrorCode::FileSyntax, 4},
           {"a.obj", v + "f 1 2 99999999999999999999\n", ErrorCode::FileSyntax, 4},
           {"a.obj", v + "f 1 2\nf 1 2 3\n", ErrorCode::FileSyntax, 4},
           {"a.obj", "v 0 0\n" + v, ErrorCode::FileSyntax, 1},
           {"a.obj", "v 0 0 zero\n" + v, ErrorCode::FileSyntax, 1},
           {"a.obj", "v 0,5 0 0\n" + v, ErrorCode::FileSyntax, 1},
           {"a.obj", v + "v 0 0 \\\n zero\n", ErrorCode::FileSyntax, 4},
           {"a.obj", v + "v 0 0 \\\n 1\nf 1 2 9 \n", ErrorCode::FileSyntax, 6},
           {"a.obj", v + "f 1 2 3\n{json}\n", ErrorCode::FileSyntax, 5},
           {"a.obj", v + "f 1 2 3\nf 1 2", ErrorCode::FileTruncated, 5},
           {"a.obj", v + "f 1 2 3\nv 0.25", ErrorCode::FileTruncated, 5},
           {"a.obj", v, ErrorCode::MeshWithoutFaces, 0},
           {"a.obj", "# nothing\n", ErrorCode::MeshWithoutFaces, 0},
           {"a.obj", v + "v nan 0 0\nf 1 2 3\n", ErrorCode::NonFiniteVertex, 4},
           {"a.obj", v + "v 0 -inf 0\nf 1 2 3\n", ErrorCode::NonFiniteVertex, 4},
           {"a.obj", v + "v 0 0 1e999\nf 1 2 3\n", ErrorCode::NonFiniteVertex, 4}}) {
    checkBroken(b);
  }
  CHECK(readText("a.obj", v + "f 1 2 3\nv 1e-999 0 0\n")->V(3, 0) == 0.0);
  CHECK_THAT(readText("a.obj", v + "v nan 0 0\nf 1 2 3\n").error().message,
             Catch::Contains("vertex 4"));
}

TEST_CASE("broken OFF files name the line") {
  for (const Broken& b : std::vector<Broken>{
           {"a.off", "OFF\n", ErrorCode::FileTruncated, 1},
           {"a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n", ErrorCode::FileTruncated, 4},
           {"a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n", ErrorCode::FileTruncated, 5},
           {"a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1", ErrorCode::FileTruncated, 6},
           {"a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n", ErrorCode::FileSyntax, 6},
           {"a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n2 0 1\n", ErrorCode::FileSyntax, 6},
           {"a.off", "OFF\n3 1 0\n0 0 0\n1 0\n0 1 0\n3 0 1 2\n", ErrorCode::FileSyntax, 4},
           {"a.off", "OFF\n3 1 0\n0 0 0\n1 0 nan\n0 1 0\n3 0 1 2\n", ErrorCode::NonFiniteVertex, 4},
           {"a.off", "OFF\n-3 1 0\n", ErrorCode::FileSyntax, 2},
           {"a.off", "OFF\n99999999999 1 0\n", ErrorCode::FileSyntax, 2},
           {"a.off", "OFF\n2000000000 2000000000 0\n", ErrorCode::FileTruncated, 2},
           {"a.off", "4OFF\n3 1 0\n", ErrorCode::FileSyntax, 1},
           {"a.off", "OFF BINARY\n\1\2\3", ErrorCode::FileSyntax, 1},
           {"a.off", "OFF\n0 0 0\n", ErrorCode::MeshWithoutFaces, 0}}) {
    checkBroken(b);
  }
}

TEST_CASE("broken PLY files name the line where there are lines") {
  const std::string head =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float "
      "z\n"
      "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
  for (const Broken& b : std::vector<Broken>{
           {"a.ply", head + "0 0 0\n1 0 0\n", ErrorCode::FileTruncated, 11},
           {"a.ply", head + "0 0 0\n1 0 0\n0 1 0\n3 0 1", ErrorCode::FileTruncated, 13},
           {"a.ply", head + "0 0 0\n1 0\n0 1 0\n3 0 1 2\n", ErrorCode::FileSyntax, 11},
           {"a.ply", head + "0 0 0\n1 0 nan\n0 1 0\n3 0 1 2\n", ErrorCode::NonFiniteVertex, 11},
           {"a.ply", head + "0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n", ErrorCode::FileSyntax, 13},
           {"a.ply", head + "0 0 0\n1 0 0\n0 1 0\n3 0 1 -1\n", ErrorCode::FileSyntax, 13},
           {"a.ply", head + "0 0 0\n1 0 0\n0 1 0\n3 0 1 0.5\n", ErrorCode::FileSyntax, 13},
           {"a.ply", head + "0 0 0\n1 0 0\n0 1 0\n2 0 1\n", ErrorCode::FileSyntax, 13},
           {"a.ply", head + "0 0 0\n1 0 0\n0 1 0\nnan\n", ErrorCode::FileSyntax, 13},
           // Vertices that are announced and never come
           {"a.ply",
            "ply\nformat ascii 1.0\nelement vertex 3\nelement face 1\nproperty list uchar int "
            "vertex_indices\nend_header\n3 0 1 2\n",
            ErrorCode::FileSyntax, 6},
           {"a.ply",
            "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float "
            "y\nproperty float z\nelement vertex 3\nproperty float x\nelement face 1\nproperty "
            "list uchar int vertex_indices\nend_header\n0 0 0\n1\n2\n3\n3 0 1 2\n",
            ErrorCode::FileSyntax, 16},
           {"a.ply", head.substr(0, 60), ErrorCode::FileTruncated, 5},
           {"a.ply", "ply\nformat utf8 1.0\nend_header\n", ErrorCode::FileSyntax, 2},
           {"a.ply", "ply\nelement vertex 0\nend_header\n", ErrorCode::FileSyntax, 3},
           {"a.ply", "ply\nformat ascii 1.0\nproperty float x\n", ErrorCode::FileSyntax, 3},
           {"a.ply", "ply\nformat ascii 1.0\nelement vertex -1\n", ErrorCode::FileSyntax, 3},
           {"a.ply", "ply\nformat ascii 1.0\nelement vertex 3\nproperty quad x\n",
            ErrorCode::FileSyntax, 4},
           {"a.ply", "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n0\n",
            ErrorCode::FileSyntax, 5},
           {"a.ply", "ply\nformat ascii 1.0\nhello\n", ErrorCode::FileSyntax, 3},
           {"a.ply", "ply\nformat ascii 1.0\nend_header\n", ErrorCode::MeshWithoutFaces, 0}}) {
    checkBroken(b);
  }
}

TEST_CASE("broken STL files") {
  const std::string facet =
      "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 "
      "0\nendloop\nendfacet\n";
  const std::string binary = stlBytes(test::box({0, 0, 0}, {1, 1, 1}));
  std::string infinite = binary;
  const float inf = std::numeric_limits<float>::infinity();
  std::memcpy(infinite.data() + 84 + 50 * 3 + 12 + 4, &inf, sizeof inf);
  std::string none = binary.substr(0, 84);
  std::memset(none.data() + 80, 0, 4);
  for (const Broken& b : std::vector<Broken>{
           {"a.stl", "solid a\n" + facet, ErrorCode::FileTruncated, 8},
           {"a.stl", "solid a\n" + facet.substr(0, 40), ErrorCode::FileTruncated, 4},
           {"a.stl", "solid a\n" + facet.substr(0, 52), ErrorCode::FileTruncated, 5},
           {"a.stl", "solid a\nendsolid a\n", ErrorCode::MeshWithoutFaces, 0},
           {"a.stl", "solid a\nvertex 0 0 0\nendsolid\n", ErrorCode::FileSyntax, 2},
           {"a.stl",
            "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nendloop\n",
            ErrorCode::FileSyntax, 6},
           {"a.stl", "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 inf\n",
            ErrorCode::NonFiniteVertex, 4},
           {"a.stl", "solid a\n" + facet + "endsolid\n" + facet, ErrorCode::FileSyntax, 10},
           {"a.stl", "solid a\nsolid b\n", ErrorCode::FileSyntax, 2},
           {"a.stl", "solid a\nhello\n", ErrorCode::FileSyntax, 2},
           {"a.stl", binary.substr(0, binary.size() - 1), ErrorCode::FileTruncated, 0},
           {"a.stl", binary.substr(0, 90), ErrorCode::FileTruncated, 0},
           {"a.stl", none.substr(0, 82), ErrorCode::FileTruncated, 0},
           {"a.stl", none, ErrorCode::MeshWithoutFaces, 0},
           {"a.stl", infinite, ErrorCode::NonFiniteVertex, 0}}) {
    checkBroken(b);
  }
  CHECK_THAT(readText("a.stl", infinite).error().message, Catch::Contains("triangle 4"));
}

TEST_CASE("reading can be interrupted") {
  RunContext run;
  run.cancel();
  const test::TempFolder temp;
  const SurfaceMesh m = test::sphere({0, 0, 0}, 1, 7);  // 164 k vertices, 328 k faces
  REQUIRE(writeObj(m, temp.path() / "a.obj"));
  REQUIRE(writePly(m, temp.path() / "a.ply"));
  REQUIRE(writeOff(m, temp.path() / "a.off"));
  REQUIRE(writeStl(m, temp.path() / "a.stl"));
  for (const char* file : {"a.obj", "a.ply", "a.off", "a.stl"}) {
    INFO(file);
    CHECK(readMesh(temp.path() / file, {}, run).error().code == ErrorCode::Cancelled);
  }
}

TEST_CASE("welding merges exactly equal points only, and zero has no sign") {
  SurfaceMesh m;
  m.V.resize(6, 3);
  m.V << 0, 0, 0, 1, 0, 0, 0, 1, 0, -0.0, 0, -0.0, 1 + 1e-15, 0, 0, 0, 1, 0;
  m.F.resize(2, 3);
  m.F << 0, 1, 2, 3, 5, 4;
  const SurfaceMesh welded = weldExact(m);
  CHECK(welded.V.rows() == 4);
  CHECK(welded.F.row(1) == Eigen::RowVector3i(0, 2, 3));
}

TEST_CASE("the dog's bones read as they are described") {
  if (!test::haveData("dog")) return;
  int count = 0;
  for (const auto& entry : fs::directory_iterator(test::dataFolder() / "dog" / "bones")) {
    const auto m = read(entry.path());
    INFO(entry.path());
    REQUIRE(m);
    CHECK(boundingBox(*m).diagonal() < 2.0);
    ++count;
  }
  CHECK(count == 172);
  const auto skin = read(test::dataFolder() / "dog" / "SKINbody.stl");
  REQUIRE(skin);
  CHECK(skin->V.rows() == 16952);
  CHECK(skin->F.rows() == 33900);
}

TEST_CASE("MakeHuman's body is a group of quads") {
  if (!test::haveData("makehuman/base.obj")) return;
  const auto m = read(test::dataFolder() / "makehuman" / "base.obj", 0.1);
  REQUIRE(m);
  const auto body = std::ranges::find(m->parts, "body", &Part::name);
  REQUIRE(body != m->parts.end());
  const SurfaceMesh skin = partOf(*m, static_cast<std::size_t>(body - m->parts.begin()));
  CHECK(skin.V.rows() == 13380);
  CHECK(skin.F.rows() == 2 * (13380 - 2));  // genus 0
  CHECK(boundingBox(skin).diagonal() > 1.5);
  CHECK(boundingBox(skin).diagonal() < 3.0);
}
