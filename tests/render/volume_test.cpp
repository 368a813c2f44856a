#include <ecorche/render/offscreen.h>
#include <ecorche/render/ray_caster.h>
#include <ecorche/render/renderer.h>
#include <ecorche/render/views.h>

#include <catch2/catch.hpp>
#include <random>

#include "render/scenes.h"
#include "render/volumes.h"
#include "support/generated_anatomy.h"
#include "support/generated_domain.h"

using namespace ecorche;
using mesh::Vector3;

namespace {

// One renderer for a whole test: what it holds from the last picture must not show in the next.
struct Card {
  render::OffscreenContext context;
  render::Renderer renderer;

  static Card make() {
    auto context = render::OffscreenContext::create();
    if (!context) FAIL(context.error().text());
    auto renderer = render::Renderer::create();
    if (!renderer) FAIL(renderer.error().text());
    return {std::move(*context), std::move(*renderer)};
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
        clip = {item.geometry->box().centre() + 0.01 * item.geometry->box().diagonal() *
                                                    Vector3(0.3, 0.1, -0.7),
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
