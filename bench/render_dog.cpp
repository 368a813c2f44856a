// Pictures of the dog as an artist modelled it, timed: a stand-in for our own muscles, and a look
// at light and colour.
//
//   bench_render_dog [whole|hind|bare|slice] [VIEW] [OUT.png]       ECORCHE_DATA names the folder
//   of dog/
#include <ecorche/core/run_context.h>
#include <ecorche/mesh/read_mesh.h>
#include <ecorche/render/anatomy_scene.h>
#include <ecorche/render/image.h>
#include <ecorche/render/palette.h>
#include <ecorche/render/renderer.h>
#include <ecorche/render/views.h>
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>

using namespace ecorche;
namespace fs = std::filesystem;

namespace {

using MeshPtr = std::shared_ptr<const mesh::SurfaceMesh>;

std::vector<MeshPtr> readFolder(const fs::path& folder, bool hindOnly) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder)) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  std::vector<MeshPtr> meshes;
  for (const fs::path& file : files) {
    if (file.filename().string().find("ascia") != std::string::npos)
      continue;  // sheets over everything
    RunContext run;
    auto mesh = mesh::readMesh(file, {}, run);
    if (!mesh) {
      fmt::print(stderr, "{}\n", mesh.error().text());
      continue;
    }
    const mesh::Box box = mesh::boundingBox(*mesh);
    if (hindOnly && (box.centre().x() > -0.17 || box.centre().y() < -0.01)) continue;
    meshes.push_back(std::make_shared<mesh::SurfaceMesh>(std::move(*mesh)));
  }
  return meshes;
}

}  // namespace

int main(int argc, char** argv) {
  const std::string what = argc > 1 ? argv[1] : "whole";
  const std::string viewText = argc > 2 ? argv[2] : "left";
  const std::string out = argc > 3 ? argv[3] : "dog.png";
  const char* data = std::getenv("ECORCHE_DATA");
  const fs::path dog = fs::path(data ? data : "../shared/data") / "dog";

  const auto view = render::parseView(viewText);
  if (!view) {
    fmt::print(stderr, "{}\n", view.error().text());
    return 2;
  }
  render::Scene scene;
  const bool hind = what == "hind";
  const std::vector<MeshPtr> muscles = readFolder(dog / "muscles", hind);
  const std::vector<MeshPtr> bones = readFolder(dog / "bones", hind);
  std::vector<const mesh::SurfaceMesh*> raw;
  std::vector<std::string> names;
  Eigen::Index triangles = 0;
  for (const MeshPtr& m : muscles) {
    raw.push_back(m.get());
    names.push_back(m->name);
  }
  const auto palette =
      std::getenv("DISTINCT") ? render::Palette::Distinct : render::Palette::Anatomical;
  const auto colours =
      render::tissueColours(static_cast<std::int32_t>(muscles.size()),
                            render::nearSurfaces(raw, 0.006), palette, render::sideTwins(names));
  for (std::size_t i = 0; i < muscles.size(); ++i) {
    scene.surfaces.push_back(render::surfaceItem(render::Material::Muscle, muscles[i], colours[i]));
    triangles += muscles[i]->F.rows();
  }
  for (const MeshPtr& m : bones) {
    scene.surfaces.push_back(render::surfaceItem(render::Material::Bone, m));
    triangles += m->F.rows();
  }

  render::PictureOptions options;
  if (const char* samples = std::getenv("SAMPLES")) options.samples = std::atoi(samples);
  if (const char* lights = std::getenv("LIGHTS")) options.lightsPerPass = std::atoi(lights);
  if (std::getenv("GROUND")) options.ground = mesh::Vector3::UnitZ();
  options.gradient = std::getenv("GRADIENT") != nullptr;
  const double aspect = static_cast<double>(options.width) / options.height;
  if (what == "slice") scene.clip = render::ClipPlane{{-0.28, 0.0, 0.0}, -mesh::Vector3::UnitX()};
  const render::Scene model = scene;
  if (what != "bare") {
    RunContext run;
    auto skin = mesh::readMesh(dog / "SKINbody.stl", {}, run);
    if (skin)
      scene.surfaces.push_back(render::surfaceItem(
          render::Material::Skin, std::make_shared<mesh::SurfaceMesh>(std::move(*skin))));
  }
  const render::Camera camera = render::framed(*view, {}, hind ? model : scene, aspect, 0.04);

  const auto start = std::chrono::steady_clock::now();
  RunContext run;
  const auto image = render::renderPicture(scene, camera, options, run);
  if (!image) {
    fmt::print(stderr, "{}\n", image.error().text());
    return 1;
  }
  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  fmt::print("{} surfaces, {} opaque triangles, {}×{}, {} passes: {:.2f} s\n",
             scene.surfaces.size(), triangles, options.width, options.height, options.samples,
             seconds);
  const auto written = render::writePng(out, *image);
  if (!written) fmt::print(stderr, "{}\n", written.error().text());
  return written ? 0 : 1;
}
