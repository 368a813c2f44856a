// Which triangles of a volume's records an eye, or a lamp, has to be given.
#include <ecorche/core/parallel.h>
#include <ecorche/render/views.h>
#include <ecorche/render/volume_records.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace ecorche::render {

using mesh::Vector3;

namespace {

// A face that lies between the middles of pixels: seen from afar nearly all of them do, and the
// card would find out only after it has done half of its work [Wihlidal 2016].
bool missesMiddles(const std::vector<Eigen::Array2f>& screen,
                   const std::array<std::int32_t, 4>& vertex, std::uint32_t face) {
  constexpr float kSnap = 1.0f / 64.0f;  // cards round places on the screen, some as much as this
  const auto at = [&](int c) -> const Eigen::Array2f& {
    return screen[static_cast<std::size_t>(
        vertex[static_cast<std::size_t>(mesh::kTetFace[face][c])])];
  };
  const Eigen::Array2f lo = at(0).min(at(1)).min(at(2)) - kSnap;
  const Eigen::Array2f hi = at(0).max(at(1)).max(at(2)) + kSnap;
  if (!(at(0) + at(1) + at(2)).isFinite().all()) return false;
  return std::floor(hi.x()) < lo.x() || std::floor(hi.y()) < lo.y();
}

}  // namespace

// Vertices in pixels, half a pixel off so that middles are whole numbers; NaN where no number will
// do. Empty: not wanted.
std::vector<Eigen::Array2f> VolumeRecords::onScreen(const Eye& eye) const {
  if ((eye.pixels <= 0.0f).any()) return {};
  const mesh::Positions& V = geometry_->mesh().V;
  std::vector<Eigen::Array2f> out(static_cast<std::size_t>(V.rows()));
  parallelFor(
      V.rows(),
      [&](std::int64_t v) {
        const Eigen::Vector3f p = (Vector3(V.row(v).transpose()) - origin_).cast<float>();
        const Eigen::Vector4f c = eye.worldToClip * p.homogeneous();
        Eigen::Array2f& at = out[static_cast<std::size_t>(v)];
        at.setConstant(std::numeric_limits<float>::quiet_NaN());
        if (c.w() > 1e-12f) at = (0.5f * c.head<2>().array() / c.w() + 0.5f) * eye.pixels - 0.5f;
      },
      4096);
  return out;
}

void VolumeRecords::trianglesFrom(const Eye& eye, std::vector<Corner>& corners) const {
  corners.clear();
  // Groups of tets inside the picture, the nearest first
  struct Near {
    float distance;
    std::int32_t cluster;
  };
  std::vector<Near> order;
  for (std::int32_t c = 0; c < static_cast<std::int32_t>(slotsOfCluster_.size()); ++c) {
    if (slotsOfCluster_[static_cast<std::size_t>(c)].empty()) continue;
    const mesh::Box& box = geometry_->clusterBox(c);
    const Eigen::Vector3f lo = (box.lo - origin_).cast<float>();
    const Eigen::Vector3f hi = (box.hi - origin_).cast<float>();
    if (isBeyondPicture(eye.worldToClip, lo, hi)) continue;
    const Eigen::Vector3f centre = 0.5f * (lo + hi);
    order.push_back(
        {eye.parallel ? eye.forward.dot(centre - eye.at) : (centre - eye.at).norm(), c});
  }
  std::ranges::sort(order, [](const Near& a, const Near& b) {
    return a.distance != b.distance ? a.distance < b.distance : a.cluster < b.cluster;
  });

  const std::vector<Eigen::Array2f> screen = onScreen(eye);
  constexpr std::int64_t kClustersPerPart = 16;
  const auto clusters = static_cast<std::int64_t>(order.size());
  const std::int64_t partCount = (clusters + kClustersPerPart - 1) / kClustersPerPart;
  std::vector<std::vector<Corner>> parts(static_cast<std::size_t>(partCount));
  const float slack =
      1e-6f * static_cast<float>(geometry_->box().diagonal()) + 1e-6f * eye.at.norm();
  parallelFor(
      partCount,
      [&](std::int64_t part) {
        std::vector<Corner>& out = parts[static_cast<std::size_t>(part)];
        const std::int64_t end = std::min(clusters, (part + 1) * kClustersPerPart);
        for (std::int64_t i = part * kClustersPerPart; i < end; ++i) {
          const std::int32_t cluster = order[static_cast<std::size_t>(i)].cluster;
          for (const std::int32_t slot : slotsOfCluster_[static_cast<std::size_t>(cluster)]) {
            const Drawn& d = drawn_[static_cast<std::size_t>(slot)];
            bool cut = false;
            if (!kept_.empty()) {
              int kept = 0;
              for (const std::int32_t v : d.vertex) kept += kept_[static_cast<std::size_t>(v)];
              if (kept == 0) continue;
              cut = kept != 4;
            }
            // Rays go in where the coordinate of the opposite corner rises from zero
            std::uint8_t front = 0;
            float sum = 0.0f;
            for (int k = 0; k < 3; ++k) {
              const float x = eye.parallel
                                  ? -d.barycentric.block<1, 3>(k, 0).dot(eye.forward.transpose())
                                  : d.barycentric.block<1, 3>(k, 0).dot(eye.at.transpose()) +
                                        d.barycentric(k, 3);
              sum += x;
              if (x < 1e-4f) front |= static_cast<std::uint8_t>(2u << k);
            }
            if ((eye.parallel ? -sum : 1.0f - sum) < 1e-4f) front |= 1u;
            std::uint8_t faces = front & d.boundaryFaces;
            if (cut) {
              faces = front;
            } else if (d.innerFaces != 0) {
              // Seen from its seen side an interface is the back of what lies before it
              const bool away = eye.parallel
                                    ? d.interface.head<3>().dot(eye.forward) < -1e-6f
                                    : d.interface.head<3>().dot(eye.at) + d.interface.w() > slack;
              if (!away) faces |= front & d.innerFaces;
            }
            for (std::uint32_t k = 0; k < 4; ++k) {
              if ((faces >> k & 1u) == 0) continue;
              if (!screen.empty() && missesMiddles(screen, d.vertex, k)) continue;
              const bool boundary = geometry_->neighbours()(d.tet, static_cast<int>(k)) < 0;
              const std::uint32_t tag = d.record << 3 | (boundary ? k + 1 : 0u);
              for (int c = 0; c < 3; ++c)
                out.push_back({static_cast<std::uint32_t>(
                                   d.vertex[static_cast<std::size_t>(mesh::kTetFace[k][c])]),
                               tag});
            }
          }
        }
      },
      1);
  std::size_t total = 0;
  for (const auto& part : parts) total += part.size();
  corners.reserve(total);
  for (const auto& part : parts) corners.insert(corners.end(), part.begin(), part.end());
}

void VolumeRecords::surfaceTriangles(std::vector<Eigen::Vector3f>& corners) const {
  corners.clear();
  const mesh::TetMesh& mesh = geometry_->mesh();
  for (const auto& list : slotsOfCluster_)
    for (const std::int32_t slot : list) {
      const Drawn& d = drawn_[static_cast<std::size_t>(slot)];
      std::array<Eigen::Vector3f, 4> p;
      for (std::size_t k = 0; k < 4; ++k)
        p[k] = (Vector3(mesh.V.row(d.vertex[k]).transpose()) - origin_).cast<float>();
      for (std::size_t k = 0; k < 4; ++k)
        if ((d.boundaryFaces >> k & 1) != 0)
          for (int c = 0; c < 3; ++c)
            corners.push_back(p[static_cast<std::size_t>(mesh::kTetFace[k][c])]);
      if (d.innerFaces == 0) continue;

      // Seen less hidden at the corners; where its sign changes along edges lies the surface
      const Texel* record = &texels_[d.record];
      const std::uint32_t seen = record[3][0] & 0xffu;
      const std::uint32_t count = seen + (record[3][0] >> 8 & 0xffu);
      std::array<float, 4> above{};
      for (std::size_t k = 0; k < 4; ++k) {
        float most[2] = {-std::numeric_limits<float>::infinity(),
                         -std::numeric_limits<float>::infinity()};
        for (std::uint32_t i = 0; i < count; ++i) {
          const float x = i == 0 ? 0.0f : std::bit_cast<float>(record[3 + i][k]);
          float& m = most[i < seen ? 0 : 1];
          m = std::max(m, x);
        }
        above[k] = most[0] - most[1];
      }
      std::vector<std::size_t> in, out;
      for (std::size_t k = 0; k < 4; ++k) (above[k] > 0.0f ? in : out).push_back(k);
      if (in.empty() || out.empty()) continue;
      const auto on = [&](std::size_t i, std::size_t o) -> Eigen::Vector3f {
        return p[i] + (p[o] - p[i]) * (above[i] / (above[i] - above[o]));
      };
      if (in.size() == 2) {
        const Eigen::Vector3f q[4] = {on(in[0], out[0]), on(in[0], out[1]), on(in[1], out[1]),
                                      on(in[1], out[0])};
        for (const int k : {0, 1, 2, 0, 2, 3}) corners.push_back(q[k]);
      } else {
        const bool one = in.size() == 1;
        for (std::size_t k = 0; k < 3; ++k)
          corners.push_back(one ? on(in[0], out[k]) : on(in[k], out[0]));
      }
    }
}

}  // namespace ecorche::render
