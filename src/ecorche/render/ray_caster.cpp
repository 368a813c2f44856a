#include <ecorche/core/contract.h>
#include <ecorche/core/parallel.h>
#include <ecorche/render/ray_caster.h>
#include <ecorche/render/views.h>
#include <ecorche/render/volume_layers.h>
#include <ecorche/tissue/segmentation.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace ecorche::render {
namespace {

using mesh::Vector3;

constexpr double kNothingMet = std::numeric_limits<double>::infinity();

// The part of the ray inside one tet.
struct Step {
  std::int32_t tet = -1;
  double enter = 0.0;
  double leave = 0.0;
  bool fromOutside = false;  // through the domain's boundary
};

// Distance along the ray to the plane of a tet's face.
double distanceToFace(const mesh::TetMesh& mesh, const Ray& ray, std::int32_t tet, int k) {
  const Vector3 a = mesh.V.row(mesh.T(tet, mesh::kTetFace[k][0])).transpose();
  const Vector3 b = mesh.V.row(mesh.T(tet, mesh::kTetFace[k][1])).transpose();
  const Vector3 c = mesh.V.row(mesh.T(tet, mesh::kTetFace[k][2])).transpose();
  const Vector3 n = (b - a).cross(c - a);
  const double slope = n.dot(ray.direction);
  return slope != 0.0 ? n.dot(a - ray.from) / slope : (a - ray.from).dot(ray.direction);
}

// The face of a tet, entered through the face opposite corner `in`, through which the ray leaves.
// Seen along the ray the entered face a b c runs counter-clockwise around it; with the fourth
// corner d, it leaves through (x, y, d) if it passes left of y → d and right of x → d.
int exitFace(const mesh::TetMesh& mesh, const Ray& ray, std::int32_t tet, int in) {
  std::array<int, 3> side{};
  for (int c = 0; c < 3; ++c)
    side[static_cast<std::size_t>(c)] =
        sideOfEdge(ray, mesh.V, mesh.T(tet, mesh::kTetFace[in][c]), mesh.T(tet, in));
  for (int c = 0; c < 3; ++c) {
    if (side[static_cast<std::size_t>(c)] < 0 && side[static_cast<std::size_t>((c + 1) % 3)] > 0)
      return mesh::kTetFace[in][(c + 2) % 3];
  }
  // Rounding on a tet without volume: the nearest of the other planes
  int best = mesh::kTetFace[in][0];
  for (int c = 1; c < 3; ++c) {
    if (distanceToFace(mesh, ray, tet, mesh::kTetFace[in][c]) <
        distanceToFace(mesh, ray, tet, best))
      best = mesh::kTetFace[in][c];
  }
  return best;
}

// Calls visit(step) for every tet on the ray, front to back, until it answers false.
template <class Visit>
void walk(const VolumeGeometry& geometry, const Ray& ray, const Visit& visit) {
  const mesh::TetMesh& mesh = geometry.mesh();
  for (const VolumeGeometry::Entry& entry : geometry.entries(ray)) {
    Step step{entry.tet, entry.distance, entry.distance, true};
    int in = entry.corner;
    for (Eigen::Index steps = 0; steps <= mesh.T.rows(); ++steps) {
      const int out = exitFace(mesh, ray, step.tet, in);
      step.leave = std::max(step.enter, distanceToFace(mesh, ray, step.tet, out));
      if (step.leave >= 0.0 && !visit(step)) return;
      const std::int32_t next = geometry.neighbours()(step.tet, out);
      if (next < 0) break;
      for (int k = 0; k < 4; ++k) {
        bool shared = false;
        for (int c = 0; c < 3; ++c)
          shared = shared || mesh.T(next, k) == mesh.T(step.tet, mesh::kTetFace[out][c]);
        if (!shared) in = k;
      }
      step = {next, step.leave, step.leave, false};
    }
  }
}

// A piece of the ray that one tissue owns, within one tet.
struct Piece {
  enum class Begin : std::uint8_t { Continued, Boundary, Cut, Origin };
  Eigen::Index column = 0;
  double from = 0.0;
  double to = 0.0;
  std::int32_t tet = -1;
  Begin begin = Begin::Continued;
};

// Barycentric coordinates along the ray: at + s · rate.
struct Barycentric {
  Eigen::Vector4d at, rate;
  Eigen::Matrix<double, 4, 3> gradient;

  Barycentric(const mesh::TetMesh& mesh, std::int32_t tet, const Ray& ray) {
    const Vector3 a = mesh.V.row(mesh.T(tet, 0)).transpose();
    Eigen::Matrix3d edges;
    for (int k = 1; k < 4; ++k) edges.col(k - 1) = mesh.V.row(mesh.T(tet, k)).transpose() - a;
    gradient.bottomRows<3>() = edges.inverse();
    gradient.row(0) = -gradient.bottomRows<3>().colwise().sum();
    at = gradient * (ray.from - a);
    at(0) += 1.0;
    rate = gradient * ray.direction;
  }
};

class Caster {
 public:
  Caster(const VolumeItem& item, const std::optional<ClipPlane>& clip,
         const std::vector<TissueId>* owners)
      : item_(item),
        geometry_(*item.geometry),
        fields_(*item.fields),
        clip_(clip),
        owners_(owners) {
    // Rays through vertices and along faces are rare but for grids and cameras that look along an
    // axis: a shift that no picture shows takes them away
    nudge_ = 1e-9 * geometry_.box().diagonal() * Vector3(0.571, 0.314, -0.832);
  }

  // Calls visit(piece) for every piece of the ray that is kept, front to back, until it answers
  // false.
  template <class Visit>
  void pieces(Ray ray, const Visit& visit) {
    ray.from += nudge_;
    double keptFrom = 0.0;
    double keptTo = kNothingMet;
    bool cut = false;
    if (clip_) {
      const double here = clip_->normal.dot(ray.from - clip_->point);
      const double rate = clip_->normal.dot(ray.direction);
      if (here < 0.0) {
        if (!(rate > 0.0)) return;
        keptFrom = -here / rate;
        cut = true;
      } else if (rate < 0.0) {
        keptTo = here / -rate;
      }
    }
    bool begun = false;  // a piece of the same run lies before
    walk(geometry_, ray, [&](const Step& step) {
      if (step.enter > keptTo) return false;
      begun = begun && !step.fromOutside;
      const double from = std::max(step.enter, keptFrom);
      const double to = std::min(step.leave, keptTo);
      if (to < from) return true;
      Piece::Begin begin = Piece::Begin::Continued;
      if (!begun)
        begin = step.fromOutside && step.enter >= keptFrom ? Piece::Begin::Boundary
                : cut                                      ? Piece::Begin::Cut
                                                           : Piece::Begin::Origin;
      begun = true;
      return piecesInTet(ray, step.tet, from, to, begin, visit);
    });
  }

  std::optional<VolumeHit> cast(const Ray& ray, const VolumeLayer& layer) {
    std::optional<VolumeHit> hit;
    Ray moved = ray;
    moved.from -= layer.shift;
    Eigen::Index before = -1;
    pieces(moved, [&](const Piece& piece) {
      const Role role = layer.role[static_cast<std::size_t>(piece.column)];
      const bool seen = role == Role::Seen;
      if (piece.begin == Piece::Begin::Boundary && seen) {
        hit = hitAt(moved, piece, VolumeHit::Where::Boundary, -1);
      } else if (piece.begin == Piece::Begin::Cut && role != Role::Hidden) {
        hit = hitAt(moved, piece, VolumeHit::Where::Cut, -1);
      } else if (piece.begin == Piece::Begin::Continued && seen && before >= 0 &&
                 layer.role[static_cast<std::size_t>(before)] != Role::Seen) {
        hit = hitAt(moved, piece, VolumeHit::Where::Interface, before);
      }
      before = piece.column;
      return !hit;
    });
    return hit;
  }

 private:
  const VolumeItem& item_;
  const VolumeGeometry& geometry_;
  const tissue::FieldMatrix& fields_;
  std::optional<ClipPlane> clip_;
  const std::vector<TissueId>* owners_;
  Vector3 nudge_;
  std::array<std::int32_t, 4> lastVertex_{-1, -1, -1, -1};
  std::array<Eigen::Index, 4> lastOwner_{};
  std::vector<double> value_, rate_;

  Eigen::Index ownerOfVertex(std::int32_t v) const {
    if (owners_) return (*owners_)[static_cast<std::size_t>(v)].value - 1;
    for (std::size_t k = 0; k < 4; ++k)
      if (lastVertex_[k] == v) return lastOwner_[k];
    return tissue::ownerOf(fields_.row(v), item_.fatIsCandidate).value - 1;
  }

  template <class Visit>
  bool piecesInTet(const Ray& ray, std::int32_t tet, double from, double to, Piece::Begin begin,
                   const Visit& visit) {
    const mesh::TetMesh& mesh = geometry_.mesh();
    std::array<std::int32_t, 4> vertex{};
    std::array<Eigen::Index, 4> owner{};
    for (std::size_t k = 0; k < 4; ++k) {
      vertex[k] = mesh.T(tet, static_cast<int>(k));
      owner[k] = ownerOfVertex(vertex[k]);
    }
    lastVertex_ = vertex;
    lastOwner_ = owner;
    if (owner[0] == owner[1] && owner[0] == owner[2] && owner[0] == owner[3])
      return visit(Piece{owner[0], from, to, tet, begin});

    // Lines over the ray's parameter: value + s · rate, s from `from` on
    const Barycentric b(mesh, tet, ray);
    const Eigen::Vector4d at = b.at + from * b.rate;
    const auto columns = static_cast<std::size_t>(fields_.cols());
    value_.assign(columns, 0.0);
    rate_.assign(columns, 0.0);
    for (std::size_t k = 0; k < 4; ++k) {
      const double* row = fields_.data() + static_cast<Eigen::Index>(vertex[k]) * fields_.cols();
      const double w = at(static_cast<Eigen::Index>(k));
      const double r = b.rate(static_cast<Eigen::Index>(k));
      for (std::size_t i = 0; i < columns; ++i) {
        value_[i] += w * row[i];
        rate_[i] += r * row[i];
      }
    }
    // On top just behind the beginning; of equal lines the muscle of lowest id
    const std::size_t first = item_.fatIsCandidate ? 0 : 1;
    const auto precedes = [](std::size_t i, std::size_t j) { return i != 0 && (j == 0 || i < j); };
    std::size_t top = first;
    for (std::size_t i = first + 1; i < columns; ++i) {
      if (value_[i] > value_[top] ||
          (value_[i] == value_[top] &&
           (rate_[i] > rate_[top] || (rate_[i] == rate_[top] && precedes(i, top)))))
        top = i;
    }
    double s = 0.0;
    const double length = to - from;
    while (true) {
      // The next line that rises above the one on top
      double nextS = kNothingMet;
      std::size_t next = top;
      for (std::size_t i = first; i < columns; ++i) {
        if (!(rate_[i] > rate_[top])) continue;
        const double at2 = std::max(s, (value_[top] - value_[i]) / (rate_[i] - rate_[top]));
        if (at2 < nextS || (at2 == nextS && rate_[i] > rate_[next])) {
          nextS = at2;
          next = i;
        }
      }
      const bool last = !(nextS <= length);
      if (!visit(Piece{static_cast<Eigen::Index>(top), from + s, last ? to : from + nextS, tet,
                       begin}))
        return false;
      if (last) return true;
      top = next;
      s = nextS;
      begin = Piece::Begin::Continued;
    }
  }

  VolumeHit hitAt(const Ray& ray, const Piece& piece, VolumeHit::Where where,
                  Eigen::Index before) const {
    VolumeHit hit;
    hit.tissue = TissueId(piece.column + 1);
    hit.where = where;
    hit.tet = piece.tet;
    hit.distance = piece.from;
    hit.at = ray.from + nudge_ + piece.from * ray.direction;
    hit.normal = normalAt(ray, piece, where, before);
    return hit;
  }

  Vector3 normalAt(const Ray& ray, const Piece& piece, VolumeHit::Where where,
                   Eigen::Index before) const {
    if (where == VolumeHit::Where::Cut) return -clip_->normal.normalized();
    const mesh::TetMesh& mesh = geometry_.mesh();
    Ray nudged = ray;
    nudged.from += nudge_;
    const Barycentric b(mesh, piece.tet, nudged);
    const Eigen::Vector4d at = b.at + piece.from * b.rate;
    Eigen::Vector3f smooth = Eigen::Vector3f::Zero();
    Eigen::Vector3f flat = Eigen::Vector3f::Zero();
    if (where == VolumeHit::Where::Boundary) {
      // The entered face: its opposite corner's coordinate is about zero and rises
      int in = -1;
      for (int k = 0; k < 4; ++k)
        if (geometry_.neighbours()(piece.tet, k) < 0 && b.rate(k) > 0.0 &&
            (in < 0 || std::abs(at(k)) < std::abs(at(in))))
          in = k;
      if (in < 0) return -ray.direction;
      flat = -b.gradient.row(in).transpose().cast<float>();
      const std::int32_t firstFace = geometry_.firstBoundaryFace(piece.tet);
      std::int32_t face = firstFace;
      for (int k = 0; k < in; ++k) face += geometry_.neighbours()(piece.tet, k) < 0 ? 1 : 0;
      const auto& corner = geometry_.boundaryNormals(face);
      for (int c = 0; c < 3; ++c)
        smooth +=
            static_cast<float>(at(mesh::kTetFace[in][c])) * corner[static_cast<std::size_t>(c)];
    } else {
      Vector3 downhill = Vector3::Zero();
      for (int k = 0; k < 4; ++k) {
        const std::int32_t v = mesh.T(piece.tet, k);
        downhill += (fields_(v, before) - fields_(v, piece.column)) * b.gradient.row(k).transpose();
        smooth += static_cast<float>(at(k)) *
                  interfaceNormal(geometry_, fields_, v, piece.column, before);
      }
      flat = downhill.normalized().cast<float>();
    }
    // Fields that are equal all over the tet have no surface of their own
    const float length = smooth.norm();
    if (flat.norm() == 0.0f)
      return length > 0.0f ? Vector3((smooth / length).cast<double>()) : Vector3(-ray.direction);
    flat.normalize();
    const bool trusted = length > 0.0f && smooth.dot(flat) >= kSmoothNormalTrust * length;
    return (trusted ? smooth / length : flat).cast<double>().normalized();
  }
};

std::optional<VolumeHit> castLayers(const Ray& ray, Caster& caster,
                                    const std::vector<VolumeLayer>& layers) {
  std::optional<VolumeHit> nearest;
  for (const VolumeLayer& layer : layers) {
    if (layer.veil && nearest) break;
    const auto hit = caster.cast(ray, layer);
    if (hit && (!nearest || hit->distance < nearest->distance)) nearest = hit;
  }
  return nearest;
}

}  // namespace

std::optional<VolumeHit> castRay(const Ray& ray, const VolumeItem& item,
                                 const std::optional<ClipPlane>& clip) {
  Caster caster(item, clip, nullptr);
  return castLayers(ray, caster, volumeLayers(item));
}

TissueImage castImage(const Camera& camera, int width, int height, const VolumeItem& item,
                      const std::optional<ClipPlane>& clip) {
  EC_REQUIRE(width > 0 && height > 0);
  std::vector<VolumeLayer> layers = volumeLayers(item);
  std::erase_if(layers, [](const VolumeLayer& layer) { return layer.veil; });
  std::vector<TissueId> owners(static_cast<std::size_t>(item.fields->rows()));
  parallelFor(item.fields->rows(), [&](std::int64_t v) {
    owners[static_cast<std::size_t>(v)] = tissue::ownerOf(item.fields->row(v), item.fatIsCandidate);
  });
  TissueImage image(width, height);
  parallelFor(
      height,
      [&](std::int64_t y) {
        Caster caster(item, clip, &owners);
        for (int x = 0; x < width; ++x) {
          const Ray ray =
              rayThrough(camera, width, height, {x + 0.5, static_cast<double>(y) + 0.5});
          const auto hit = castLayers(ray, caster, layers);
          if (!hit) continue;
          const std::size_t i = image.index(x, static_cast<int>(y));
          image.tissue[i] = hit->tissue;
          image.normal[i] = hit->normal.cast<float>();
        }
      },
      1);
  return image;
}

std::vector<TissueSpan> tissuesAlong(const Ray& ray, const VolumeItem& item,
                                     const std::optional<ClipPlane>& clip) {
  std::vector<TissueSpan> spans;
  Caster caster(item, clip, nullptr);
  caster.pieces(ray, [&](const Piece& piece) {
    const TissueId tissue(piece.column + 1);
    if (!spans.empty() && spans.back().tissue == tissue && piece.begin == Piece::Begin::Continued) {
      spans.back().leave = piece.to;
    } else {
      spans.push_back({tissue, piece.from, piece.to});
    }
    return true;
  });
  return spans;
}

}  // namespace ecorche::render
