#include <ecorche/core/contract.h>
#include <ecorche/core/files.h>
#include <ecorche/render/image.h>
#include <png.h>

#include <cmath>
#include <cstring>

namespace ecorche::render {

Image::Image(int w, int h, Pixel fill)
    : width(w), height(h), pixels(static_cast<std::size_t>(w) * static_cast<std::size_t>(h), fill) {
  EC_REQUIRE(w > 0 && h > 0);
}

float linearFromSrgb(float encoded) {
  return encoded <= 0.04045f ? encoded / 12.92f : std::pow((encoded + 0.055f) / 1.055f, 2.4f);
}

float srgbFromLinear(float linear) {
  return linear <= 0.0031308f ? linear * 12.92f : 1.055f * std::pow(linear, 1.0f / 2.4f) - 0.055f;
}

namespace {

struct PngWriter {
  png_structp png = nullptr;
  png_infop info = nullptr;
  ~PngWriter() { png_destroy_write_struct(&png, &info); }
};

void appendBytes(png_structp png, png_bytep data, png_size_t size) {
  static_cast<std::string*>(png_get_io_ptr(png))->append(reinterpret_cast<const char*>(data), size);
}

// libpng leaves errors by longjmp, which must not cross objects with destructors: everything it
// touches is made before.
bool encodeRows(PngWriter& writer, const std::vector<std::uint8_t>& rows, int width, int height,
                int channels, std::string& out) {
  if (setjmp(png_jmpbuf(writer.png))) return false;
  png_set_write_fn(writer.png, &out, appendBytes, nullptr);
  png_set_IHDR(writer.png, writer.info, static_cast<png_uint_32>(width),
               static_cast<png_uint_32>(height), 8,
               channels == 4 ? PNG_COLOR_TYPE_RGBA : PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE,
               PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_set_sRGB_gAMA_and_cHRM(writer.png, writer.info, PNG_sRGB_INTENT_PERCEPTUAL);
  png_set_compression_level(writer.png, 6);
  png_write_info(writer.png, writer.info);
  const std::size_t stride = static_cast<std::size_t>(width) * static_cast<std::size_t>(channels);
  for (int y = 0; y < height; ++y)
    png_write_row(writer.png, rows.data() + static_cast<std::size_t>(y) * stride);
  png_write_end(writer.png, nullptr);
  return true;
}

}  // namespace

Result<std::string> encodePng(const Image& image) {
  EC_REQUIRE(image.width > 0 && image.height > 0);
  EC_REQUIRE_EQ(image.pixels.size(),
                static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height));

  bool opaque = true;
  for (const Pixel& p : image.pixels) opaque = opaque && p[3] == 255;
  const int channels = opaque ? 3 : 4;
  std::vector<std::uint8_t> rows;
  rows.reserve(image.pixels.size() * static_cast<std::size_t>(channels));
  for (const Pixel& p : image.pixels) rows.insert(rows.end(), p.begin(), p.begin() + channels);

  PngWriter writer;
  writer.png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  if (writer.png) writer.info = png_create_info_struct(writer.png);
  std::string bytes;
  if (!writer.info || !encodeRows(writer, rows, image.width, image.height, channels, bytes))
    return fail(ErrorCode::Internal, "libpng could not encode the picture");
  return bytes;
}

Result<void> writePng(const std::filesystem::path& file, const Image& image) {
  auto bytes = encodePng(image);
  if (!bytes) return passOn(bytes);
  return writeFileWhole(file, *bytes);
}

Result<Image> readPng(const std::filesystem::path& file) {
  auto bytes = readFile(file);
  if (!bytes) return passOn(bytes);
  const Place place{.file = file.string()};
  if (bytes->size() < 8 || png_sig_cmp(reinterpret_cast<png_const_bytep>(bytes->data()), 0, 8) != 0)
    return fail(ErrorCode::FileUnknownFormat, "this is not a PNG picture", place);

  png_image header;
  std::memset(&header, 0, sizeof header);
  header.version = PNG_IMAGE_VERSION;
  if (!png_image_begin_read_from_memory(&header, bytes->data(), bytes->size()))
    return fail(ErrorCode::FileSyntax, std::string("the PNG is damaged: ") + header.message, place);
  header.format = PNG_FORMAT_RGBA;
  Image image(static_cast<int>(header.width), static_cast<int>(header.height));
  if (!png_image_finish_read(&header, nullptr, image.pixels.data(), 0, nullptr))
    return fail(ErrorCode::FileSyntax, std::string("the PNG is damaged: ") + header.message, place);
  return image;
}

Image downsampled(const Image& image, int factor) {
  EC_REQUIRE(factor > 0 && image.width % factor == 0 && image.height % factor == 0);
  Image small(image.width / factor, image.height / factor);
  const float share = 1.0f / static_cast<float>(factor * factor);
  for (int y = 0; y < small.height; ++y)
    for (int x = 0; x < small.width; ++x) {
      std::array<float, 3> light{};
      float alpha = 0.0f;
      for (int dy = 0; dy < factor; ++dy)
        for (int dx = 0; dx < factor; ++dx) {
          const Pixel& p = image.at(x * factor + dx, y * factor + dy);
          const float a = static_cast<float>(p[3]) / 255.0f;
          for (std::size_t c = 0; c < 3; ++c)
            light[c] += a * linearFromSrgb(static_cast<float>(p[c]) / 255.0f);
          alpha += a;
        }
      Pixel& out = small.at(x, y);
      for (std::size_t c = 0; c < 3; ++c)
        out[c] =
            alpha > 0.0f
                ? static_cast<std::uint8_t>(std::lround(255.0f * srgbFromLinear(light[c] / alpha)))
                : std::uint8_t{0};
      out[3] = static_cast<std::uint8_t>(std::lround(255.0f * alpha * share));
    }
  return small;
}

}  // namespace ecorche::render
