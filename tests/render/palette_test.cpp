#include <ecorche/render/image.h>
#include <ecorche/render/palette.h>

#include <catch2/catch.hpp>
#include <random>
#include <set>

#include "render/scenes.h"

using namespace ecorche;
using render::NeighbourPairs;
using render::Palette;
using render::Rgba;

TEST_CASE("OKLab and linear light undo each other; white, grey and black lie on the axis") {
  std::mt19937 random(11);
  std::uniform_real_distribution<float> unit(0.0f, 1.0f);
  for (int i = 0; i < 200; ++i) {
    const Rgba c{unit(random), unit(random), unit(random), 1.0f};
    const Rgba back = render::linearFromOkLab(render::okLabFromLinear(c));
    for (std::size_t k = 0; k < 3; ++k) CHECK(back[k] == Approx(c[k]).margin(1e-5));
  }
  const auto white = render::okLabFromLinear({1.0f, 1.0f, 1.0f, 1.0f});
  CHECK(white[0] == Approx(1.0).margin(1e-4));
  CHECK(std::hypot(white[1], white[2]) < 1e-4);
}

TEST_CASE("colours are read from and written to their text form") {
  for (const char* text : {"#000000", "#ffffff", "#c0504d", "#0a1b2c"})
    CHECK(render::hexFromColour(render::colourFromHex(text).value()) == text);
  for (const char* text : {"", "c0504d", "#c0504", "#c0504dd", "#c0504g", "red"})
    CHECK_FALSE(render::colourFromHex(text));
}

TEST_CASE("neighbours get colours that differ, for colour-blind eyes too, the same every time") {
  std::mt19937 random(5);
  for (const Palette palette : {Palette::Anatomical, Palette::Distinct})
    for (int round = 0; round < 20; ++round) {
      // Muscles touch a handful of others: a ring with chords
      const std::int32_t count = 20 + 10 * round;
      NeighbourPairs pairs;
      for (std::int32_t i = 0; i < count; ++i) {
        pairs.emplace_back(i, (i + 1) % count);
        pairs.emplace_back(i, static_cast<std::int32_t>(random() % static_cast<unsigned>(count)));
        pairs.emplace_back((i + 3) % count, i);
      }
      const auto colours = render::tissueColours(count, pairs, palette);
      CHECK(colours == render::tissueColours(count, pairs, palette));
      double smallest = 1.0;
      for (const auto& [a, b] : pairs)
        if (a != b)
          smallest =
              std::min(smallest, render::colourDistance(colours[static_cast<std::size_t>(a)],
                                                        colours[static_cast<std::size_t>(b)]));
      INFO("palette " << static_cast<int>(palette) << ", count " << count);
      CHECK(smallest > 0.05);  // 0.02 is just noticed
      CHECK(std::set<Rgba>(colours.begin(), colours.end()).size() >= 12);
    }
}

TEST_CASE("muscle colours keep away from bone, fat and skin") {
  const auto colours = render::tissueColours(60, {});
  for (const Rgba& c : colours)
    for (const Rgba& other : {render::tint::bone(), render::tint::fat()})
      CHECK(render::colourDistance(c, other) > 0.08);
}

TEST_CASE("left and right share a colour, chosen colours are kept") {
  const std::vector<std::string> names{"soleus_L",     "biceps_L",    "soleus_R",
                                       "right biceps", "biceps left", "lumbar"};
  const auto twin = render::sideTwins(names);
  CHECK(twin == std::vector<std::int32_t>{-1, -1, 0, -1, 1, -1});
  CHECK(render::sideTwins({"left soleus", "right soleus"}) == std::vector<std::int32_t>{-1, 0});

  const Rgba own{0.1f, 0.2f, 0.3f, 1.0f};
  std::vector<std::optional<Rgba>> fixed(6);
  fixed[1] = own;
  const auto colours =
      render::tissueColours(6, {{0, 1}, {1, 2}, {2, 3}}, Palette::Anatomical, twin, fixed);
  CHECK(colours[0] == colours[2]);
  CHECK(colours[1] == own);
  CHECK(colours[3] != colours[2]);
}

TEST_CASE("neighbours are found by shared faces and by nearness") {
  // Two tets that share a face, labels 2 and 4; fat beside them does not count
  mesh::TetNeighbours neighbours(3, 4);
  neighbours << 1, -1, -1, -1, 0, 2, -1, -1, 1, -1, -1, -1;
  const std::vector<TissueId> label{TissueId{2}, TissueId{4}, kFat};
  CHECK(render::touchingTissues(label, neighbours) == NeighbourPairs{{0, 2}});

  const auto a = test::ball({0.0, 0.0, 0.0}, 1.0, 24);
  const auto b = test::ball({2.05, 0.0, 0.0}, 1.0, 24);
  const auto c = test::ball({5.0, 0.0, 0.0}, 1.0, 24);
  CHECK(render::nearSurfaces({a.get(), b.get(), c.get()}, 0.2) == NeighbourPairs{{0, 1}});
}
