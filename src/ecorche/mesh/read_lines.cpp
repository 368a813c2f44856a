#include <ecorche/mesh/read_lines.h>
#include <fmt/format.h>

#include <cmath>

namespace ecorche::mesh {

Result<void> readPoint(LineReader& lines, std::vector<double>& xyz) {
  double x = 0;
  double y = 0;
  double z = 0;
  if (auto ok = lines.number(x, "a vertex's x"); !ok) return ok;
  if (auto ok = lines.number(y, "a vertex's y"); !ok) return ok;
  if (auto ok = lines.number(z, "a vertex's z"); !ok) return ok;
  if (!std::isfinite(x + y + z) && !(std::isfinite(x) && std::isfinite(y) && std::isfinite(z))) {
    return lines.errorHere(
        ErrorCode::NonFiniteVertex,
        fmt::format("vertex {} is ({}, {}, {}); remove or place it where the mesh was made",
                    xyz.size() / 3 + 1, x, y, z));
  }
  xyz.push_back(x);
  xyz.push_back(y);
  xyz.push_back(z);
  return {};
}

bool LineWatch::look() {
  run_.progress("reading",
                static_cast<double>(lines_.offset()) / static_cast<double>(lines_.size()));
  return run_.cancelled();
}

Result<SurfaceMesh> finishedMesh(const PolygonSoup& soup, const std::string& file) {
  if (soup.size.empty()) {
    const bool points = !soup.xyz.empty();
    return fail(ErrorCode::MeshWithoutFaces,
                points ? fmt::format("the file holds {} points but no faces; a surface is needed",
                                     soup.vertexCount())
                       : std::string("the file holds no mesh; export it again"),
                {.file = file});
  }
  if (static_cast<std::int64_t>(soup.corners.size()) > kMostElements ||
      static_cast<std::int64_t>(soup.xyz.size() / 3) > kMostElements) {
    return fail(ErrorCode::FileSyntax,
                "the mesh is too large: 2 thousand million corners are the most", {.file = file});
  }
  return triangulated(soup);
}

tl::unexpected<Error> readingCancelled(const std::string& file) {
  return fail(ErrorCode::Cancelled, "reading was interrupted", {.file = file});
}

}  // namespace ecorche::mesh
