#pragma once

#include <ecorche/core/result.h>

#include <array>
#include <cstdint>
#include <filesystem>
#include <vector>

namespace ecorche::render {

using Pixel = std::array<std::uint8_t, 4>;  ///< sRGB red, green, blue and straight alpha

/// A picture, row by row from the top left.
struct Image {
  int width = 0;
  int height = 0;
  std::vector<Pixel> pixels;  ///< width · height

  Image() = default;
  Image(int w, int h, Pixel fill = {0, 0, 0, 0});

  [[nodiscard]] const Pixel& at(int x, int y) const {
    return pixels[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                  static_cast<std::size_t>(x)];
  }
  [[nodiscard]] Pixel& at(int x, int y) {
    return pixels[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                  static_cast<std::size_t>(x)];
  }
};

/// sRGB transfer function between encoded and linear light, both in [0, 1] [IEC 61966-2-1].
[[nodiscard]] float linearFromSrgb(float encoded);
[[nodiscard]] float srgbFromLinear(float linear);

/// The bytes of a PNG file, 8 bits, RGBA (RGB where nothing is transparent), marked sRGB.
[[nodiscard]] Result<std::string> encodePng(const Image& image);

/// Writes a PNG, whole or not at all. @errors FileNotWritable
[[nodiscard]] Result<void> writePng(const std::filesystem::path& file, const Image& image);

/// @errors FileMissing, FileNotReadable, FileEmpty, FileUnknownFormat, FileSyntax
[[nodiscard]] Result<Image> readPng(const std::filesystem::path& file);

/// Mean over factor × factor pixels, taken in linear light with colours weighted by alpha. Sizes
/// must divide.
[[nodiscard]] Image downsampled(const Image& image, int factor);

}  // namespace ecorche::render
