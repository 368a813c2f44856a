#pragma once

#include <ecorche/core/run_context.h>
#include <ecorche/mesh/line_reader.h>
#include <ecorche/mesh/polygon_soup.h>

namespace ecorche::mesh {

/// What the readers of text formats have in common.

/// Three coordinates from this line. @errors FileSyntax, FileTruncated, NonFiniteVertex
[[nodiscard]] Result<void> readPoint(LineReader& lines, std::vector<double>& xyz);

/// Progress and cancellation, looked at once in many lines.
class LineWatch {
 public:
  LineWatch(const LineReader& lines, RunContext& run) : lines_(lines), run_(run) {}
  [[nodiscard]] bool cancelled() { return (++count_ & 0xffff) == 0 && look(); }

 private:
  [[nodiscard]] bool look();
  const LineReader& lines_;
  RunContext& run_;
  std::uint32_t count_ = 0;
};

/// The mesh of a soup that was read. @errors MeshWithoutFaces, FileSyntax for more than 2³¹ of
/// anything
[[nodiscard]] Result<SurfaceMesh> finishedMesh(const PolygonSoup& soup, const std::string& file);

/// The error for reading that was interrupted.
[[nodiscard]] tl::unexpected<Error> readingCancelled(const std::string& file);

/// The largest number of vertices, corners or faces of a mesh.
inline constexpr std::int64_t kMostElements = std::numeric_limits<std::int32_t>::max();

}  // namespace ecorche::mesh
