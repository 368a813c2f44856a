#include <ecorche/mesh/read_lines.h>
#include <ecorche/mesh/read_ply.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <optional>
#include <utility>

namespace ecorche::mesh {

namespace {

enum class Scalar { Int8, UInt8, Int16, UInt16, Int32, UInt32, Float32, Float64 };
enum class Encoding { Ascii, LittleEndian, BigEndian };

struct Property {
  std::string name;
  Scalar type = Scalar::Float32;
  std::optional<Scalar> count;  // set: a list with a length of this type
};

struct Element {
  std::string name;
  std::int64_t count = 0;
  std::vector<Property> properties;
};

struct Header {
  Encoding encoding = Encoding::Ascii;
  std::vector<Element> elements;
};

std::optional<Scalar> scalarNamed(std::string_view word) {
  static constexpr std::pair<std::string_view, Scalar> kNames[] = {
      {"char", Scalar::Int8},      {"int8", Scalar::Int8},       {"uchar", Scalar::UInt8},
      {"uint8", Scalar::UInt8},    {"short", Scalar::Int16},     {"int16", Scalar::Int16},
      {"ushort", Scalar::UInt16},  {"uint16", Scalar::UInt16},   {"int", Scalar::Int32},
      {"int32", Scalar::Int32},    {"uint", Scalar::UInt32},     {"uint32", Scalar::UInt32},
      {"float", Scalar::Float32},  {"float32", Scalar::Float32}, {"double", Scalar::Float64},
      {"float64", Scalar::Float64}};
  for (const auto& [name, type] : kNames) {
    if (word == name) return type;
  }
  return std::nullopt;
}

Result<Property> readProperty(LineReader& lines) {
  Property property;
  std::string_view word = lines.word();
  if (word == "list") {
    property.count = scalarNamed(lines.word());
    if (!property.count) return lines.fault("a list's length has no type that PLY knows");
    word = lines.word();
  }
  const auto type = scalarNamed(word);
  if (!type) return lines.fault("a property has no type that PLY knows");
  property.type = *type;
  property.name = lines.word();
  if (property.name.empty()) return lines.missing("a name for the property");
  return property;
}

Result<Encoding> readEncoding(LineReader& lines) {
  const std::string_view word = lines.word();
  if (word == "ascii") return Encoding::Ascii;
  if (word == "binary_little_endian") return Encoding::LittleEndian;
  if (word == "binary_big_endian") return Encoding::BigEndian;
  return lines.fault("the format should be ascii, binary_little_endian or binary_big_endian");
}

Result<Header> readHeader(LineReader& lines) {
  Header header;
  bool formatKnown = false;
  if (!lines.next() || lines.word() != "ply") return lines.fault("the first line should be: ply");
  while (lines.next()) {
    const std::string_view key = lines.word();
    if (key == "end_header") {
      if (!formatKnown) return lines.fault("the header names no format");
      return header;
    }
    if (key == "format") {
      auto encoding = readEncoding(lines);
      if (!encoding) return passOn(encoding);
      header.encoding = *encoding;
      formatKnown = true;
    } else if (key == "element") {
      Element element;
      element.name = lines.word();
      if (auto ok = lines.integer(element.count, "the number of elements"); !ok) return passOn(ok);
      if (element.count < 0 || element.count > kMostElements) {
        return lines.fault(fmt::format("{} elements make no sense", element.count));
      }
      header.elements.push_back(std::move(element));
    } else if (key == "property") {
      if (header.elements.empty()) return lines.fault("a property before any element");
      auto property = readProperty(lines);
      if (!property) return passOn(property);
      header.elements.back().properties.push_back(std::move(*property));
    } else if (key != "comment" && key != "obj_info") {
      if (lines.breaksOff()) break;
      return lines.fault("this is no line of a PLY header");
    }
  }
  return lines.brokenOff("end_header is missing");
}

// Both sources hand out the values of an item one after another. value() is false where there is
// none; error() says why.
class TextSource {
 public:
  explicit TextSource(LineReader& lines) : lines_(lines) {}
  bool beginItem() {
    if (lines_.next()) return true;
    error_ = lines_.brokenOff("elements are missing").value();
    return false;
  }
  bool value(Scalar, double& x) {
    auto ok = lines_.number(x, "a property");
    if (!ok) error_ = std::move(ok.error());
    return ok.has_value();
  }
  [[nodiscard]] Error error() const { return error_; }
  [[nodiscard]] Error fault(ErrorCode code, std::string message) const {
    return lines_.errorHere(code, std::move(message)).value();
  }
  [[nodiscard]] std::size_t left() const { return lines_.size() - lines_.offset(); }

 private:
  LineReader& lines_;
  Error error_;
};

template <bool swap>
class BinarySource {
 public:
  BinarySource(std::string_view bytes, std::string file) : rest_(bytes), file_(std::move(file)) {}
  bool beginItem() { return true; }
  bool value(Scalar type, double& x) {
    switch (type) {
      case Scalar::Int8:
        return take<std::int8_t>(x);
      case Scalar::UInt8:
        return take<std::uint8_t>(x);
      case Scalar::Int16:
        return take<std::int16_t>(x);
      case Scalar::UInt16:
        return take<std::uint16_t>(x);
      case Scalar::Int32:
        return take<std::int32_t>(x);
      case Scalar::UInt32:
        return take<std::uint32_t>(x);
      case Scalar::Float32:
        return take<float>(x);
      case Scalar::Float64:
        return take<double>(x);
    }
    return false;
  }
  [[nodiscard]] Error error() const {
    return fault(ErrorCode::FileTruncated,
                 "the file breaks off before its elements end; copy or export it again");
  }
  [[nodiscard]] Error fault(ErrorCode code, std::string message) const {
    return {code, std::move(message), {.file = file_}};
  }
  [[nodiscard]] std::size_t left() const { return rest_.size(); }

 private:
  template <class T>
  bool take(double& x) {
    if (rest_.size() < sizeof(T)) return false;
    std::array<char, sizeof(T)> bytes;
    std::memcpy(bytes.data(), rest_.data(), sizeof(T));
    if constexpr (swap) std::ranges::reverse(bytes);
    x = static_cast<double>(std::bit_cast<T>(bytes));
    rest_.remove_prefix(sizeof(T));
    return true;
  }
  std::string_view rest_;
  std::string file_;
};

template <class Source>
class BodyReader {
 public:
  BodyReader(const Header& header, Source source, const std::string& file, RunContext& run)
      : header_(header), source_(std::move(source)), file_(file), run_(run) {
    const auto vertices = std::ranges::find(header.elements, "vertex", &Element::name);
    if (vertices != header.elements.end()) vertexCount_ = vertices->count;
  }

  Result<SurfaceMesh> read() {
    bool haveVertices = false;
    for (const Element& element : header_.elements) {
      Slots slots;
      if (element.name == "vertex" && !std::exchange(haveVertices, true)) {
        slots.xyz = {find(element, "x"), find(element, "y"), find(element, "z")};
        if (std::ranges::any_of(slots.xyz, [](int p) { return p < 0; })) {
          return tl::unexpected(
              source_.fault(ErrorCode::FileSyntax, "the vertices have no x, y and z"));
        }
        soup_.xyz.reserve(3 * believable(element));
      } else if (element.properties.empty()) {
        continue;
      } else if (element.name == "face") {
        slots.corners =
            std::max(find(element, "vertex_indices", true), find(element, "vertex_index", true));
        soup_.corners.reserve(3 * believable(element));
        soup_.size.reserve(believable(element));
      }
      for (std::int64_t i = 0; i < element.count; ++i) {
        if ((i & 0xffff) == 0xffff) {
          run_.progress("reading", static_cast<double>(i) / static_cast<double>(element.count));
          if (run_.cancelled()) return readingCancelled(file_);
        }
        if (!source_.beginItem()) return tl::unexpected(source_.error());
        if (auto ok = item(element, slots); !ok) return passOn(ok);
      }
    }
    return finishedMesh(soup_, file_);
  }

 private:
  // Which properties of an element matter; -1: none
  struct Slots {
    std::array<int, 3> xyz{-1, -1, -1};
    int corners = -1;
  };

  static int find(const Element& element, std::string_view name, bool list = false) {
    for (std::size_t p = 0; p < element.properties.size(); ++p) {
      const Property& property = element.properties[p];
      if (property.name == name && property.count.has_value() == list) return static_cast<int>(p);
    }
    return -1;
  }

  // Every property takes a byte at least, so a count can be believed only so far.
  [[nodiscard]] std::size_t believable(const Element& element) const {
    return std::min(static_cast<std::size_t>(element.count),
                    source_.left() / element.properties.size());
  }

  Result<void> item(const Element& element, const Slots& slots) {
    std::array<double, 3> point{};
    for (std::size_t p = 0; p < element.properties.size(); ++p) {
      const Property& property = element.properties[p];
      if (property.count) {
        if (auto ok = list(property, slots.corners == static_cast<int>(p)); !ok) return ok;
        continue;
      }
      double x = 0;
      if (!source_.value(property.type, x)) return tl::unexpected(source_.error());
      for (std::size_t k = 0; k < 3; ++k) {
        if (slots.xyz[k] == static_cast<int>(p)) point[k] = x;
      }
    }
    if (slots.xyz[0] < 0) return {};
    if (!std::isfinite(point[0]) || !std::isfinite(point[1]) || !std::isfinite(point[2])) {
      return tl::unexpected(source_.fault(
          ErrorCode::NonFiniteVertex,
          fmt::format("vertex {} is ({}, {}, {}); remove or place it where the mesh was made",
                      soup_.vertexCount() + 1, point[0], point[1], point[2])));
    }
    soup_.xyz.insert(soup_.xyz.end(), point.begin(), point.end());
    return {};
  }

  Result<void> list(const Property& property, bool corners) {
    double length = 0;
    if (!source_.value(*property.count, length)) return tl::unexpected(source_.error());
    if (!(length >= 0) || length != std::floor(length) ||
        length > static_cast<double>(kMostElements)) {
      return tl::unexpected(
          source_.fault(ErrorCode::FileSyntax, fmt::format("a list of {} values", length)));
    }
    if (corners && length < 3) {
      return tl::unexpected(
          source_.fault(ErrorCode::FileSyntax,
                        fmt::format("face {} has {} corners", soup_.size.size() + 1, length)));
    }
    const auto count = static_cast<std::int32_t>(length);
    for (std::int32_t k = 0; k < count; ++k) {
      double x = 0;
      if (!source_.value(property.type, x)) return tl::unexpected(source_.error());
      if (!corners) continue;
      if (!(x >= 0) || x >= static_cast<double>(vertexCount_) || x != std::floor(x)) {
        return tl::unexpected(source_.fault(
            ErrorCode::FileSyntax, fmt::format("face {} names vertex {}, but they go from 0 to {}",
                                               soup_.size.size() + 1, x, vertexCount_ - 1)));
      }
      soup_.corners.push_back(static_cast<std::int32_t>(x));
    }
    if (corners) soup_.size.push_back(count);
    return {};
  }

  const Header& header_;
  Source source_;
  const std::string& file_;
  RunContext& run_;
  std::int64_t vertexCount_ = 0;
  PolygonSoup soup_;
};

}  // namespace

Result<SurfaceMesh> parsePly(std::string_view bytes, const std::string& file, RunContext& run) {
  LineReader lines(bytes, file);
  const auto header = readHeader(lines);
  if (!header) return passOn(header);
  if (header->encoding == Encoding::Ascii) {
    return BodyReader<TextSource>(*header, TextSource(lines), file, run).read();
  }
  const std::string_view body = bytes.substr(lines.offset());
  const bool swap =
      (header->encoding == Encoding::BigEndian) != (std::endian::native == std::endian::big);
  if (swap)
    return BodyReader<BinarySource<true>>(*header, BinarySource<true>(body, file), file, run)
        .read();
  return BodyReader<BinarySource<false>>(*header, BinarySource<false>(body, file), file, run)
      .read();
}

}  // namespace ecorche::mesh
