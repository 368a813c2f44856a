#include "damaged/damage.h"

#include <ecorche/mesh/weld.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "support/shapes.h"

namespace ecorche::test {

namespace {

// The standard's distributions differ between libraries; this does not
class Dice {
 public:
  explicit Dice(std::uint64_t seed) : engine_(seed) {}
  double between(double low, double high) {
    return low + (high - low) * static_cast<double>(engine_() >> 11) * 0x1p-53;
  }
  Vector3 inBox(double reach) {
    const double x = between(-reach, reach), y = between(-reach, reach);
    return {x, y, between(-reach, reach)};
  }

 private:
  std::mt19937_64 engine_;
};

Vector3 corner(const SurfaceMesh& m, Eigen::Index f, int k) {
  return m.V.row(m.F(f, k)).transpose();
}
Vector3 middle(const SurfaceMesh& m, Eigen::Index f) {
  return (corner(m, f, 0) + corner(m, f, 1) + corner(m, f, 2)) / 3.0;
}

void setFaces(SurfaceMesh& m, const std::vector<std::array<std::int32_t, 3>>& faces) {
  m.F.resize(static_cast<Eigen::Index>(faces.size()), 3);
  for (std::size_t f = 0; f < faces.size(); ++f)
    m.F.row(static_cast<Eigen::Index>(f)) << faces[f][0], faces[f][1], faces[f][2];
  m.parts.clear();
}

std::int32_t addVertex(SurfaceMesh& m, const Vector3& p) {
  m.V.conservativeResize(m.V.rows() + 1, 3);
  m.V.bottomRows(1) = p.transpose();
  return static_cast<std::int32_t>(m.V.rows() - 1);
}

std::vector<std::array<std::int32_t, 3>> facesOf(const SurfaceMesh& m) {
  std::vector<std::array<std::int32_t, 3>> out;
  for (Eigen::Index f = 0; f < m.F.rows(); ++f) out.push_back({m.F(f, 0), m.F(f, 1), m.F(f, 2)});
  return out;
}

}  // namespace

SurfaceMesh egg(const Vector3& centre, const Vector3& axes, int levels, const char* name) {
  SurfaceMesh m = sphere(Vector3::Zero(), 1.0, levels);
  m.V = ((m.V * axes.asDiagonal()).rowwise() + centre.transpose()).eval();
  m.name = name;
  return m;
}

SurfaceMesh ball(const Vector3& centre, double radius, const char* name) {
  return egg(centre, {radius, radius, radius}, 3, name);
}

SurfaceMesh ringedEgg(const Vector3& centre, const Vector3& axes, int rings, int segments,
                      const char* name) {
  SurfaceMesh m;
  m.name = name;
  m.V.resize(rings * segments + 2, 3);
  for (int r = 0; r < rings; ++r) {
    const double polar = std::numbers::pi * (r + 1) / (rings + 1);
    // Exactly at the centre's height, where the cosine is not exactly 0
    const double up = 2 * (r + 1) == rings + 1 ? 0.0 : std::cos(polar);
    for (int s = 0; s < segments; ++s) {
      const double turn = 2 * std::numbers::pi * s / segments;
      m.V.row(r * segments + s) << std::sin(polar) * std::cos(turn),
          std::sin(polar) * std::sin(turn), up;
    }
  }
  const int top = rings * segments, bottom = top + 1;
  m.V.row(top) << 0, 0, 1;
  m.V.row(bottom) << 0, 0, -1;
  std::vector<std::array<std::int32_t, 3>> faces;
  for (int s = 0; s < segments; ++s) {
    const int next = (s + 1) % segments;
    faces.push_back({top, s, next});
    faces.push_back({bottom, (rings - 1) * segments + next, (rings - 1) * segments + s});
    for (int r = 0; r + 1 < rings; ++r) {
      const int a = r * segments + s, b = r * segments + next;
      faces.push_back({a, a + segments, b + segments});
      faces.push_back({a, b + segments, b});
    }
  }
  setFaces(m, faces);
  m.V = ((m.V * axes.asDiagonal()).rowwise() + centre.transpose()).eval();
  return m;
}

SurfaceMesh insideOut(SurfaceMesh m) {
  m.F.col(1).swap(m.F.col(2));
  return m;
}

SurfaceMesh flipped(SurfaceMesh m, double share, std::uint64_t seed) {
  Dice dice(seed);
  for (Eigen::Index f = 0; f < m.F.rows(); ++f) {
    if (dice.between(0, 1) < share) std::swap(m.F(f, 1), m.F(f, 2));
  }
  return m;
}

SurfaceMesh without(SurfaceMesh m, const Place& there) {
  auto faces = facesOf(m);
  std::vector<std::array<std::int32_t, 3>> kept;
  for (std::size_t f = 0; f < faces.size(); ++f) {
    if (!there(middle(m, static_cast<Eigen::Index>(f)))) kept.push_back(faces[f]);
  }
  setFaces(m, kept);
  return mesh::compacted(m);
}

SurfaceMesh riddled(SurfaceMesh m, double share, std::uint64_t seed) {
  Dice dice(seed);
  return without(std::move(m), [&](const Vector3&) { return dice.between(0, 1) < share; });
}

SurfaceMesh exploded(const SurfaceMesh& m, double shake, std::uint64_t seed) {
  Dice dice(seed);
  SurfaceMesh out = m;
  out.V.resize(3 * m.F.rows(), 3);
  for (Eigen::Index f = 0; f < m.F.rows(); ++f) {
    for (int k = 0; k < 3; ++k) {
      out.V.row(3 * f + k) = (corner(m, f, k) + dice.inBox(shake)).transpose();
      out.F(f, k) = static_cast<std::int32_t>(3 * f + k);
    }
  }
  return out;
}

SurfaceMesh cracked(const SurfaceMesh& m, double height, double gap) {
  SurfaceMesh out = m;
  const Eigen::Index count = m.V.rows();
  out.V.conservativeResize(2 * count, 3);
  out.V.bottomRows(count) = m.V.rowwise() + gap * Vector3::UnitZ().transpose();
  for (Eigen::Index f = 0; f < m.F.rows(); ++f) {
    if (middle(m, f).z() > height) out.F.row(f).array() += static_cast<std::int32_t>(count);
  }
  return mesh::compacted(out);
}

SurfaceMesh noisy(SurfaceMesh m, double reach, std::uint64_t seed) {
  Dice dice(seed);
  for (Eigen::Index v = 0; v < m.V.rows(); ++v) m.V.row(v) += dice.inBox(reach).transpose();
  return m;
}

SurfaceMesh doubled(SurfaceMesh m, double share, bool turned, std::uint64_t seed) {
  Dice dice(seed);
  auto faces = facesOf(m);
  const std::size_t count = faces.size();
  for (std::size_t f = 0; f < count; ++f) {
    if (dice.between(0, 1) >= share) continue;
    auto again = faces[f];
    if (turned) std::swap(again[1], again[2]);
    faces.push_back(again);
  }
  setFaces(m, faces);
  return m;
}

SurfaceMesh together(const std::vector<SurfaceMesh>& meshes, const char* name) {
  SurfaceMesh m = mesh::joined(meshes, name);
  m.parts.clear();
  return m;
}

SurfaceMesh scaled(SurfaceMesh m, double factor) {
  const Vector3 centre = mesh::boundingBox(m).centre();
  m.V = (((m.V.rowwise() - centre.transpose()) * factor).rowwise() + centre.transpose()).eval();
  return m;
}

SurfaceMesh inUnits(SurfaceMesh m, double factor) {
  m.V *= factor;
  return m;
}

SurfaceMesh moved(SurfaceMesh m, const Vector3& by) {
  m.V.rowwise() += by.transpose();
  return m;
}

SurfaceMesh pushed(SurfaceMesh m, const Place& there, const Vector3& by) {
  for (Eigen::Index v = 0; v < m.V.rows(); ++v) {
    if (there(m.V.row(v).transpose())) m.V.row(v) += by.transpose();
  }
  return m;
}

SurfaceMesh pocketed(SurfaceMesh m, const Vector3& at, double mouth, double depth) {
  const Vector3 inward = -at.normalized();
  for (Eigen::Index v = 0; v < m.V.rows(); ++v) {
    const Vector3 p = m.V.row(v).transpose();
    const double away = (p - at).norm() / mouth;
    if (away >= 1.0) continue;
    // Walls that fall steeply and a rounded bottom
    const double share = 1.0 - std::pow(away, 4);
    m.V.row(v) += (depth * share * inward).transpose();
  }
  return m;
}

SurfaceMesh subdivided(SurfaceMesh m, int times) {
  for (; times > 0; --times) {
    std::map<std::pair<std::int32_t, std::int32_t>, std::int32_t> between;
    std::vector<Vector3> fresh;
    const auto half = [&](std::int32_t a, std::int32_t b) {
      const auto next = static_cast<std::int32_t>(m.V.rows() + std::ssize(fresh));
      const auto [it, isNew] = between.try_emplace(std::minmax(a, b), next);
      if (isNew) fresh.push_back(0.5 * (m.V.row(a) + m.V.row(b)).transpose());
      return it->second;
    };
    std::vector<std::array<std::int32_t, 3>> faces;
    for (const auto& [a, b, c] : facesOf(m)) {
      const std::int32_t ab = half(a, b), bc = half(b, c), ca = half(c, a);
      faces.insert(faces.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
    }
    const Eigen::Index first = m.V.rows();
    m.V.conservativeResize(first + std::ssize(fresh), 3);
    for (std::size_t v = 0; v < fresh.size(); ++v)
      m.V.row(first + static_cast<Eigen::Index>(v)) = fresh[v].transpose();
    setFaces(m, faces);
  }
  return m;
}

SurfaceMesh withTJunctions(SurfaceMesh m, int every) {
  auto faces = facesOf(m);
  const std::size_t count = faces.size();
  for (std::size_t f = 0; f < count; f += static_cast<std::size_t>(every)) {
    const auto [a, b, c] = faces[f];
    const std::int32_t v = addVertex(m, 0.5 * (m.V.row(a) + m.V.row(b)).transpose());
    faces[f] = {a, v, c};
    faces.push_back({v, b, c});
  }
  setFaces(m, faces);
  return m;
}

SurfaceMesh withNeedles(SurfaceMesh m, int every) {
  auto faces = facesOf(m);
  const std::size_t count = faces.size();
  for (std::size_t f = 0; f < count; f += static_cast<std::size_t>(every)) {
    const auto [a, b, c] = faces[f];
    const Vector3 p = (0.5 * m.V.row(a) + 0.49999 * m.V.row(b) + 0.00001 * m.V.row(c)).transpose();
    const std::int32_t v = addVertex(m, p);
    faces[f] = {a, b, v};
    faces.push_back({b, c, v});
    faces.push_back({c, a, v});
  }
  setFaces(m, faces);
  return m;
}

SurfaceMesh withInnerWall(SurfaceMesh m, double height) {
  std::vector<std::int32_t> rim;
  Vector3 centre = Vector3::Zero();
  for (Eigen::Index v = 0; v < m.V.rows(); ++v) {
    if (std::abs(m.V(v, 2) - height) < 1e-9) rim.push_back(static_cast<std::int32_t>(v));
  }
  for (const std::int32_t v : rim) centre += m.V.row(v).transpose() / double(rim.size());
  std::sort(rim.begin(), rim.end(), [&](std::int32_t a, std::int32_t b) {
    const auto angle = [&](std::int32_t v) {
      return std::atan2(m.V(v, 1) - centre.y(), m.V(v, 0) - centre.x());
    };
    return angle(a) < angle(b);
  });
  const std::int32_t hub = addVertex(m, centre);
  auto faces = facesOf(m);
  for (std::size_t k = 0; k < rim.size(); ++k)
    faces.push_back({rim[k], rim[(k + 1) % rim.size()], hub});
  setFaces(m, faces);
  return m;
}

SurfaceMesh withCrumbs(const SurfaceMesh& m, int count, double size, const Vector3& centre,
                       double spread, std::uint64_t seed) {
  Dice dice(seed);
  std::vector<SurfaceMesh> all{m};
  for (int k = 0; k < count; ++k) {
    const Vector3 at = centre + dice.inBox(spread);
    SurfaceMesh crumb;
    crumb.V.resize(4, 3);
    crumb.V << 0, 0, 0, size, 0, 0, 0, size, 0, 0, 0, size;
    crumb.V.rowwise() += at.transpose();
    crumb.F.resize(4, 3);
    crumb.F << 0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3;
    all.push_back(std::move(crumb));
  }
  return together(all, m.name.c_str());
}

SurfaceMesh withSheets(const SurfaceMesh& m, int count, double length, const Vector3& centre,
                       double spread, std::uint64_t seed) {
  constexpr int kSteps = 4;
  Dice dice(seed);
  std::vector<SurfaceMesh> all{m};
  for (int k = 0; k < count; ++k) {
    const Vector3 at = centre + dice.inBox(spread);
    const Vector3 along = length * dice.inBox(1.0).normalized();
    const Vector3 across = 0.25 * length * along.cross(dice.inBox(1.0)).normalized();
    const Vector3 bend = 0.2 * along.cross(across) / length;
    SurfaceMesh sheet;
    sheet.name = "card" + std::to_string(k);
    sheet.V.resize(2 * (kSteps + 1), 3);
    sheet.F.resize(2 * kSteps, 3);
    for (int i = 0; i <= kSteps; ++i) {
      const double t = static_cast<double>(i) / kSteps;
      const Vector3 p = at + t * along + t * (1 - t) * bend;
      sheet.V.row(2 * i) = p.transpose();
      sheet.V.row(2 * i + 1) = (p + across).transpose();
      if (i == kSteps) break;
      sheet.F.row(2 * i) << 2 * i, 2 * i + 2, 2 * i + 3;
      sheet.F.row(2 * i + 1) << 2 * i, 2 * i + 3, 2 * i + 1;
    }
    all.push_back(std::move(sheet));
  }
  return mesh::joined(all, m.name);
}

double volumeOf(const SurfaceMesh& m) { return mesh::signedVolume(m.V, m.F); }

}  // namespace ecorche::test
