#include <ecorche/render/image.h>
#include <png.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <fstream>

#include "support/paths.h"

using namespace ecorche;
using render::Image;

namespace {

Image gradient(int width, int height, bool opaque) {
  Image image(width, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      image.at(x, y) = {static_cast<std::uint8_t>(3 * x), static_cast<std::uint8_t>(5 * y),
                        static_cast<std::uint8_t>(x ^ y),
                        opaque ? std::uint8_t{255} : static_cast<std::uint8_t>(7 * x)};
  return image;
}

}  // namespace

TEST_CASE("a written PNG holds the same pixels for libpng and for us") {
  test::TempFolder temp;
  for (const bool opaque : {true, false}) {
    const Image image = gradient(37, 23, opaque);
    const auto file = temp.path() / "picture.png";
    REQUIRE(render::writePng(file, image));
    CHECK(render::readPng(file).value().pixels == image.pixels);

    png_image header;
    std::memset(&header, 0, sizeof header);
    header.version = PNG_IMAGE_VERSION;
    REQUIRE(png_image_begin_read_from_file(&header, file.c_str()));
    CHECK(header.width == 37u);
    CHECK(header.height == 23u);
    header.format = PNG_FORMAT_RGBA;
    std::vector<render::Pixel> pixels(37 * 23);
    REQUIRE(png_image_finish_read(&header, nullptr, pixels.data(), 0, nullptr));
    CHECK(pixels == image.pixels);
  }
  // Written whole: nothing but the picture is left in the folder
  CHECK(std::distance(std::filesystem::directory_iterator(temp.path()), {}) == 1);
}

TEST_CASE("PNG files that are none say so") {
  test::TempFolder temp;
  const auto file = temp.path() / "picture.png";
  CHECK(render::readPng(file).error().code == ErrorCode::FileMissing);
  std::ofstream(file) << "this is a text";
  CHECK(render::readPng(file).error().code == ErrorCode::FileUnknownFormat);
  const std::string bytes = render::encodePng(gradient(64, 64, true)).value();
  std::ofstream(file, std::ios::binary).write(bytes.data(), static_cast<long>(bytes.size() / 2));
  CHECK(render::readPng(file).error().code == ErrorCode::FileSyntax);
  CHECK(render::writePng(temp.path() / "no" / "a.png", gradient(4, 4, true)).error().code ==
        ErrorCode::FileNotWritable);
}

TEST_CASE("sRGB encoding and decoding undo each other and keep black and white") {
  CHECK(render::linearFromSrgb(0.0f) == 0.0f);
  CHECK(render::linearFromSrgb(1.0f) == Approx(1.0f));
  for (int i = 0; i <= 255; ++i) {
    const float encoded = static_cast<float>(i) / 255.0f;
    CHECK(render::srgbFromLinear(render::linearFromSrgb(encoded)) == Approx(encoded).margin(1e-6));
  }
}

TEST_CASE("downsampling averages light, not code values, and weighs colours by alpha") {
  Image image(2, 2);
  image.at(0, 0) = image.at(1, 1) = {255, 255, 255, 255};
  image.at(1, 0) = image.at(0, 1) = {0, 0, 0, 255};
  CHECK(render::downsampled(image, 2).at(0, 0) ==
        render::Pixel{188, 188, 188, 255});  // half the light

  image.at(1, 0) = image.at(0, 1) = {0, 0, 0, 0};
  CHECK(render::downsampled(image, 2).at(0, 0) == render::Pixel{255, 255, 255, 128});
}
