#include <ecorche/core/contract.h>
#include <ecorche/core/files.h>
#include <ecorche/exchange/vtu.h>
#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cstring>

namespace ecorche::exchange {

static_assert(std::endian::native == std::endian::little,
              "VTU arrays are written as they lie in memory");

namespace {

constexpr std::uint8_t kVtkTetra = 10;

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

// Collects arrays: a line of XML for each now, its bytes behind the header later.
class Appended {
 public:
  std::string array(const char* type, const char* arrayName, int components, const void* data,
                    std::size_t bytes) {
    const std::string line = fmt::format(
        "        <DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\" "
        "format=\"appended\" offset=\"{}\"/>\n",
        type, arrayName, components, offset_);
    pieces_.push_back({data, bytes});
    offset_ += sizeof(std::uint64_t) + bytes;
    return line;
  }
  void appendTo(std::string& out) const {
    for (const Piece& piece : pieces_) {
      const std::uint64_t size = piece.bytes;
      out.append(reinterpret_cast<const char*>(&size), sizeof size);
      out.append(static_cast<const char*>(piece.data), piece.bytes);
    }
  }
  [[nodiscard]] std::size_t size() const { return offset_; }

 private:
  struct Piece {
    const void* data;
    std::size_t bytes;
  };
  std::vector<Piece> pieces_;
  std::size_t offset_ = 0;
};

template <class Matrix>
std::size_t bytesOf(const Matrix& m) {
  return sizeof(typename Matrix::Scalar) * static_cast<std::size_t>(m.size());
}

}  // namespace

Result<void> writeVtu(const std::filesystem::path& file, const VtuContents& c) {
  const Eigen::Index vertexCount = c.mesh.V.rows();
  const Eigen::Index tetCount = c.mesh.T.rows();
  EC_REQUIRE_EQ(static_cast<Eigen::Index>(c.tissue.size()), tetCount);
  EC_REQUIRE(c.tetFiber == nullptr || c.tetFiber->rows() == tetCount);
  EC_REQUIRE(c.vertexFiber == nullptr || c.vertexFiber->rows() == vertexCount);
  const bool hasTendon = c.tendon != nullptr && !c.tendon->empty();
  EC_REQUIRE(!hasTendon || static_cast<Eigen::Index>(c.tendon->size()) == tetCount);

  std::vector<std::int64_t> offsets(static_cast<std::size_t>(tetCount));
  for (std::size_t t = 0; t < offsets.size(); ++t)
    offsets[t] = 4 * (static_cast<std::int64_t>(t) + 1);
  const std::vector<std::uint8_t> types(static_cast<std::size_t>(tetCount), kVtkTetra);
  std::vector<std::int32_t> tissue(c.tissue.size());
  std::ranges::transform(c.tissue, tissue.begin(), &TissueId::value);

  Appended data;
  std::string xml =
      "<?xml version=\"1.0\"?>\n"
      "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" "
      "header_type=\"UInt64\">\n"
      "  <UnstructuredGrid>\n    <FieldData>\n";
  for (const TissueName& name : c.names) {
    xml += fmt::format(
        "      <DataArray type=\"Int32\" Name=\"tissue:{}\" NumberOfTuples=\"1\" "
        "format=\"ascii\">{}</DataArray>\n",
        escaped(name.name), name.id);
  }
  xml += fmt::format(
      "    </FieldData>\n    <Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n"
      "      <Points>\n",
      vertexCount, tetCount);
  xml += data.array("Float64", "Points", 3, c.mesh.V.data(), bytesOf(c.mesh.V));
  xml += "      </Points>\n      <Cells>\n";
  xml += data.array("Int32", "connectivity", 1, c.mesh.T.data(), bytesOf(c.mesh.T));
  xml += data.array("Int64", "offsets", 1, offsets.data(), sizeof(std::int64_t) * offsets.size());
  xml += data.array("UInt8", "types", 1, types.data(), types.size());
  xml += "      </Cells>\n      <CellData Scalars=\"tissue\">\n";
  xml += data.array("Int32", "tissue", 1, tissue.data(), sizeof(std::int32_t) * tissue.size());
  if (c.tetFiber != nullptr) {
    xml += data.array("Float64", "fiber", 3, c.tetFiber->data(), bytesOf(*c.tetFiber));
  }
  if (hasTendon) xml += data.array("UInt8", "tendon", 1, c.tendon->data(), c.tendon->size());
  xml += "      </CellData>\n      <PointData>\n";
  if (c.vertexFiber != nullptr) {
    xml += data.array("Float64", "fiber", 3, c.vertexFiber->data(), bytesOf(*c.vertexFiber));
  }
  xml +=
      "      </PointData>\n    </Piece>\n  </UnstructuredGrid>\n"
      "  <AppendedData encoding=\"raw\">\n_";
  xml.reserve(xml.size() + data.size() + 64);
  data.appendTo(xml);
  xml += "\n  </AppendedData>\n</VTKFile>\n";
  return writeFileWhole(file, xml);
}

}  // namespace ecorche::exchange
