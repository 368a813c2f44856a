#include <ecorche/render/far_faces.h>

#include <algorithm>
#include <array>
#include <limits>

namespace ecorche::render {
namespace {

using mesh::Vector3;

constexpr Eigen::Index kFewFaces = 64;
constexpr std::array kCells{1024, 512, 256, 128, 64, 32, 16, 8, 4};  // along the diagonal

// Of every shading vertex: which one stands for its cell.
std::vector<std::int32_t> standIns(const mesh::SurfaceMesh& mesh, const ShadingMesh& shading,
                                   const mesh::Box& box, double cell) {
  struct Placed {
    std::uint64_t cell;
    std::int32_t vertex;
  };
  const auto count = shading.vertex.size();
  std::vector<Placed> placed(count);
  const auto at = [&](std::int32_t n) -> Vector3 {
    return mesh.V.row(shading.vertex[static_cast<std::size_t>(n)]).transpose();
  };
  for (std::size_t n = 0; n < count; ++n) {
    const auto vertex = static_cast<std::int32_t>(n);
    const Vector3 p = (at(vertex) - box.lo) / cell;
    std::uint64_t key = 0;
    for (Eigen::Index c = 0; c < 3; ++c)
      key = key << 16 | static_cast<std::uint64_t>(std::clamp(p(c), 0.0, 65535.0));
    placed[n] = {key, vertex};
  }
  std::ranges::sort(placed, [](const Placed& a, const Placed& b) {
    return a.cell != b.cell ? a.cell < b.cell : a.vertex < b.vertex;
  });
  std::vector<std::int32_t> out(count);
  for (std::size_t begin = 0; begin < count;) {
    std::size_t end = begin;
    Vector3 mean = Vector3::Zero();
    for (; end < count && placed[end].cell == placed[begin].cell; ++end)
      mean += at(placed[end].vertex);
    mean /= static_cast<double>(end - begin);
    std::int32_t best = placed[begin].vertex;
    for (std::size_t i = begin; i < end; ++i) {
      if ((at(placed[i].vertex) - mean).squaredNorm() < (at(best) - mean).squaredNorm())
        best = placed[i].vertex;
    }
    for (std::size_t i = begin; i < end; ++i)
      out[static_cast<std::size_t>(placed[i].vertex)] = best;
    begin = end;
  }
  return out;
}

}  // namespace

std::vector<FarFaces> farFaces(const mesh::SurfaceMesh& mesh, const ShadingMesh& shading) {
  std::vector<FarFaces> out;
  const mesh::Box box = mesh::boundingBox(mesh);
  if (shading.F.rows() < kFewFaces || !(box.diagonal() > 0.0)) return out;
  auto before = static_cast<std::size_t>(shading.F.rows());
  for (const int cells : kCells) {
    const double cell = box.diagonal() / cells;
    const std::vector<std::int32_t> in = standIns(mesh, shading, box, cell);
    std::vector<std::array<std::uint32_t, 3>> faces;
    for (Eigen::Index f = 0; f < shading.F.rows(); ++f) {
      std::array<std::uint32_t, 3> t{};
      for (int k = 0; k < 3; ++k)
        t[static_cast<std::size_t>(k)] =
            static_cast<std::uint32_t>(in[static_cast<std::size_t>(shading.F(f, k))]);
      if (t[0] == t[1] || t[1] == t[2] || t[0] == t[2]) continue;
      // The smallest first, winding kept, so that equal ones are found
      std::ranges::rotate(t, std::ranges::min_element(t));
      faces.push_back(t);
    }
    std::ranges::sort(faces);
    const auto rest = std::ranges::unique(faces);
    faces.erase(rest.begin(), rest.end());
    if (3 * faces.size() > 2 * before) continue;
    before = faces.size();
    FarFaces level;
    level.cell = cell;
    for (const auto& t : faces) level.corners.insert(level.corners.end(), t.begin(), t.end());
    out.push_back(std::move(level));
  }
  return out;
}

}  // namespace ecorche::render
