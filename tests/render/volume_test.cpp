#include <ecorche/render/offscreen.h>
#include <ecorche/render/ray_caster.h>
#include <ecorche/render/renderer.h>
#include <ecorche/render/views.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>
#include <utility>

#include "render/scenes.h"
#include "render/volumes.h"
#include "support/generated_anatomy.h"
#include "support/generated_domain.h"

using namespace ecorche;
using mesh::Vector3;

namespace {

render::Renderer freshRenderer() {
  auto renderer = render::Renderer::create();
  if (!renderer) FAIL(renderer.error().text());
  return std::move(*renderer);
}

// One renderer for a whole test: what it holds from the last picture must not show in the next.
struct Card {
  render::OffscreenContext context;
  render::Renderer renderer;

  static Card make() {
    auto context = render::OffscreenContext::create();
    if (!context) FAIL(context.error().text());
    return {std::move(*context), freshRenderer()};
  }

  render::TissueImage draw(const render::VolumeItem& item,
                           const std::optional<render::ClipPlane>& clip,
                           const render::Camera& camera, int width, int height) {
    render::Scene scene;
    scene.volume = item;
    scene.clip = clip;
    auto options = test::plainOptions(width, height);
    options.samples = 1;
    options.lightsPerPass = 4;
    options.shadowMapSize = 64;
    const auto ok = renderer.begin(scene, camera, options);
    if (!ok) FAIL(ok.error().text());
    renderer.pass();
    return renderer.readTissues();
  }
};

// Three sides, whole and cut, all tissues and some hidden: the card against the ray caster.
void checkAgainstRays(Card& card, render::VolumeItem item, std::uint64_t seed, int size,
                      double least) {
  std::mt19937_64 random(seed);
  for (const bool someHidden : {false, true}) {
    for (std::size_t i = 1; i < item.tissues.size(); ++i) {
      item.tissues[i].visible = !someHidden || (random() & 1u) != 0;
      item.tissues[i].inCut = item.tissues[i].visible || (random() & 1u) != 0;
    }
    for (const bool cut : {false, true}) {
      std::optional<render::ClipPlane> clip;
      if (cut)
        clip = {item.geometry->box().centre() +
                    0.01 * item.geometry->box().diagonal() * Vector3(0.3, 0.1, -0.7),
                Vector3(0.7, -0.5, 0.4)};
      int view = 0;
      for (const auto& [azimuth, elevation, fov] :
           {std::tuple(20.0, 15.0, 24.0), std::tuple(140.0, -25.0, 50.0),
            std::tuple(265.0, 60.0, 0.0)}) {
        INFO("hidden " << someHidden << ", cut " << cut << ", view " << view++);
        const render::Camera camera = test::cameraOn(item, azimuth, elevation, fov);
        const auto drawn = card.draw(item, clip, camera, size, size);
        const auto rays = render::castImage(camera, size, size, item, clip);
        const auto a = render::agreement(drawn, rays);
        INFO(a.pixels << " pixels, same " << a.sameTissue << ", of seen " << a.sameSeen
                      << ", normals " << a.normalsClose << ", p95 " << a.normalP95Deg);
        CHECK(a.sameTissue >= least);
        CHECK(a.normalsClose >= 0.95);
      }
    }
  }
}

}  // namespace

TEST_CASE("the card names the tissues that rays meet: smooth fields on every shape") {
  Card card = Card::make();
  int shapes = 0;
  for (std::uint64_t seed = 0; seed < 63; ++seed) {
    const auto anatomy = test::generatedAnatomy(seed);
    if (!anatomy.smooth) continue;
    ++shapes;
    INFO(anatomy.name);
    checkAgainstRays(card, test::volumeItem(anatomy), seed, 96, 0.995);
  }
  CHECK(shapes >= 3);
}

namespace {

// Muscles in a box, fine enough that an edit of one is local.
render::VolumeItem manyMuscles() {
  const auto domain = test::boxDomain({.cells = {24, 24, 24}, .jitter = 0.2});
  return test::volumeItem(domain, test::benchFields(domain.mesh.V, 12, 3), true);
}

// The item with its field of column 5 scaled about a place, and where that changed something.
render::VolumeItem edited(const render::VolumeItem& before, double radius) {
  render::VolumeItem after = before;
  auto values = std::make_shared<tissue::FieldMatrix>(*before.fields);
  auto changed = std::make_shared<render::FieldChange>();
  changed->columns = {5};
  const mesh::Positions& V = before.geometry->mesh().V;
  for (Eigen::Index v = 0; v < V.rows(); ++v) {
    const double away = (V.row(v).transpose() - Vector3(0.4, 0.5, 0.45)).norm();
    if (away >= radius) continue;
    (*values)(v, 5) += 0.4 * (1.0 - away / radius);
    changed->vertices.push_back(static_cast<std::int32_t>(v));
  }
  after.fields = values;
  after.changed = changed;
  ++after.fieldsRevision;
  return after;
}

}  // namespace

TEST_CASE("after an edit the picture is the one that a new renderer draws") {
  Card card = Card::make();
  const render::VolumeItem before = manyMuscles();
  const render::Camera camera = test::cameraOn(before, 30.0, 20.0);
  card.draw(before, {}, camera, 160, 160);
  render::VolumeItem item = before;
  for (const double radius : {0.3, 0.15, 0.5}) {
    item = edited(item, radius);
    const auto kept = card.draw(item, {}, camera, 160, 160);
    render::Renderer used = std::exchange(card.renderer, freshRenderer());
    const auto anew = card.draw(item, {}, camera, 160, 160);
    card.renderer = std::move(used);
    const auto a = render::agreement(kept, anew);
    CHECK(a.sameTissue == 1.0);
    CHECK(a.normalP95Deg == 0.0);
  }
}

TEST_CASE("what was prepared elsewhere is drawn as what the renderer makes itself") {
  Card card = Card::make();
  render::VolumeItem item = manyMuscles();
  const render::Camera camera = test::cameraOn(item, 30.0, 20.0);
  const render::ClipPlane cut{item.geometry->box().centre(), Vector3(0.7, -0.5, 0.4)};
  const auto same = [&](const render::VolumeItem& given,
                        const std::optional<render::ClipPlane>& clip) {
    const auto kept = card.draw(given, clip, camera, 96, 96);
    render::Renderer used = std::exchange(card.renderer, freshRenderer());
    render::VolumeItem bare = given;
    bare.prepared = nullptr;
    const auto anew = card.draw(bare, clip, camera, 96, 96);
    card.renderer = std::move(used);
    const auto a = render::agreement(kept, anew);
    CHECK(a.pixels > 500);
    CHECK(a.sameTissue == 1.0);
    CHECK(a.normalP95Deg == 0.0);
  };
  card.draw(item, {}, camera, 96, 96);  // the renderer has others already
  item = edited(item, 0.3);
  item.prepared = render::prepareVolume(item, {});
  same(item, {});
  same(edited(item, 0.2), {});  // goes on from there
  // Something was hidden, and a plane came, while it was being made
  item.prepared = render::prepareVolume(item, {});
  item.tissues[3].visible = false;
  same(item, cut);
}

TEST_CASE("tets far smaller than a pixel are met by the same rays") {
  Card card = Card::make();
  checkAgainstRays(card, manyMuscles(), 4, 12, 0.995);
  checkAgainstRays(card, manyMuscles(), 5, 31, 0.995);
}

TEST_CASE("an edit sends what changed, a turn of the view sends no content") {
  Card card = Card::make();
  const render::VolumeItem before = manyMuscles();
  const render::Camera camera = test::cameraOn(before, 30.0, 20.0);
  card.draw(before, {}, camera, 64, 64);
  const double whole = static_cast<double>(card.renderer.volumeUploads().content);
  CHECK(whole > 0.0);
  card.draw(before, {}, test::cameraOn(before, 70.0, -20.0), 64, 64);
  CHECK(card.renderer.volumeUploads().content == 0);

  double last = 0.0;
  render::VolumeItem item = before;
  for (const double radius : {0.08, 0.16, 0.32}) {
    item = edited(before, radius);
    item.fieldsRevision = 2;
    card.draw(item, {}, camera, 64, 64);
    const auto sent = static_cast<double>(card.renderer.volumeUploads().content);
    const double share = static_cast<double>(item.changed->vertices.size()) /
                         static_cast<double>(before.fields->rows());
    INFO("radius " << radius << ": " << share << " of vertices, " << sent / whole << " of bytes");
    CHECK(sent > last);
    // Normals look two vertices further, so a small edit sends more than its share
    CHECK(sent < whole * (3.0 * share + 0.06));
    last = sent;
    render::VolumeItem again = before;
    again.fieldsRevision = 1;
    card.draw(again, {}, camera, 64, 64);
  }
}

TEST_CASE("moving the clip plane or hiding a muscle gives the picture that a new renderer draws") {
  Card card = Card::make();
  render::VolumeItem item = manyMuscles();
  const render::Camera camera = test::cameraOn(item, 30.0, 20.0);
  card.draw(item, {}, camera, 120, 120);
  const auto check = [&](const std::optional<render::ClipPlane>& clip) {
    const auto kept = card.draw(item, clip, camera, 120, 120);
    render::Renderer used = std::exchange(card.renderer, freshRenderer());
    const auto anew = card.draw(item, clip, camera, 120, 120);
    card.renderer = std::move(used);
    CHECK(render::agreement(kept, anew).sameTissue == 1.0);
    const auto a = render::agreement(kept, render::castImage(camera, 120, 120, item, clip));
    CHECK(a.sameTissue >= 0.995);
  };
  check(render::ClipPlane{{0.3, 0.5, 0.5}, Vector3(1.0, 0.3, 0.2)});
  check(render::ClipPlane{{0.6, 0.5, 0.5}, Vector3(1.0, 0.3, 0.2)});
  item.tissues[5].visible = item.tissues[7].visible = false;
  check(render::ClipPlane{{0.6, 0.5, 0.5}, Vector3(1.0, 0.3, 0.2)});
  check({});
}

TEST_CASE(
    "where no muscle owns anything nothing is seen, before muscles come and after they went") {
  Card card = Card::make();
  render::VolumeItem item = manyMuscles();
  const auto muscles = item.fields;
  const render::Camera camera = test::cameraOn(item, 30.0, 20.0);
  const auto show = [&](std::shared_ptr<const tissue::FieldMatrix> fields) {
    item.fields = std::move(fields);
    item.fieldsRevision += 2;  // not an edit of what is shown: everything is sent anew
    return card.draw(item, {}, camera, 64, 64);
  };
  auto fatAlone = std::make_shared<tissue::FieldMatrix>(*muscles);
  fatAlone->rightCols(fatAlone->cols() - 1).setZero();
  const auto checkEmpty = [&] {
    CHECK(std::ranges::all_of(show(fatAlone).tissue, [](TissueId id) { return id == kNoTissue; }));
  };
  checkEmpty();
  checkEmpty();
  const auto seen = show(muscles);
  CHECK(render::agreement(seen, render::castImage(camera, 64, 64, item)).sameTissue >= 0.995);
  checkEmpty();
  CHECK(render::agreement(show(muscles), seen).sameTissue == 1.0);
}

TEST_CASE("an exploded muscle is drawn whole where it was moved to") {
  Card card = Card::make();
  render::VolumeItem item = manyMuscles();
  for (std::size_t i = 1; i < item.tissues.size(); ++i)
    item.tissues[i].shift = 0.3 * Vector3(std::sin(2.0 * i), std::cos(2.0 * i), 0.1 * i - 0.6);
  render::Camera camera = test::cameraOn(item, 30.0, 20.0, 40.0);
  const auto drawn = card.draw(item, {}, camera, 160, 160);
  const auto a = render::agreement(drawn, render::castImage(camera, 160, 160, item));
  INFO(a.sameTissue << ", normals " << a.normalsClose);
  CHECK(a.sameTissue >= 0.995);
  CHECK(a.normalsClose >= 0.95);
}

TEST_CASE("an x-rayed muscle lets the others through and is still seen") {
  Card card = Card::make();
  render::VolumeItem item = manyMuscles();
  const render::Camera camera = test::cameraOn(item, 30.0, 20.0);
  const auto solid = card.draw(item, {}, camera, 120, 120);
  // The muscle that covers most of the picture
  std::vector<int> count(item.tissues.size() + 1, 0);
  for (const TissueId t : solid.tissue) count[static_cast<std::size_t>(t.value)] += t.value > 1;
  const auto front = static_cast<std::size_t>(std::ranges::max_element(count) - count.begin()) - 1;
  const auto picture = [&](const render::VolumeItem& what) {
    render::Scene scene;
    scene.volume = what;
    auto options = test::plainOptions(120, 120);
    options.motion = true;
    REQUIRE(card.renderer.begin(scene, camera, options));
    card.renderer.pass();
    return card.renderer.read();
  };
  render::VolumeItem gone = item;
  gone.tissues[front].visible = false;
  render::VolumeItem glass = item;
  glass.tissues[front].opacity = 0.3f;
  const auto without = picture(gone);
  const auto through = picture(glass);
  const auto seen = card.draw(glass, {}, camera, 120, 120);
  const auto behind = card.draw(gone, {}, camera, 120, 120);
  // What is opaque is what is left without it
  CHECK(render::agreement(seen, behind).sameTissue == 1.0);
  int tinted = 0, covered = 0;
  for (std::size_t i = 0; i < solid.tissue.size(); ++i) {
    if (solid.tissue[i].value != static_cast<std::int32_t>(front) + 1) continue;
    ++covered;
    tinted += without.pixels[i] != through.pixels[i] ? 1 : 0;
  }
  CHECK(covered > 100);
  CHECK(tinted > 0.95 * covered);
}

TEST_CASE("a view in motion is lit like the picture at rest") {
  Card card = Card::make();
  const render::VolumeItem item = manyMuscles();
  const render::Camera camera = test::cameraOn(item, 30.0, 20.0);
  render::Scene scene;
  scene.volume = item;
  const auto mean = [&](bool motion) {
    auto options = test::plainOptions(120, 120);
    options.motion = motion;
    options.samples = 8;
    REQUIRE(card.renderer.begin(scene, camera, options));
    int passes = 0;
    while (card.renderer.pass()) ++passes;
    CHECK(passes == (motion ? 1 : 8));
    const render::Image image = card.renderer.read();
    double sum = 0.0;
    for (const render::Pixel& p : image.pixels) sum += p[0] + p[1] + p[2];
    return sum / (3.0 * static_cast<double>(image.pixels.size()));
  };
  CHECK(mean(true) == Approx(mean(false)).margin(12.0));
}

TEST_CASE("streaks run along the flow") {
  // A slab seen square on, with fibres along X or along Z: light changes more across than along
  const auto domain = test::boxDomain({.cells = {8, 8, 8}});
  tissue::FieldMatrix f(domain.mesh.V.rows(), 2);
  f.col(0).setConstant(0.5);
  f.col(1) = domain.mesh.V.col(1);
  render::VolumeItem item = test::volumeItem(domain, f, true);
  Card card = Card::make();
  render::Camera camera = test::straightCamera(0.8);
  camera.eye = {0.5, -10.0, 0.5};
  camera.target = {0.5, 0.0, 0.5};
  for (const bool alongX : {true, false}) {
    item.flow = std::make_shared<mesh::Directions>(
        Vector3(alongX ? 1.0 : 0.0, 0.0, alongX ? 0.0 : 1.0).transpose().replicate(f.rows(), 1));
    render::Scene scene;
    scene.volume = item;
    auto options = test::plainOptions(200, 200);
    options.motion = true;
    REQUIRE(card.renderer.begin(scene, camera, options));
    card.renderer.pass();
    const render::Image image = card.renderer.read();
    double along = 0.0, across = 0.0;
    for (int y = 20; y < 180; ++y)
      for (int x = 20; x < 180; ++x) {
        const int right =
            std::abs(test::luminance(image.at(x + 1, y)) - test::luminance(image.at(x, y)));
        const int below =
            std::abs(test::luminance(image.at(x, y + 1)) - test::luminance(image.at(x, y)));
        along += alongX ? right : below;
        across += alongX ? below : right;
      }
    INFO("along X " << alongX << ": " << along << " along, " << across << " across");
    CHECK(across > 160.0 * 160.0);
    CHECK(across > 2.5 * along);
  }
}

TEST_CASE("a volume alone is framed on what is seen of it") {
  // A muscle in one corner of a box, fat everywhere else
  const auto domain = test::boxDomain({.cells = {16, 16, 16}});
  tissue::FieldMatrix f(domain.mesh.V.rows(), 2);
  f.col(0).setConstant(0.0);
  f.col(1) = (0.25 - domain.mesh.V.rowwise().maxCoeff().array()).matrix();
  render::Scene scene;
  scene.volume = test::volumeItem(domain, f, true);
  Card card = Card::make();
  const auto shareSeen = [&](const render::Camera& camera) {
    const auto image = card.draw(*scene.volume, scene.clip, camera, 100, 100);
    int seen = 0;
    for (int y = 0; y < 100; ++y)
      for (int x = 0; x < 100; ++x) {
        const bool here = image.tissue[image.index(x, y)] != kNoTissue;
        seen += here ? 1 : 0;
        if (x < 2 || y < 2 || x > 97 || y > 97) CHECK_FALSE(here);
      }
    return seen / 10000.0;
  };
  const auto framed = [&] {
    return render::framed({30.0, 20.0, 24.0, 1.0}, render::ModelAxes{}, scene, 1.0, 0.05);
  };
  CHECK(shareSeen(framed()) > 0.35);
  scene.volume->tissues[1].shift = {3.0, 0.0, 0.0};
  CHECK(shareSeen(framed()) > 0.35);
}
