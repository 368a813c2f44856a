#include <ecorche/core/parallel.h>
#include <ecorche/render/shading_mesh.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <numbers>

namespace ecorche::render {
namespace {

using mesh::Vector3;

struct CornerFan {
  std::vector<std::int32_t> first;   // #V+1
  std::vector<std::int32_t> corner;  // 3·face + k, ascending per vertex
};

CornerFan cornersOfVertices(const mesh::SurfaceMesh& m) {
  CornerFan fan;
  fan.first.assign(static_cast<std::size_t>(m.V.rows()) + 1, 0);
  for (Eigen::Index i = 0; i < m.F.size(); ++i)
    ++fan.first[static_cast<std::size_t>(m.F.data()[i]) + 1];
  for (std::size_t v = 1; v < fan.first.size(); ++v) fan.first[v] += fan.first[v - 1];
  fan.corner.resize(static_cast<std::size_t>(m.F.size()));
  std::vector<std::int32_t> next(fan.first.begin(), fan.first.end() - 1);
  for (Eigen::Index i = 0; i < m.F.size(); ++i)
    fan.corner[static_cast<std::size_t>(next[static_cast<std::size_t>(m.F.data()[i])]++)] =
        static_cast<std::int32_t>(i);
  return fan;
}

double angleAt(const mesh::SurfaceMesh& m, Eigen::Index face, int corner) {
  const Vector3 o = m.V.row(m.F(face, corner));
  const Vector3 a = Vector3(m.V.row(m.F(face, (corner + 1) % 3))) - o;
  const Vector3 b = Vector3(m.V.row(m.F(face, (corner + 2) % 3))) - o;
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

// Two corners of one vertex belong together where their faces share an edge there, run the same way
// round and turn by less than the crease angle. Fans are short (about six), so all pairs are looked
// at.
void groupCorners(const mesh::SurfaceMesh& m, const mesh::Directions& faceNormal, double creaseCos,
                  const std::int32_t* corners, int count, std::int32_t* group) {
  for (int i = 0; i < count; ++i) group[i] = i;
  const auto root = [&](int i) {
    while (group[i] != i) i = group[i];
    return i;
  };
  const auto after = [&](std::int32_t c) { return m.F(c / 3, (c % 3 + 1) % 3); };
  const auto before = [&](std::int32_t c) { return m.F(c / 3, (c % 3 + 2) % 3); };
  for (int i = 0; i < count; ++i)
    for (int j = i + 1; j < count; ++j) {
      const std::int32_t a = corners[i];
      const std::int32_t b = corners[j];
      if (after(a) != before(b) && before(a) != after(b)) continue;
      // A face without area has no direction: it passes smoothness on.
      const bool sliver = faceNormal.row(a / 3).isZero(0.0) || faceNormal.row(b / 3).isZero(0.0);
      if (!sliver && faceNormal.row(a / 3).dot(faceNormal.row(b / 3)) < creaseCos) continue;
      const int ra = root(i);
      const int rb = root(j);
      group[std::max(ra, rb)] = std::min(ra, rb);
    }
  for (int i = 0; i < count; ++i) group[i] = root(i);
}

// One round: each normal becomes the mean of its own and the normals at the far ends of its edges.
void smoothNormals(ShadingMesh& s, int rounds) {
  for (int round = 0; round < rounds; ++round) {
    mesh::Directions sum = 2.0 * s.normals;
    for (Eigen::Index f = 0; f < s.F.rows(); ++f)
      for (int k = 0; k < 3; ++k) {
        sum.row(s.F(f, k)) += 0.5 * s.normals.row(s.F(f, (k + 1) % 3));
        sum.row(s.F(f, k)) += 0.5 * s.normals.row(s.F(f, (k + 2) % 3));
      }
    for (Eigen::Index n = 0; n < sum.rows(); ++n) {
      const double length = sum.row(n).norm();
      if (length > 0.0) s.normals.row(n) = sum.row(n) / length;
    }
  }
}

}  // namespace

ShadingMesh shadingMesh(const mesh::SurfaceMesh& m, const NormalOptions& options) {
  const double creaseCos =
      options.creaseDeg >= 180.0 ? -2.0 : std::cos(options.creaseDeg * std::numbers::pi / 180.0);

  mesh::Directions faceNormal(m.F.rows(), 3);
  parallelFor(m.F.rows(), [&](std::int64_t f) {
    const Vector3 a = m.V.row(m.F(f, 0));
    const Vector3 b = m.V.row(m.F(f, 1));
    const Vector3 c = m.V.row(m.F(f, 2));
    const Vector3 n = (b - a).cross(c - a);
    const double length = n.norm();
    faceNormal.row(f) = length > 0.0 ? Vector3(n / length) : Vector3::Zero();
  });

  // Groups per corner, counted per vertex, then numbered
  const CornerFan fan = cornersOfVertices(m);
  const auto vertexCount = static_cast<std::int64_t>(m.V.rows());
  std::vector<std::int32_t> group(fan.corner.size());
  std::vector<std::int32_t> firstGroup(static_cast<std::size_t>(vertexCount) + 1, 0);
  parallelFor(vertexCount, [&](std::int64_t v) {
    const auto i = static_cast<std::size_t>(v);
    const std::int32_t begin = fan.first[i];
    const std::int32_t count = fan.first[i + 1] - begin;
    groupCorners(m, faceNormal, creaseCos, fan.corner.data() + begin, count, group.data() + begin);
    std::int32_t groups = 0;
    for (std::int32_t k = 0; k < count; ++k)
      groups += group[static_cast<std::size_t>(begin + k)] == k;
    firstGroup[i + 1] = groups;
  });
  for (std::size_t v = 1; v < firstGroup.size(); ++v) firstGroup[v] += firstGroup[v - 1];

  ShadingMesh s;
  s.vertex.resize(static_cast<std::size_t>(firstGroup.back()));
  s.normals.setZero(firstGroup.back(), 3);
  s.F.resize(m.F.rows(), 3);
  parallelFor(vertexCount, [&](std::int64_t v) {
    const auto i = static_cast<std::size_t>(v);
    const std::int32_t begin = fan.first[i];
    std::int32_t next = firstGroup[i];
    std::vector<std::int32_t> number(static_cast<std::size_t>(fan.first[i + 1] - begin));
    for (std::int32_t k = begin; k < fan.first[i + 1]; ++k) {
      const std::int32_t corner = fan.corner[static_cast<std::size_t>(k)];
      const std::int32_t g = group[static_cast<std::size_t>(k)];
      if (g == k - begin) number[static_cast<std::size_t>(g)] = next++;
      const std::int32_t n = number[static_cast<std::size_t>(g)];
      s.F.data()[corner] = n;
      s.vertex[static_cast<std::size_t>(n)] = static_cast<std::int32_t>(v);
      s.normals.row(n) += angleAt(m, corner / 3, corner % 3) * faceNormal.row(corner / 3);
    }
    for (std::int32_t n = firstGroup[i]; n < firstGroup[i + 1]; ++n) {
      const double length = s.normals.row(n).norm();
      if (length > 0.0) s.normals.row(n) /= length;
    }
  });
  smoothNormals(s, options.smoothing);
  return s;
}

}  // namespace ecorche::render
