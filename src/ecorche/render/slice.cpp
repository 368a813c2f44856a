#include <ecorche/core/contract.h>
#include <ecorche/render/slice.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <unordered_map>

namespace ecorche::render {
namespace {

using mesh::Vector3;

// Cut vertices by the edge they lie on, so that neighbours share them.
class CutVertices {
 public:
  CutVertices(const mesh::TetMesh& tets, const Eigen::VectorXd& height)
      : tets_(tets), height_(height) {}

  std::int32_t on(std::int32_t a, std::int32_t b) {
    const std::int32_t lo = std::min(a, b);
    const std::int32_t hi = std::max(a, b);
    const auto key = static_cast<std::uint64_t>(lo) << 32 | static_cast<std::uint32_t>(hi);
    const auto [at, fresh] = index_.emplace(key, static_cast<std::int32_t>(points_.size()));
    if (fresh) {
      // Heights have opposite signs (0 counts as kept), so their difference is never 0
      const double t = height_(lo) / (height_(lo) - height_(hi));
      points_.push_back((1.0 - t) * Vector3(tets_.V.row(lo)) + t * Vector3(tets_.V.row(hi)));
    }
    return at->second;
  }
  [[nodiscard]] const std::vector<Vector3>& points() const { return points_; }

 private:
  const mesh::TetMesh& tets_;
  const Eigen::VectorXd& height_;
  std::unordered_map<std::uint64_t, std::int32_t> index_;
  std::vector<Vector3> points_;
};

}  // namespace

TetSlice sliceTets(const mesh::TetMesh& tets, const std::vector<TissueId>& labels,
                   const mesh::TetNeighbours& neighbours, const ClipPlane& plane) {
  EC_REQUIRE_EQ(static_cast<Eigen::Index>(labels.size()), tets.T.rows());
  EC_REQUIRE_EQ(neighbours.rows(), tets.T.rows());
  const Vector3 normal = plane.normal.normalized();
  const Eigen::VectorXd height = (tets.V.rowwise() - plane.point.transpose()) * normal;

  TetSlice slice;
  CutVertices cut(tets, height);
  std::vector<std::array<std::int32_t, 3>> faces;
  const auto labelOf = [&](Eigen::Index t) { return labels[static_cast<std::size_t>(t)]; };
  // The border of the cut on the tet's face opposite corner `opposite`, once per pair of tets
  const auto border = [&](Eigen::Index t, int opposite, std::int32_t p, std::int32_t q) {
    const std::int32_t other = neighbours(t, opposite);
    if (other >= 0 && (other < t || labelOf(other) == labelOf(t))) return;
    const TissueId a = labelOf(t);
    const TissueId b = other >= 0 ? labelOf(other) : kNoTissue;
    slice.borders.push_back({cut.points()[static_cast<std::size_t>(p)],
                             cut.points()[static_cast<std::size_t>(q)], std::max(a, b),
                             std::min(a, b)});
  };

  for (Eigen::Index t = 0; t < tets.T.rows(); ++t) {
    std::array<int, 4> kept{};
    std::array<int, 4> gone{};
    int keptCount = 0;
    int goneCount = 0;
    for (int k = 0; k < 4; ++k) {
      if (height(tets.T(t, k)) >= 0.0)
        kept[static_cast<std::size_t>(keptCount++)] = k;
      else
        gone[static_cast<std::size_t>(goneCount++)] = k;
    }
    if (keptCount == 0 || goneCount == 0) continue;

    const auto vertex = [&](int i, int j) { return cut.on(tets.T(t, i), tets.T(t, j)); };
    // Corners around the cut, and for each of its edges the face of the tet it lies on
    std::array<std::int32_t, 4> ring{};
    std::array<int, 4> opposite{};
    std::size_t size = 3;
    if (keptCount == 2) {
      size = 4;
      const auto [a, b] = std::pair(kept[0], kept[1]);
      const auto [c, d] = std::pair(gone[0], gone[1]);
      ring = {vertex(a, c), vertex(a, d), vertex(b, d), vertex(b, c)};
      opposite = {b, c, a, d};
    } else {
      const int apex = keptCount == 1 ? kept[0] : gone[0];
      const auto& base = keptCount == 1 ? gone : kept;
      ring = {vertex(apex, base[0]), vertex(apex, base[1]), vertex(apex, base[2]), 0};
      opposite = {base[2], base[0], base[1], 0};
    }
    for (std::size_t e = 0; e < size; ++e) border(t, opposite[e], ring[e], ring[(e + 1) % size]);
    // Facing what was taken away
    const auto point = [&](std::size_t i) {
      return cut.points()[static_cast<std::size_t>(ring[i])];
    };
    Vector3 area = (point(1) - point(0)).cross(point(2) - point(0));
    if (size == 4) area += (point(2) - point(0)).cross(point(3) - point(0));
    slice.area[labelOf(t)] += 0.5 * area.norm();
    const bool turn = area.dot(normal) > 0.0;
    for (std::size_t e = 1; e + 1 < size; ++e) {
      faces.push_back(turn ? std::array{ring[0], ring[e + 1], ring[e]}
                           : std::array{ring[0], ring[e], ring[e + 1]});
      slice.label.push_back(labelOf(t));
    }
  }

  slice.mesh.name = "slice";
  slice.mesh.V.resize(static_cast<Eigen::Index>(cut.points().size()), 3);
  for (std::size_t i = 0; i < cut.points().size(); ++i)
    slice.mesh.V.row(static_cast<Eigen::Index>(i)) = cut.points()[i];
  slice.mesh.F.resize(static_cast<Eigen::Index>(faces.size()), 3);
  for (std::size_t i = 0; i < faces.size(); ++i)
    slice.mesh.F.row(static_cast<Eigen::Index>(i)) << faces[i][0], faces[i][1], faces[i][2];
  return slice;
}

SurfaceSlice sliceSurface(const mesh::SurfaceMesh& surface, const ClipPlane& plane) {
  const Vector3 normal = plane.normal.normalized();
  const Vector3 ex = normal.unitOrthogonal();
  const Vector3 ey = normal.cross(ex);
  const Eigen::VectorXd height = (surface.V.rowwise() - plane.point.transpose()) * normal;

  // Cut every face to a segment, in the plane's own coordinates; ends on shared edges come out
  // bitwise equal
  struct Segment {
    Eigen::Vector2d lo, hi;  // lo.y() < hi.y()
  };
  SurfaceSlice slice;
  std::vector<Segment> segments;
  std::vector<double> levels;
  for (Eigen::Index f = 0; f < surface.F.rows(); ++f) {
    std::array<Vector3, 2> ends;
    std::size_t count = 0;
    for (int k = 0; k < 3; ++k) {
      std::int32_t a = surface.F(f, k);
      std::int32_t b = surface.F(f, (k + 1) % 3);
      if ((height(a) >= 0.0) == (height(b) >= 0.0)) continue;
      if (a > b) std::swap(a, b);
      const double t = height(a) / (height(a) - height(b));
      ends[count++] = (1.0 - t) * Vector3(surface.V.row(a)) + t * Vector3(surface.V.row(b));
    }
    if (count != 2) continue;
    slice.outline.push_back(ends);
    const auto flat = [&](const Vector3& p) {
      return Eigen::Vector2d(ex.dot(p - plane.point), ey.dot(p - plane.point));
    };
    Segment s{flat(ends[0]), flat(ends[1])};
    if (s.lo.y() == s.hi.y()) continue;
    if (s.lo.y() > s.hi.y()) std::swap(s.lo, s.hi);
    levels.push_back(s.lo.y());
    levels.push_back(s.hi.y());
    segments.push_back(s);
  }
  std::sort(levels.begin(), levels.end());
  levels.erase(std::unique(levels.begin(), levels.end()), levels.end());
  std::sort(segments.begin(), segments.end(),
            [](const Segment& a, const Segment& b) { return a.lo.y() < b.lo.y(); });

  // Between two levels segments do not end: sorted by their middles they bound trapezoids in pairs
  std::vector<Vector3> points;
  std::vector<std::array<std::int32_t, 3>> faces;
  std::vector<std::size_t> open;
  std::size_t next = 0;
  const auto xAt = [](const Segment& s, double y) {
    const double t = (y - s.lo.y()) / (s.hi.y() - s.lo.y());
    return (1.0 - t) * s.lo.x() + t * s.hi.x();
  };
  for (std::size_t level = 0; level + 1 < levels.size(); ++level) {
    const double y0 = levels[level];
    const double y1 = levels[level + 1];
    std::erase_if(open, [&](std::size_t s) { return segments[s].hi.y() <= y0; });
    while (next < segments.size() && segments[next].lo.y() <= y0) open.push_back(next++);
    const double middle = 0.5 * (y0 + y1);
    std::sort(open.begin(), open.end(), [&](std::size_t a, std::size_t b) {
      return xAt(segments[a], middle) < xAt(segments[b], middle);
    });
    for (std::size_t i = 0; i + 1 < open.size(); i += 2) {
      const Segment& l = segments[open[i]];
      const Segment& r = segments[open[i + 1]];
      const auto base = static_cast<std::int32_t>(points.size());
      for (const auto& [x, y] : {std::pair(xAt(l, y0), y0), std::pair(xAt(r, y0), y0),
                                 std::pair(xAt(r, y1), y1), std::pair(xAt(l, y1), y1)})
        points.push_back(plane.point + x * ex + y * ey);
      // ex × ey is the normal; faces look the other way
      faces.push_back({base, base + 2, base + 1});
      faces.push_back({base, base + 3, base + 2});
      slice.area += (xAt(r, middle) - xAt(l, middle)) * (y1 - y0);
    }
  }
  slice.mesh.name = surface.name;
  slice.mesh.V.resize(static_cast<Eigen::Index>(points.size()), 3);
  for (std::size_t i = 0; i < points.size(); ++i)
    slice.mesh.V.row(static_cast<Eigen::Index>(i)) = points[i];
  slice.mesh.F.resize(static_cast<Eigen::Index>(faces.size()), 3);
  for (std::size_t i = 0; i < faces.size(); ++i)
    slice.mesh.F.row(static_cast<Eigen::Index>(i)) << faces[i][0], faces[i][1], faces[i][2];
  return slice;
}

Scene withCaps(const Scene& scene) {
  Scene out = scene;
  if (!scene.clip) return out;
  mesh::Box box;
  for (const SurfaceItem& item : scene.surfaces) box.add(mesh::boundingBox(*item.mesh));
  const Vector3 normal = scene.clip->normal.normalized();
  for (std::size_t i = 0; i < scene.surfaces.size(); ++i) {
    const SurfaceItem& item = scene.surfaces[i];
    if (!item.capped || !item.clipped || item.colour[3] < 1.0f) continue;
    SurfaceSlice slice = sliceSurface(*item.mesh, *scene.clip);
    if (slice.mesh.F.rows() == 0) continue;
    // Where cuts overlap the later item shows: a hair nearer to whoever looks at the cut
    const double lift = 1e-6 * box.diagonal() * static_cast<double>(i + 1);
    slice.mesh.V.rowwise() -= (lift * normal).transpose();
    SurfaceItem cap;
    cap.name = item.name;
    auto normals = std::make_shared<mesh::Directions>(slice.mesh.V.rows(), 3);
    normals->rowwise() = -normal.transpose();
    cap.normals = normals;
    cap.mesh = std::make_shared<mesh::SurfaceMesh>(std::move(slice.mesh));
    cap.colour = item.capColour.value_or(item.colour);
    cap.roughness = 0.8f;
    cap.clipped = false;
    cap.castsShadow = false;
    out.surfaces.push_back(std::move(cap));
  }
  return out;
}

SurfaceItem sliceItem(const TetSlice& slice, const std::vector<Rgba>& colourOf) {
  SurfaceItem item;
  item.name = "slice";
  item.mesh = std::make_shared<mesh::SurfaceMesh>(slice.mesh);
  auto colours = std::make_shared<std::vector<Rgba>>();
  for (const TissueId label : slice.label) {
    const auto i = static_cast<std::size_t>(label.value);
    colours->push_back(i < colourOf.size() ? colourOf[i] : Rgba{0.3f, 0.3f, 0.3f, 1.0f});
  }
  item.faceColours = colours;
  // The cut is flat: one normal for all, whatever slivers the tets leave
  if (slice.mesh.F.rows() > 0) {
    Vector3 sum = Vector3::Zero();
    for (Eigen::Index f = 0; f < slice.mesh.F.rows(); ++f) {
      const Vector3 a = slice.mesh.V.row(slice.mesh.F(f, 0));
      const Vector3 b = slice.mesh.V.row(slice.mesh.F(f, 1));
      const Vector3 c = slice.mesh.V.row(slice.mesh.F(f, 2));
      sum += (b - a).cross(c - a);
    }
    auto normals = std::make_shared<mesh::Directions>(slice.mesh.V.rows(), 3);
    normals->rowwise() = sum.normalized().transpose();
    item.normals = normals;
  }
  item.roughness = 0.75f;
  item.clipped = false;
  return item;
}

LineItem sliceBorders(const TetSlice& slice, float widthPixels) {
  auto lines = std::make_shared<std::vector<std::vector<Vector3>>>();
  for (const TetSlice::Border& b : slice.borders) lines->push_back({b.from, b.to});
  LineItem item;
  item.name = "slice borders";
  item.lines = lines;
  item.colour = {0.045f, 0.02f, 0.018f, 1.0f};
  item.widthPixels = widthPixels;
  return item;
}

}  // namespace ecorche::render
