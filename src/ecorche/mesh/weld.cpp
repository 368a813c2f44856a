#include <ecorche/mesh/weld.h>

#include <bit>
#include <cstdint>

namespace ecorche::mesh {

namespace {

std::uint64_t mixed(std::uint64_t h) {
  h ^= h >> 33;
  h *= 0xff51afd7ed558ccdULL;
  h ^= h >> 33;
  return h;
}

std::uint64_t hashOf(double x, double y, double z) {
  std::uint64_t h = mixed(std::bit_cast<std::uint64_t>(x));
  h = mixed(h + std::bit_cast<std::uint64_t>(y) * 0x9e3779b97f4a7c15ULL);
  return mixed(h + std::bit_cast<std::uint64_t>(z) * 0xc2b2ae3d27d4eb4fULL);
}

}  // namespace

VertexWelder::VertexWelder(std::size_t expected) {
  xyz_.reserve(3 * expected);
  grow(std::bit_ceil(2 * expected + 16));
}

void VertexWelder::grow(std::size_t slots) {
  slots_.assign(slots, -1);
  for (std::int32_t v = 0; v < count(); ++v) {
    const double* p = &xyz_[3 * static_cast<std::size_t>(v)];
    std::size_t s = hashOf(p[0], p[1], p[2]) & (slots - 1);
    while (slots_[s] >= 0) s = (s + 1) & (slots - 1);
    slots_[s] = v;
  }
}

std::int32_t VertexWelder::add(double x, double y, double z) {
  x += 0.0;  // −0 becomes 0
  y += 0.0;
  z += 0.0;
  const std::size_t mask = slots_.size() - 1;
  std::size_t s = hashOf(x, y, z) & mask;
  for (; slots_[s] >= 0; s = (s + 1) & mask) {
    const double* p = &xyz_[3 * static_cast<std::size_t>(slots_[s])];
    if (p[0] == x && p[1] == y && p[2] == z) return slots_[s];
  }
  const std::int32_t fresh = count();
  slots_[s] = fresh;
  xyz_.insert(xyz_.end(), {x, y, z});
  if (2 * xyz_.size() / 3 > slots_.size()) grow(2 * slots_.size());
  return fresh;
}

Positions VertexWelder::positions() const {
  return Eigen::Map<const Positions>(xyz_.data(), count(), 3);
}

SurfaceMesh weldExact(const SurfaceMesh& mesh) {
  VertexWelder welder(static_cast<std::size_t>(mesh.V.rows()));
  std::vector<std::int32_t> number(static_cast<std::size_t>(mesh.V.rows()));
  for (Eigen::Index v = 0; v < mesh.V.rows(); ++v) {
    number[static_cast<std::size_t>(v)] = welder.add(mesh.V(v, 0), mesh.V(v, 1), mesh.V(v, 2));
  }
  SurfaceMesh out;
  out.name = mesh.name;
  out.parts = mesh.parts;
  out.V = welder.positions();
  out.F = mesh.F.unaryExpr([&](std::int32_t v) { return number[static_cast<std::size_t>(v)]; });
  return out;
}

}  // namespace ecorche::mesh
