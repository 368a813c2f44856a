#include <ecorche/core/contract.h>
#include <ecorche/core/parallel.h>
#include <ecorche/render/shading_mesh.h>
#include <ecorche/render/volume_geometry.h>
#include <tbb/parallel_sort.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace ecorche::render {
namespace {

using mesh::Vector3;

constexpr int kClusterTets = 512;
constexpr int kLeafFaces = 4;
constexpr double kBoundaryCreaseDeg = 50.0;

Vector3 corner(const mesh::TetMesh& mesh, Eigen::Index tet, int k) {
  return mesh.V.row(mesh.T(tet, k)).transpose();
}

// Ten bits of each coordinate, interleaved [Morton 1966].
std::uint32_t mortonCode(const Eigen::Array3d& unit) {
  const auto spread = [](double x) {
    auto v = static_cast<std::uint32_t>(std::clamp(x * 1024.0, 0.0, 1023.0));
    v = (v | (v << 16)) & 0x030000ffu;
    v = (v | (v << 8)) & 0x0300f00fu;
    v = (v | (v << 4)) & 0x030c30c3u;
    return (v | (v << 2)) & 0x09249249u;
  };
  return spread(unit.x()) | spread(unit.y()) << 1 | spread(unit.z()) << 2;
}

}  // namespace

int sideOfEdge(const Ray& ray, const mesh::Positions& V, std::int32_t a, std::int32_t b) {
  const std::int32_t first = std::min(a, b);
  const std::int32_t second = std::max(a, b);
  const Vector3 p = V.row(first).transpose() - ray.from;
  const Vector3 q = V.row(second).transpose() - ray.from;
  const int side = ray.direction.dot(p.cross(q)) < 0.0 ? 1 : -1;
  return first == a ? side : -side;
}

VolumeGeometry::VolumeGeometry(std::shared_ptr<const mesh::TetMesh> mesh,
                               const mesh::TetNeighbours& neighbours)
    : mesh_(std::move(mesh)), neighbours_(neighbours) {
  EC_REQUIRE(mesh_ != nullptr);
  EC_REQUIRE_EQ(neighbours_.rows(), mesh_->T.rows());
  around_ = mesh::vertexTets(mesh_->T, mesh_->V.rows());
  box_ = mesh::boundingBox(mesh_->V);
  makeStencils();
  makeBoundary();
  makeClusters();
  makeTree();
}

void VolumeGeometry::makeStencils() {
  const auto vertexCount = static_cast<std::int64_t>(mesh_->V.rows());
  stencils_.first.assign(static_cast<std::size_t>(vertexCount) + 1, 0);
  const auto ringOf = [&](std::int64_t v, std::vector<std::int32_t>& ring) {
    ring.clear();
    const auto i = static_cast<std::size_t>(v);
    for (std::int32_t n = around_.first[i]; n < around_.first[i + 1]; ++n)
      for (int k = 0; k < 4; ++k)
        ring.push_back(mesh_->T(around_.tet[static_cast<std::size_t>(n)], k));
    std::ranges::sort(ring);
    ring.erase(std::unique(ring.begin(), ring.end()), ring.end());
  };
  parallelFor(vertexCount, [&](std::int64_t v) {
    thread_local std::vector<std::int32_t> ring;
    ringOf(v, ring);
    stencils_.first[static_cast<std::size_t>(v) + 1] = static_cast<std::int64_t>(ring.size());
  });
  std::partial_sum(stencils_.first.begin(), stencils_.first.end(), stencils_.first.begin());
  stencils_.vertex.resize(static_cast<std::size_t>(stencils_.first.back()));
  stencils_.gradient.resize(stencils_.vertex.size());
  stencils_.mean.resize(stencils_.vertex.size());

  // V ∇λ_k = −(area vector of the face opposite k) / 3
  parallelFor(vertexCount, [&](std::int64_t v) {
    thread_local std::vector<std::int32_t> ring;
    thread_local std::vector<Vector3> weight;
    ringOf(v, ring);
    weight.assign(ring.size(), Vector3::Zero());
    double volume = 0.0;
    const auto i = static_cast<std::size_t>(v);
    for (std::int32_t n = around_.first[i]; n < around_.first[i + 1]; ++n) {
      const std::int32_t t = around_.tet[static_cast<std::size_t>(n)];
      volume += std::abs(mesh::signedVolume(*mesh_, t));
      for (int k = 0; k < 4; ++k) {
        const Vector3 a = corner(*mesh_, t, mesh::kTetFace[k][0]);
        const Vector3 b = corner(*mesh_, t, mesh::kTetFace[k][1]);
        const Vector3 c = corner(*mesh_, t, mesh::kTetFace[k][2]);
        const auto at = std::ranges::lower_bound(ring, mesh_->T(t, k)) - ring.begin();
        weight[static_cast<std::size_t>(at)] -= (b - a).cross(c - a) / 6.0;
      }
    }
    // The middle of the neighbours is not v: what a linear field gains on the way there is taken
    // off
    const auto begin = static_cast<std::size_t>(stencils_.first[i]);
    Vector3 away = Vector3::Zero();
    for (const std::int32_t u : ring) away += (mesh_->V.row(u) - mesh_->V.row(v)).transpose();
    away /= static_cast<double>(ring.size());
    for (std::size_t k = 0; k < ring.size(); ++k) {
      const Vector3 g = volume > 0.0 ? Vector3(weight[k] / volume) : Vector3::Zero();
      stencils_.vertex[begin + k] = ring[k];
      stencils_.gradient[begin + k] = g.cast<float>();
      stencils_.mean[begin + k] =
          static_cast<float>(1.0 / static_cast<double>(ring.size()) - away.dot(g));
    }
  });
}

void VolumeGeometry::makeBoundary() {
  boundary_ = mesh::tetBoundary(mesh_->T, neighbours_);
  firstFace_.assign(static_cast<std::size_t>(mesh_->T.rows()), -1);
  for (std::size_t f = boundary_.tet.size(); f-- > 0;)
    firstFace_[static_cast<std::size_t>(boundary_.tet[f])] = static_cast<std::int32_t>(f);

  mesh::SurfaceMesh surface;
  surface.V = mesh_->V;
  surface.F = boundary_.F;
  const ShadingMesh shading =
      shadingMesh(surface, {.creaseDeg = kBoundaryCreaseDeg, .smoothing = 1});
  faceNormals_.resize(boundary_.tet.size());
  for (std::size_t f = 0; f < faceNormals_.size(); ++f)
    for (int k = 0; k < 3; ++k)
      faceNormals_[f][static_cast<std::size_t>(k)] =
          shading.normals.row(shading.F(static_cast<Eigen::Index>(f), k)).transpose().cast<float>();
}

void VolumeGeometry::makeClusters() {
  const auto tetCount = static_cast<std::int64_t>(mesh_->T.rows());
  const Eigen::Array3d size =
      box_.empty() ? Eigen::Array3d::Ones() : (box_.hi - box_.lo).array().max(1e-30).eval();
  std::vector<std::pair<std::uint32_t, std::int32_t>> order(static_cast<std::size_t>(tetCount));
  parallelFor(tetCount, [&](std::int64_t t) {
    const Vector3 centre = 0.25 * (corner(*mesh_, t, 0) + corner(*mesh_, t, 1) +
                                   corner(*mesh_, t, 2) + corner(*mesh_, t, 3));
    order[static_cast<std::size_t>(t)] = {mortonCode((centre - box_.lo).array() / size),
                                          static_cast<std::int32_t>(t)};
  });
  tbb::parallel_sort(order.begin(), order.end());
  cluster_.resize(order.size());
  byCluster_.resize(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    byCluster_[i] = order[i].second;
    cluster_[static_cast<std::size_t>(order[i].second)] =
        static_cast<std::int32_t>(i / kClusterTets);
  }
  clusterCount_ = static_cast<std::int32_t>((order.size() + kClusterTets - 1) / kClusterTets);
  clusterBoxes_.assign(static_cast<std::size_t>(clusterCount_), mesh::Box{});
  for (std::int64_t t = 0; t < tetCount; ++t)
    for (int k = 0; k < 4; ++k)
      clusterBoxes_[static_cast<std::size_t>(cluster_[static_cast<std::size_t>(t)])].add(
          corner(*mesh_, t, k));
}

void VolumeGeometry::makeTree() {
  const std::size_t faceCount = boundary_.tet.size();
  order_.resize(faceCount);
  std::iota(order_.begin(), order_.end(), 0);
  nodes_.clear();
  if (faceCount == 0) return;
  // Single precision has to hold the faces: boxes grow by more than rounding takes
  const float slack =
      static_cast<float>(1e-6 * (box_.diagonal() + box_.lo.norm() + box_.hi.norm()));
  std::vector<Eigen::Array3f> lo(faceCount);
  std::vector<Eigen::Array3f> hi(faceCount);
  for (std::size_t f = 0; f < faceCount; ++f) {
    lo[f] = hi[f] =
        mesh_->V.row(boundary_.F(static_cast<Eigen::Index>(f), 0)).transpose().cast<float>();
    for (int k = 1; k < 3; ++k) {
      const Eigen::Array3f p =
          mesh_->V.row(boundary_.F(static_cast<Eigen::Index>(f), k)).transpose().cast<float>();
      lo[f] = lo[f].min(p);
      hi[f] = hi[f].max(p);
    }
    lo[f] -= slack;
    hi[f] += slack;
  }

  struct Task {
    std::size_t node, first, count;
  };
  nodes_.emplace_back();
  std::vector<Task> tasks{{0, 0, faceCount}};
  while (!tasks.empty()) {
    const Task task = tasks.back();
    tasks.pop_back();
    Node node;
    node.lo = Eigen::Array3f::Constant(std::numeric_limits<float>::infinity());
    node.hi = -node.lo;
    for (std::size_t i = task.first; i < task.first + task.count; ++i) {
      const auto f = static_cast<std::size_t>(order_[i]);
      node.lo = node.lo.min(lo[f]);
      node.hi = node.hi.max(hi[f]);
    }
    if (task.count <= kLeafFaces) {
      node.first = static_cast<std::int32_t>(task.first);
      node.count = static_cast<std::int32_t>(task.count);
      nodes_[task.node] = node;
      continue;
    }
    Eigen::Index axis = 0;
    (node.hi - node.lo).maxCoeff(&axis);
    const std::size_t half = task.count / 2;
    const auto begin = order_.begin() + static_cast<std::ptrdiff_t>(task.first);
    std::nth_element(begin, begin + static_cast<std::ptrdiff_t>(half),
                     begin + static_cast<std::ptrdiff_t>(task.count),
                     [&](std::int32_t a, std::int32_t b) {
                       const auto i = static_cast<std::size_t>(a);
                       const auto j = static_cast<std::size_t>(b);
                       return lo[i](axis) + hi[i](axis) < lo[j](axis) + hi[j](axis);
                     });
    node.first = static_cast<std::int32_t>(nodes_.size());
    nodes_[task.node] = node;
    const std::size_t left = nodes_.size();
    nodes_.emplace_back();
    nodes_.emplace_back();
    tasks.push_back({left, task.first, half});
    tasks.push_back({left + 1, task.first + half, task.count - half});
  }
}

std::vector<VolumeGeometry::Entry> VolumeGeometry::entries(const Ray& ray) const {
  std::vector<Entry> found;
  if (nodes_.empty()) return found;
  const Vector3 inverse = ray.direction.cwiseInverse();
  const auto meets = [&](const Node& node) {
    double from = -std::numeric_limits<double>::infinity();
    double to = std::numeric_limits<double>::infinity();
    for (int c = 0; c < 3; ++c) {
      if (ray.direction(c) == 0.0) {
        if (ray.from(c) < static_cast<double>(node.lo(c)) ||
            ray.from(c) > static_cast<double>(node.hi(c)))
          return false;
        continue;
      }
      const double a = (static_cast<double>(node.lo(c)) - ray.from(c)) * inverse(c);
      const double b = (static_cast<double>(node.hi(c)) - ray.from(c)) * inverse(c);
      from = std::max(from, std::min(a, b));
      to = std::min(to, std::max(a, b));
    }
    return from <= to;
  };
  std::array<std::int32_t, 64> stack;
  std::size_t depth = 0;
  stack[depth++] = 0;
  while (depth > 0) {
    const Node& node = nodes_[static_cast<std::size_t>(stack[--depth])];
    if (!meets(node)) continue;
    if (node.count == 0) {
      stack[depth++] = node.first;
      stack[depth++] = node.first + 1;
      continue;
    }
    for (std::int32_t i = node.first; i < node.first + node.count; ++i) {
      const std::int32_t f = order_[static_cast<std::size_t>(i)];
      const std::int32_t a = boundary_.F(f, 0);
      const std::int32_t b = boundary_.F(f, 1);
      const std::int32_t c = boundary_.F(f, 2);
      // Counter-clockwise as the ray sees it: it goes in there
      if (sideOfEdge(ray, mesh_->V, a, b) < 0 || sideOfEdge(ray, mesh_->V, b, c) < 0 ||
          sideOfEdge(ray, mesh_->V, c, a) < 0)
        continue;
      const Vector3 p = mesh_->V.row(a).transpose();
      const Vector3 n = (Vector3(mesh_->V.row(b).transpose()) - p)
                            .cross(Vector3(mesh_->V.row(c).transpose()) - p);
      const double slope = n.dot(ray.direction);
      Entry entry;
      entry.tet = boundary_.tet[static_cast<std::size_t>(f)];
      for (int k = 0; k < 4; ++k) {
        const std::int32_t v = mesh_->T(entry.tet, k);
        if (v != a && v != b && v != c) entry.corner = k;
      }
      entry.distance =
          slope != 0.0 ? n.dot(p - ray.from) / slope : (p - ray.from).dot(ray.direction);
      found.push_back(entry);
    }
  }
  std::ranges::sort(found, [](const Entry& x, const Entry& y) {
    return x.distance != y.distance ? x.distance < y.distance : x.tet < y.tet;
  });
  return found;
}

}  // namespace ecorche::render
