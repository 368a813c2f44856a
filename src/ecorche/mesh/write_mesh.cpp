#include <ecorche/core/files.h>
#include <ecorche/mesh/write_mesh.h>
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <bit>
#include <charconv>
#include <cstring>

namespace ecorche::mesh {

namespace {

static_assert(std::endian::native == std::endian::little,
              "binary PLY and STL are written as they lie");

template <class Number>
void append(std::string& out, Number x) {
  char digits[32];
  const auto end = std::to_chars(digits, digits + sizeof digits, x).ptr;
  out.append(digits, static_cast<std::size_t>(end - digits));
}

template <class T>
void appendRaw(std::string& out, T x) {
  out.append(reinterpret_cast<const char*>(&x), sizeof x);
}

template <class Row>
void appendRow(std::string& out, const Row& row) {
  append(out, row[0]);
  out += ' ';
  append(out, row[1]);
  out += ' ';
  append(out, row[2]);
  out += '\n';
}

// One line, no blanks at its ends: what a reader gives back.
std::string lineOf(const std::string& name) {
  std::string line = name;
  for (char& c : line) {
    if (c == '\n' || c == '\r' || c == '\t' || c == '\\') c = ' ';
  }
  const auto begin = line.find_first_not_of(' ');
  if (begin == line.npos) return "unnamed";
  return line.substr(begin, line.find_last_not_of(' ') - begin + 1);
}

}  // namespace

std::string objText(const SurfaceMesh& mesh) {
  std::string out = "# metres\n";
  out.reserve(static_cast<std::size_t>(mesh.V.rows() * 60 + mesh.F.rows() * 24));
  if (mesh.parts.empty()) out += "o " + lineOf(mesh.name) + "\n";
  for (Eigen::Index v = 0; v < mesh.V.rows(); ++v) {
    out += "v ";
    appendRow(out, mesh.V.row(v));
  }
  std::size_t part = 0;
  for (Eigen::Index f = 0; f < mesh.F.rows(); ++f) {
    while (part < mesh.parts.size() && mesh.parts[part].firstFace == f) {
      out += "g " + lineOf(mesh.parts[part++].name) + "\n";
    }
    out += "f ";
    appendRow(out, mesh.F.row(f).array() + 1);
  }
  return out;
}

std::string offText(const SurfaceMesh& mesh) {
  std::string out = fmt::format("OFF\n{} {} 0\n", mesh.V.rows(), mesh.F.rows());
  out.reserve(static_cast<std::size_t>(mesh.V.rows() * 60 + mesh.F.rows() * 24));
  for (Eigen::Index v = 0; v < mesh.V.rows(); ++v) appendRow(out, mesh.V.row(v));
  for (Eigen::Index f = 0; f < mesh.F.rows(); ++f) {
    out += "3 ";
    appendRow(out, mesh.F.row(f));
  }
  return out;
}

std::string plyBytes(const SurfaceMesh& mesh) {
  std::string out = fmt::format(
      "ply\nformat binary_little_endian 1.0\ncomment metres\nelement vertex {}\nproperty double "
      "x\nproperty double y\n"
      "property double z\nelement face {}\nproperty list uchar int vertex_indices\nend_header\n",
      mesh.V.rows(), mesh.F.rows());
  out.reserve(out.size() + static_cast<std::size_t>(mesh.V.rows() * 24 + mesh.F.rows() * 13));
  out.append(reinterpret_cast<const char*>(mesh.V.data()),
             sizeof(double) * static_cast<std::size_t>(mesh.V.size()));
  for (Eigen::Index f = 0; f < mesh.F.rows(); ++f) {
    out += '\3';
    for (int k = 0; k < 3; ++k) appendRaw(out, mesh.F(f, k));
  }
  return out;
}

std::string stlBytes(const SurfaceMesh& mesh) {
  std::string out = "binary STL, metres";  // must not begin with "solid"
  out.resize(80, ' ');
  appendRaw(out, static_cast<std::uint32_t>(mesh.F.rows()));
  for (Eigen::Index f = 0; f < mesh.F.rows(); ++f) {
    const Vector3 a = mesh.V.row(mesh.F(f, 0)).transpose();
    const Vector3 b = mesh.V.row(mesh.F(f, 1)).transpose();
    const Vector3 c = mesh.V.row(mesh.F(f, 2)).transpose();
    Vector3 n = (b - a).cross(c - a);
    if (const double length = n.norm(); length > 0) n /= length;
    for (const Vector3& p : {n, a, b, c}) {
      for (int k = 0; k < 3; ++k) appendRaw(out, static_cast<float>(p[k]));
    }
    appendRaw(out, std::uint16_t{0});
  }
  return out;
}

Result<void> writeObj(const SurfaceMesh& mesh, const std::filesystem::path& file) {
  return writeFileWhole(file, objText(mesh));
}
Result<void> writePly(const SurfaceMesh& mesh, const std::filesystem::path& file) {
  return writeFileWhole(file, plyBytes(mesh));
}
Result<void> writeOff(const SurfaceMesh& mesh, const std::filesystem::path& file) {
  return writeFileWhole(file, offText(mesh));
}
Result<void> writeStl(const SurfaceMesh& mesh, const std::filesystem::path& file) {
  return writeFileWhole(file, stlBytes(mesh));
}

}  // namespace ecorche::mesh
