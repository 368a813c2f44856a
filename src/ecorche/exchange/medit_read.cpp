#include <ecorche/core/files.h>
#include <ecorche/exchange/medit.h>
#include <ecorche/mesh/line_reader.h>
#include <fmt/format.h>

#include <algorithm>
#include <string_view>

namespace ecorche::exchange {

namespace {

using mesh::LineReader;

// Integers of the next line, the last of them a reference.
template <int Corners>
Result<std::int32_t> readSimplex(LineReader& lines, std::int64_t vertexCount, std::int32_t* corners,
                                 const char* what) {
  if (!lines.next()) return lines.brokenOff(fmt::format("the file ends among its {}", what));
  for (int k = 0; k < Corners; ++k) {
    std::int64_t v = 0;
    if (auto ok = lines.integer(v, "a vertex number"); !ok) return passOn(ok);
    if (v < 1 || v > vertexCount) {
      return lines.fault(fmt::format("vertex {} does not exist; the file has {}", v, vertexCount));
    }
    corners[k] = static_cast<std::int32_t>(v - 1);
  }
  std::int64_t reference = 0;
  if (auto ok = lines.integer(reference, "a reference"); !ok) return passOn(ok);
  return static_cast<std::int32_t>(reference);
}

// The number behind a keyword: on the same line or on the next. `least`: bytes that each line takes
// at least.
Result<std::int64_t> readCount(LineReader& lines, const char* what, std::size_t least) {
  if (lines.atLineEnd() && !lines.next())
    return lines.brokenOff(fmt::format("the number of {} is missing", what));
  std::int64_t count = 0;
  if (auto ok = lines.integer(count, what); !ok) return passOn(ok);
  // A count beyond what the file can hold is a broken file, not a reason to ask for memory
  if (count < 0 || count > INT32_MAX)
    return lines.fault(fmt::format("{} {} cannot be", count, what));
  if (least * static_cast<std::size_t>(count) > lines.size()) {
    return lines.brokenOff(
        fmt::format("{} {} are announced, more than the file can hold", count, what));
  }
  return count;
}

}  // namespace

Result<AnatomyFile> parseMedit(std::string_view bytes, const std::string& file) {
  LineReader lines(bytes, file);
  if (!lines.next() || lines.word() != "MeshVersionFormatted") {
    return lines.errorHere(
        ErrorCode::FileUnknownFormat,
        "this is no MEDIT ASCII file: it does not begin with MeshVersionFormatted");
  }

  AnatomyFile out;
  std::int64_t vertexCount = 0;
  bool ended = false;
  while (!ended && lines.next()) {
    const std::string_view keyword = lines.word();
    if (keyword == "Dimension") {
      const auto dimension = readCount(lines, "Dimension", 0);
      if (!dimension) return passOn(dimension);
      if (*dimension != 3)
        return lines.fault(fmt::format("dimension {}; a mesh in 3D is needed", *dimension));
    } else if (keyword == "Vertices") {
      const auto count = readCount(lines, "vertices", 6);
      if (!count) return passOn(count);
      // Corners that were read already would point into other vertices
      if (vertexCount > 0) return lines.fault("the file has two lists of vertices");
      vertexCount = *count;
      out.mesh.V.resize(vertexCount, 3);
      for (std::int64_t v = 0; v < vertexCount; ++v) {
        if (!lines.next()) return lines.brokenOff("the file ends among its vertices");
        for (int c = 0; c < 3; ++c) {
          if (auto ok = lines.number(out.mesh.V(v, c), "a coordinate"); !ok) return passOn(ok);
        }
      }
    } else if (keyword == "Triangles") {
      const auto count = readCount(lines, "triangles", 8);
      if (!count) return passOn(count);
      out.F.resize(*count, 3);
      out.reference.resize(static_cast<std::size_t>(*count));
      for (std::int64_t f = 0; f < *count; ++f) {
        const auto reference = readSimplex<3>(lines, vertexCount, out.F.row(f).data(), "triangles");
        if (!reference) return passOn(reference);
        out.reference[static_cast<std::size_t>(f)] = *reference;
      }
    } else if (keyword == "Tetrahedra") {
      const auto count = readCount(lines, "tetrahedra", 10);
      if (!count) return passOn(count);
      out.mesh.T.resize(*count, 4);
      out.tissue.resize(static_cast<std::size_t>(*count));
      for (std::int64_t t = 0; t < *count; ++t) {
        const auto reference =
            readSimplex<4>(lines, vertexCount, out.mesh.T.row(t).data(), "tetrahedra");
        if (!reference) return passOn(reference);
        out.tissue[static_cast<std::size_t>(t)] = *reference;
      }
    } else if (keyword == "End") {
      ended = true;
    }
    // Lines of other sections begin with numbers or keywords that mean nothing here
  }
  if (!ended) return lines.brokenOff("the file does not end with End; export it again");
  return out;
}

Result<AnatomyFile> readMedit(const std::filesystem::path& file) {
  const auto bytes = readFile(file);
  if (!bytes) return passOn(bytes);
  return parseMedit(*bytes, file.string());
}

}  // namespace ecorche::exchange
