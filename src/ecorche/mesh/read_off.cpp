#include <ecorche/mesh/read_lines.h>
#include <ecorche/mesh/read_off.h>
#include <fmt/format.h>

#include <algorithm>

namespace ecorche::mesh {

Result<SurfaceMesh> parseOff(std::string_view bytes, const std::string& file, RunContext& run) {
  LineReader lines(bytes, file);
  LineWatch watch(lines, run);
  if (!lines.next()) return lines.brokenOff("it lacks the number of vertices");

  // The keyword may be absent, and the counts may stand on its line
  const std::size_t keywordEnd = bytes.find("OFF");
  if (keywordEnd != bytes.npos && keywordEnd < lines.offset()) {
    const std::string_view keyword = lines.word();
    if (!keyword.ends_with("OFF") || keyword.find_first_of("4n") != keyword.npos) {
      return lines.fault("only OFF in three dimensions is read; export it so");
    }
    if (lines.atLineEnd() && !lines.next())
      return lines.brokenOff("it lacks the number of vertices");
  }
  std::int64_t vertexCount = 0;
  std::int64_t faceCount = 0;
  if (auto ok = lines.integer(vertexCount, "the number of vertices"); !ok) return passOn(ok);
  if (auto ok = lines.integer(faceCount, "the number of faces"); !ok) return passOn(ok);
  if (vertexCount < 0 || faceCount < 0 || vertexCount > kMostElements ||
      faceCount > kMostElements) {
    return lines.fault("the numbers of vertices and faces make no sense");
  }

  PolygonSoup soup;
  // Believe the counts only as far as the file's size allows: a vertex or a face takes six bytes at
  // least
  const auto most = static_cast<std::int64_t>(bytes.size() / 6);
  soup.xyz.reserve(static_cast<std::size_t>(3 * std::min(vertexCount, most)));
  soup.corners.reserve(static_cast<std::size_t>(3 * std::min(faceCount, most)));
  soup.size.reserve(static_cast<std::size_t>(std::min(faceCount, most)));
  for (std::int64_t v = 0; v < vertexCount; ++v) {
    if (!lines.next())
      return lines.brokenOff(fmt::format("{} of {} vertices are there", v, vertexCount));
    if (watch.cancelled()) return readingCancelled(file);
    if (auto ok = readPoint(lines, soup.xyz); !ok) return passOn(ok);
  }
  for (std::int64_t f = 0; f < faceCount; ++f) {
    if (!lines.next())
      return lines.brokenOff(fmt::format("{} of {} faces are there", f, faceCount));
    if (watch.cancelled()) return readingCancelled(file);
    std::int64_t size = 0;
    if (auto ok = lines.integer(size, "a face's number of corners"); !ok) return passOn(ok);
    if (size < 3 || size > kMostElements)
      return lines.fault(fmt::format("a face with {} corners", size));
    for (std::int64_t k = 0; k < size; ++k) {
      std::int64_t corner = 0;
      if (auto ok = lines.integer(corner, "a corner of a face"); !ok) return passOn(ok);
      if (corner < 0 || corner >= vertexCount) {
        return lines.fault(fmt::format("the face names vertex {}, but they go from 0 to {}", corner,
                                       vertexCount - 1));
      }
      soup.corners.push_back(static_cast<std::int32_t>(corner));
    }
    soup.size.push_back(static_cast<std::int32_t>(size));
  }
  return finishedMesh(soup, file);
}

}  // namespace ecorche::mesh
