#include <ecorche/mesh/read_lines.h>
#include <ecorche/mesh/read_stl.h>
#include <ecorche/mesh/weld.h>
#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cctype>
#include <cmath>
#include <cstring>

namespace ecorche::mesh {

namespace {

constexpr std::size_t kHeader = 84;    // 80 bytes of anything, then the number of triangles
constexpr std::size_t kTriangle = 50;  // normal, three corners, attribute

static_assert(std::endian::native == std::endian::little, "binary STL is read as it lies");

std::uint32_t announced(std::string_view bytes) {
  std::uint32_t count = 0;
  std::memcpy(&count, bytes.data() + 80, sizeof count);
  return count;
}

bool isKey(std::string_view word, std::string_view key) {
  return std::ranges::equal(
      word, key, [](char a, char b) { return std::tolower(static_cast<unsigned char>(a)) == b; });
}

Result<SurfaceMesh> parseBinary(std::string_view bytes, const std::string& file, RunContext& run) {
  const std::size_t count = announced(bytes);
  const std::size_t there = (bytes.size() - kHeader) / kTriangle;
  if (there < count) {
    return fail(
        ErrorCode::FileTruncated,
        fmt::format("the file breaks off: {} of {} triangles are there; copy or export it again",
                    there, count),
        {.file = file});
  }
  if (count == 0) {
    return fail(ErrorCode::MeshWithoutFaces, "the file holds no triangles; export it again",
                {.file = file});
  }
  if (3 * static_cast<std::int64_t>(count) > kMostElements) {
    return fail(ErrorCode::FileSyntax, "the mesh is too large: 700 million triangles are the most",
                {.file = file});
  }

  VertexWelder welder(count / 2 + 3);
  SurfaceMesh mesh;
  mesh.F.resize(static_cast<Eigen::Index>(count), 3);
  for (std::size_t t = 0; t < count; ++t) {
    if ((t & 0xffff) == 0xffff) {
      run.progress("reading", static_cast<double>(t) / static_cast<double>(count));
      if (run.cancelled()) return readingCancelled(file);
    }
    float xyz[9];
    std::memcpy(xyz, bytes.data() + kHeader + t * kTriangle + 12, sizeof xyz);
    for (int k = 0; k < 3; ++k) {
      const float* p = xyz + 3 * k;
      if (!std::isfinite(p[0]) || !std::isfinite(p[1]) || !std::isfinite(p[2])) {
        return fail(
            ErrorCode::NonFiniteVertex,
            fmt::format("corner {} of triangle {} is ({}, {}, {}); remove or place it where the "
                        "mesh was made",
                        k + 1, t + 1, p[0], p[1], p[2]),
            {.file = file});
      }
      mesh.F(static_cast<Eigen::Index>(t), k) = welder.add(p[0], p[1], p[2]);
    }
  }
  mesh.V = welder.positions();
  return mesh;
}

Result<SurfaceMesh> parseText(std::string_view bytes, const std::string& file, RunContext& run) {
  LineReader lines(bytes, file);
  LineWatch watch(lines, run);
  VertexWelder welder(bytes.size() / 500);
  PolygonSoup soup;
  bool inSolid = false;
  bool inLoop = false;
  std::size_t loopBegin = 0;
  std::vector<double> corner;
  while (lines.next()) {
    if (watch.cancelled()) return readingCancelled(file);
    const std::string_view key = lines.word();
    if (isKey(key, "vertex")) {
      if (!inLoop) return lines.fault("a vertex outside a facet");
      corner.clear();
      if (auto ok = readPoint(lines, corner); !ok) return passOn(ok);
      soup.corners.push_back(welder.add(corner[0], corner[1], corner[2]));
    } else if (isKey(key, "facet")) {
      if (!inSolid || inLoop)
        return lines.fault("a facet begins inside another or outside a solid");
    } else if (isKey(key, "outer")) {
      if (!inSolid || inLoop) return lines.fault("a loop begins inside another or outside a solid");
      inLoop = true;
      loopBegin = soup.corners.size();
    } else if (isKey(key, "endloop")) {
      const std::size_t size = soup.corners.size() - loopBegin;
      if (!inLoop || size < 3)
        return lines.fault(fmt::format("a facet with {} corners", inLoop ? size : 0));
      soup.size.push_back(static_cast<std::int32_t>(size));
      soup.part.push_back(static_cast<std::int32_t>(soup.partNames.size()) - 1);
      inLoop = false;
    } else if (isKey(key, "solid")) {
      if (inSolid) return lines.fault("a solid begins inside another");
      inSolid = true;
      const std::string name(lines.rest());
      soup.partNames.push_back(name.empty() ? fmt::format("solid {}", soup.partNames.size() + 1)
                                            : name);
    } else if (isKey(key, "endsolid")) {
      if (!inSolid || inLoop) return lines.fault("endsolid stands where no solid ends");
      inSolid = false;
    } else if (!isKey(key, "endfacet")) {
      return lines.fault("this is no line of an STL file");
    }
  }
  if (inSolid) return lines.brokenOff("endsolid is missing");
  if (soup.partNames.size() < 2) {
    soup.part.clear();
    soup.partNames.clear();
  }
  const Positions V = welder.positions();
  soup.xyz.assign(V.data(), V.data() + V.size());
  return finishedMesh(soup, file);
}

}  // namespace

Result<SurfaceMesh> parseStl(std::string_view bytes, const std::string& file, RunContext& run) {
  // "solid" proves nothing, binary headers begin with it too; a binary file's size tells
  const bool sized = bytes.size() >= kHeader &&
                     bytes.size() == kHeader + kTriangle * std::size_t{announced(bytes)};
  const auto word = bytes.find_first_not_of(" \t\r\n");
  const bool solid = word != bytes.npos && isKey(bytes.substr(word, 5), "solid");
  const bool text = bytes.substr(0, 1024).find('\0') == bytes.npos;
  if (!sized && solid && text) return parseText(bytes, file, run);
  if (!sized && text) {
    return fail(ErrorCode::FileUnknownFormat, "this is no STL file, neither text nor binary",
                {.file = file});
  }
  if (bytes.size() < kHeader) {
    return fail(ErrorCode::FileTruncated,
                "the file breaks off in its header; copy or export it again", {.file = file});
  }
  return parseBinary(bytes, file, run);
}

}  // namespace ecorche::mesh
