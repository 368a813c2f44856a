#include <ecorche/mesh/import_file.h>
#include <ecorche/mesh/read_mesh.h>

#include <catch2/catch.hpp>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <random>

#include "support/paths.h"
#include "support/shapes.h"

using namespace ecorche;
using namespace ecorche::mesh;
namespace fs = std::filesystem;

namespace {

// readMesh with a pretended worker that runs this script; $3 is where the result goes.
Result<SurfaceMesh> readWith(const std::string& script, const std::string& payload = "") {
  const test::TempFolder temp;
  const fs::path worker = temp.path() / "worker";
  std::ofstream(temp.path() / "payload", std::ios::binary) << payload;
  std::ofstream(worker) << "#!/bin/sh\nPAYLOAD=" << (temp.path() / "payload").string() << "\n"
                        << script << "\n";
  fs::permissions(worker, fs::perms::owner_all);
  std::ofstream(temp.path() / "leg.glb") << "glTF and more";
  setenv("ECORCHE_WORKER", worker.c_str(), 1);
  RunContext run;
  auto mesh = readMesh(temp.path() / "leg.glb", {}, run);
  unsetenv("ECORCHE_WORKER");
  return mesh;
}

Result<SurfaceMesh> imported(const fs::path& file) {
  RunContext run;
  return readMesh(file, {}, run);
}

std::string gltf(const std::string& nodes) {
  // One right triangle, 32-bit: positions (0,0,0) (1,0,0) (0,1,0)
  return R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":)" + nodes +
         R"(,"meshes":[{"name":"tri","primitives":[{"attributes":{"POSITION":0}}]}],
      "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}],
      "bufferViews":[{"buffer":0,"byteLength":36}],
      "buffers":[{"byteLength":36,"uri":"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}]})";
}

}  // namespace

TEST_CASE("an import file comes back as it was, and any damage is noticed") {
  SurfaceMesh m = joined({test::box({0, 0, 0}, {1, 1, 1}), test::sphere({3, 0, 0}, 1, 1)}, "leg");
  const std::string bytes = encodeImport(m);
  const auto back = decodeImport(bytes);
  REQUIRE(back);
  CHECK(back->V == m.V);
  CHECK(back->F == m.F);
  CHECK(back->parts.size() == 2);
  CHECK(back->name == "leg");
  for (std::size_t size = 0; size < bytes.size(); size += 13)
    CHECK_FALSE(decodeImport(bytes.substr(0, size)));
  CHECK_FALSE(decodeImport(bytes + "x"));

  SurfaceMesh wrong = m;
  wrong.F(3, 1) = static_cast<std::int32_t>(m.V.rows());
  CHECK(decodeImport(encodeImport(wrong)).error().code == ErrorCode::FileSyntax);
  wrong.F(3, 1) = -1;
  CHECK(decodeImport(encodeImport(wrong)).error().code == ErrorCode::FileSyntax);
  wrong = m;
  wrong.parts[1].faceCount += 1;
  CHECK(decodeImport(encodeImport(wrong)).error().code == ErrorCode::FileSyntax);
  wrong = m;
  wrong.parts[1].firstFace += 1;
  CHECK(decodeImport(encodeImport(wrong)).error().code == ErrorCode::FileSyntax);

  // Flipped bits anywhere: a mesh that keeps the promises, or an error
  std::mt19937 random(5);
  for (int trial = 0; trial < 2000; ++trial) {
    std::string damaged = bytes;
    for (int k = 0; k < 3; ++k)
      damaged[random() % damaged.size()] ^= static_cast<char>(1 << random() % 8);
    const auto read = decodeImport(damaged);
    if (read && read->F.size() > 0) {
      REQUIRE(read->F.minCoeff() >= 0);
      REQUIRE(read->F.maxCoeff() < read->V.rows());
    }
  }
}

TEST_CASE(
    "a worker that crashes, hangs up, lies or sends garbage gives an error that names the file") {
  const auto refuses = [](const std::string& script, ErrorCode code,
                          const std::string& payload = "") {
    const auto mesh = readWith(script, payload);
    INFO(script);
    REQUIRE_FALSE(mesh);
    CHECK(name(mesh.error().code) == name(code));
    CHECK_THAT(mesh.error().text(), Catch::Contains("leg.glb"));
  };
  refuses("kill -SEGV $$", ErrorCode::WorkerCrashed);
  refuses("exit 0", ErrorCode::WorkerCrashed);
  refuses("exit 7", ErrorCode::WorkerCrashed);
  refuses("echo error FileSyntax no glTF >&2; exit 1", ErrorCode::FileSyntax);
  refuses("head -c 1000 /dev/zero > $3", ErrorCode::FileTruncated);
  refuses("echo hello > $3", ErrorCode::FileTruncated);

  SurfaceMesh m = test::box({0, 0, 0}, {1, 1, 1});
  CHECK(readWith("cp $PAYLOAD $3", encodeImport(m))->F.rows() == 12);
  m.V(2, 1) = std::nan("");
  refuses("cp $PAYLOAD $3", ErrorCode::NonFiniteVertex, encodeImport(m));
  m = SurfaceMesh{};
  refuses("cp $PAYLOAD $3", ErrorCode::MeshWithoutFaces, encodeImport(m));
}

TEST_CASE("without a worker, foreign formats are refused and ours are read") {
  const test::TempFolder temp;
  std::ofstream(temp.path() / "leg.glb") << "glTF";
  setenv("ECORCHE_WORKER", "/no/such/worker", 1);
  CHECK(imported(temp.path() / "leg.glb").error().code == ErrorCode::WorkerMissing);
  unsetenv("ECORCHE_WORKER");
}

TEST_CASE("glTF: transforms of nodes are applied, each node is a part") {
  const test::TempFolder temp;
  std::ofstream(temp.path() / "a.gltf") << gltf(
      R"([{"name":"root","scale":[2,2,2],"children":[1,2]},
          {"name":"femur","mesh":0,"translation":[1,0,0]},
          {"name":"mirror","scale":[-1,1,1],"children":[3]},
          {"name":"tibia","mesh":0}])");
  const auto m = imported(temp.path() / "a.gltf");
  INFO((m ? "" : m.error().text()));
  REQUIRE(m);
  REQUIRE(m->parts.size() == 2);
  CHECK(m->parts[0].name == "femur");
  CHECK(m->parts[1].name == "tibia");
  const Box femur = boundingBox(partOf(*m, 0));
  CHECK(femur.lo.isApprox(Vector3(2, 0, 0)));
  CHECK(femur.hi.isApprox(Vector3(4, 2, 0)));
  CHECK(boundingBox(partOf(*m, 1)).lo.isApprox(Vector3(-2, 0, 0)));
  // A mirrored node still faces the way it was modelled: both triangles look along +z
  CHECK(vertexNormals(m->V, m->F).col(2).minCoeff() > 0.99);
}

TEST_CASE("glTF that is cut or garbage is an error") {
  const test::TempFolder temp;
  const std::string whole = gltf(R"([{"name":"femur","mesh":0}])");
  for (const std::size_t size : {std::size_t{20}, whole.size() / 2, whole.size() - 2}) {
    std::ofstream(temp.path() / "a.gltf") << whole.substr(0, size);
    const auto m = imported(temp.path() / "a.gltf");
    REQUIRE_FALSE(m);
    CHECK(m.error().code == ErrorCode::FileSyntax);
  }
  std::ofstream(temp.path() / "b.glb") << "glTF\2\0\0\0";
  CHECK(imported(temp.path() / "b.glb").error().code == ErrorCode::FileSyntax);
}

TEST_CASE("the Visible Human's skin and knees come through the worker") {
  if (!test::haveData("hra_male")) return;
  const fs::path folder = test::dataFolder() / "hra_male";
  const auto skin = imported(folder / "VH_M_Skin.glb");
  REQUIRE(skin);
  CHECK(skin->V.rows() == 53669);
  CHECK(skin->F.rows() == 107334);
  CHECK(boundingBox(*skin).diagonal() > 1.5);

  const auto pelvis = imported(folder / "VH_M_Pelvis.glb");
  REQUIRE(pelvis);
  const auto hasBone = [](const Part& p) { return p.name.find("compact_bone") != p.name.npos; };
  CHECK(std::ranges::any_of(pelvis->parts, hasBone));

  // All files of the set stand in one frame: the knee is inside the skin
  const auto knee = imported(folder / "VH_M_Knee_L.glb");
  REQUIRE(knee);
  const Box inner = boundingBox(*knee);
  const Box outer = boundingBox(*skin);
  CHECK((inner.lo.array() > outer.lo.array()).all());
  CHECK((inner.hi.array() < outer.hi.array()).all());
}
