#include <ecorche/core/files.h>
#include <ecorche/exchange/vtu.h>
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cstring>
#include <pugixml.hpp>

namespace ecorche::exchange {

namespace {

// Everything that reading one file needs: its name for errors, its XML and its raw bytes.
class VtuReader {
 public:
  VtuReader(std::string file, std::string_view bytes) : file_(std::move(file)), bytes_(bytes) {}

  Result<AnatomyFile> read() {
    if (auto ok = openXml(); !ok) return passOn(ok);
    AnatomyFile out;
    const pugi::xml_node grid = xml_.child("VTKFile").child("UnstructuredGrid");
    const pugi::xml_node piece = grid.child("Piece");
    const auto vertexCount = count(piece, "NumberOfPoints", 24);
    if (!vertexCount) return passOn(vertexCount);
    const auto tetCount = count(piece, "NumberOfCells", 29);
    if (!tetCount) return passOn(tetCount);

    out.mesh.V.resize(*vertexCount, 3);
    out.mesh.T.resize(*tetCount, 4);
    out.tissue.resize(static_cast<std::size_t>(*tetCount));
    std::vector<std::int64_t> offsets(out.tissue.size());
    std::vector<std::uint8_t> types(out.tissue.size());
    const pugi::xml_node cells = piece.child("Cells");
    const pugi::xml_node cellData = piece.child("CellData");
    const pugi::xml_node pointData = piece.child("PointData");
    if (auto ok =
            load(piece.child("Points"), "Points", "Float64", out.mesh.V.data(), out.mesh.V.size());
        !ok)
      return passOn(ok);
    if (auto ok = load(cells, "connectivity", "Int32", out.mesh.T.data(), out.mesh.T.size()); !ok)
      return passOn(ok);
    if (auto ok = load(cells, "offsets", "Int64", offsets.data(), *tetCount); !ok)
      return passOn(ok);
    if (auto ok = load(cells, "types", "UInt8", types.data(), *tetCount); !ok) return passOn(ok);
    if (auto ok = load(cellData, "tissue", "Int32", out.tissue.data(), *tetCount); !ok)
      return passOn(ok);
    if (array(cellData, "fiber")) {
      out.tetFiber.resize(*tetCount, 3);
      if (auto ok = load(cellData, "fiber", "Float64", out.tetFiber.data(), out.tetFiber.size());
          !ok)
        return passOn(ok);
    }
    if (array(cellData, "tendon")) {
      out.tendon.resize(out.tissue.size());
      if (auto ok = load(cellData, "tendon", "UInt8", out.tendon.data(), *tetCount); !ok)
        return passOn(ok);
    }
    if (array(pointData, "fiber")) {
      out.vertexFiber.resize(*vertexCount, 3);
      if (auto ok =
              load(pointData, "fiber", "Float64", out.vertexFiber.data(), out.vertexFiber.size());
          !ok)
        return passOn(ok);
    }

    for (std::size_t t = 0; t < types.size(); ++t) {
      if (types[t] != 10 || offsets[t] != 4 * (static_cast<std::int64_t>(t) + 1)) {
        return fault(ErrorCode::FileSyntax,
                     fmt::format("cell {} is not a tetrahedron; only tets are read", t));
      }
    }
    if (out.mesh.T.size() > 0 &&
        (out.mesh.T.minCoeff() < 0 || out.mesh.T.maxCoeff() >= *vertexCount)) {
      return fault(ErrorCode::FileSyntax,
                   "a tet names a point that the file does not have; export it again");
    }
    if (auto ok = readNames(grid.child("FieldData"), out.names); !ok) return passOn(ok);
    return out;
  }

 private:
  [[nodiscard]] tl::unexpected<Error> fault(ErrorCode code, std::string message) const {
    return fail(code, std::move(message), {.file = file_});
  }

  // The header is XML once the raw block is left out.
  Result<void> openXml() {
    const std::string_view head = bytes_.substr(0, std::min<std::size_t>(bytes_.size(), 4096));
    if (head.find("<VTKFile") == head.npos) {
      return fault(ErrorCode::FileUnknownFormat, "this is no VTK XML file");
    }
    const auto tag = bytes_.find("<AppendedData");
    const auto underscore = tag == bytes_.npos ? tag : bytes_.find('_', bytes_.find('>', tag));
    if (underscore == bytes_.npos) {
      return fault(ErrorCode::FileTruncated, "the file ends before its data; export it again");
    }
    const std::string header = std::string(bytes_.substr(0, tag)) + "</VTKFile>";
    const pugi::xml_parse_result parsed =
        xml_.load_buffer(header.data(), header.size(), pugi::parse_default, pugi::encoding_utf8);
    if (!parsed) {
      // The parser may stop beyond the end, at a zero of its own
      const auto stop = std::clamp<std::ptrdiff_t>(parsed.offset, 0, std::ssize(header));
      return fail(
          ErrorCode::FileSyntax, fmt::format("the XML is broken: {}", parsed.description()),
          {.file = file_,
           .line = static_cast<int>(1 + std::count(header.begin(), header.begin() + stop, '\n'))});
    }
    const pugi::xml_node root = xml_.child("VTKFile");
    if (std::string_view(root.attribute("type").value()) != "UnstructuredGrid" ||
        std::string_view(root.attribute("byte_order").value()) != "LittleEndian" ||
        std::string_view(root.attribute("header_type").value()) != "UInt64" ||
        root.attribute("compressor")) {
      return fault(ErrorCode::FileUnknownFormat,
                   "this VTU is not as Écorché writes it (tets, little endian, UInt64 headers, "
                   "appended raw); "
                   "export it again");
    }
    raw_ = bytes_.substr(underscore + 1);
    return {};
  }

  // `least`: bytes that one of them takes at least.
  Result<std::int64_t> count(const pugi::xml_node& piece, const char* attribute,
                             std::size_t least) const {
    const std::string_view text = piece.attribute(attribute).value();
    std::int64_t value = -1;
    const auto [end, ec] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (ec != std::errc() || end != text.data() + text.size() || value < 0 || value > INT32_MAX) {
      return fault(ErrorCode::FileSyntax, fmt::format("{} is missing or no count", attribute));
    }
    // A header may not ask for more memory than the file could fill
    if (least * static_cast<std::size_t>(value) > bytes_.size()) {
      return fault(ErrorCode::FileTruncated,
                   fmt::format("{} is {}, more than the file can hold", attribute, value));
    }
    return value;
  }

  static pugi::xml_node array(const pugi::xml_node& parent, const char* arrayName) {
    return parent.find_child_by_attribute("DataArray", "Name", arrayName);
  }

  template <class Scalar>
  Result<void> load(const pugi::xml_node& parent, const char* arrayName, std::string_view type,
                    Scalar* to, std::int64_t size) const {
    const pugi::xml_node node = array(parent, arrayName);
    if (!node)
      return fault(ErrorCode::FileSyntax, fmt::format("the array \"{}\" is missing", arrayName));
    if (node.attribute("type").value() != type ||
        std::string_view(node.attribute("format").value()) != "appended") {
      return fault(
          ErrorCode::FileUnknownFormat,
          fmt::format("the array \"{}\" is not appended {}; export it again", arrayName, type));
    }
    const std::uint64_t offset = node.attribute("offset").as_ullong(UINT64_MAX);
    const std::uint64_t bytes = sizeof(Scalar) * static_cast<std::uint64_t>(size);
    std::uint64_t stated = 0;
    if (offset > raw_.size() || raw_.size() - offset < sizeof stated ||
        raw_.size() - offset - sizeof stated < bytes) {
      return fault(
          ErrorCode::FileTruncated,
          fmt::format("the file ends inside the array \"{}\"; export it again", arrayName));
    }
    std::memcpy(&stated, raw_.data() + offset, sizeof stated);
    if (stated != bytes) {
      return fault(
          ErrorCode::FileSyntax,
          fmt::format("the array \"{}\" has {} bytes where {} are due", arrayName, stated, bytes));
    }
    if (bytes > 0) std::memcpy(to, raw_.data() + offset + sizeof stated, bytes);
    return {};
  }

  Result<void> readNames(const pugi::xml_node& fields, std::vector<TissueName>& names) const {
    constexpr std::string_view kPrefix = "tissue:";
    for (const pugi::xml_node& node : fields.children("DataArray")) {
      const std::string_view full = node.attribute("Name").value();
      if (!full.starts_with(kPrefix)) continue;
      TissueName entry;
      entry.name = full.substr(kPrefix.size());
      entry.id = node.text().as_int(-1);
      if (entry.id < 0) {
        return fault(ErrorCode::FileSyntax, fmt::format("the tissue \"{}\" has no id", entry.name));
      }
      names.push_back(std::move(entry));
    }
    std::ranges::sort(names);
    return {};
  }

  std::string file_;
  std::string_view bytes_;
  std::string_view raw_;
  pugi::xml_document xml_;
};

}  // namespace

Result<AnatomyFile> parseVtu(std::string_view bytes, const std::string& file) {
  return VtuReader(file, bytes).read();
}

Result<AnatomyFile> readVtu(const std::filesystem::path& file) {
  const auto bytes = readFile(file);
  if (!bytes) return passOn(bytes);
  return parseVtu(*bytes, file.string());
}

}  // namespace ecorche::exchange
