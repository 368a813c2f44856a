#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <ecorche/core/index.h>
#include <ecorche/mesh/open_sheets.h>
#include <ecorche/mesh/self_intersection.h>
#include <ecorche/mesh/surface_check.h>
#include <ecorche/mesh/surface_topology.h>
#include <ecorche/mesh/weld.h>
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <iterator>
#include <numeric>

namespace ecorche::mesh {

namespace {

using Point = CGAL::Exact_predicates_inexact_constructions_kernel::Point_3;

constexpr std::size_t kToldApart = 8;  // of what there may be thousands of

class Checker {
 public:
  explicit Checker(const SurfaceMesh& mesh) : mesh_(mesh) {}

  SurfaceCheck run(const SurfaceCheckOptions& options) {
    vertices();
    if (check_.nonFiniteVertices > 0) return std::move(check_);
    faces();
    edges_ = surfaceEdges(mesh_.F);
    labels_ = components(mesh_.F, edges_);
    faceCount_.assign(toIndex(labels_.count), 0);
    for (const std::int32_t piece : labels_.label) ++faceCount_[toIndex(piece)];
    edges();
    fans();
    holes();
    pieces();
    if (options.selfIntersections) crossings();
    return std::move(check_);
  }

 private:
  [[nodiscard]] Vector3 at(std::int32_t v) const { return mesh_.V.row(v).transpose(); }
  [[nodiscard]] Vector3 middle(Eigen::Index f) const {
    return (at(mesh_.F(f, 0)) + at(mesh_.F(f, 1)) + at(mesh_.F(f, 2))) / 3.0;
  }

  void find(Severity severity, const char* kind, std::string message, std::optional<Vector3> point,
            double size) {
    check_.findings.push_back({.severity = severity,
                               .kind = kind,
                               .object = mesh_.name,
                               .message = std::move(message),
                               .point = point,
                               .size = size});
  }
  // A finding for a count and the first place where it was counted.
  void findCount(Severity severity, const char* kind, std::int64_t count, const char* sentence,
                 const std::optional<Vector3>& first) {
    if (count > 0)
      find(severity, kind, fmt::format(fmt::runtime(sentence), count), first, double(count));
  }

  void vertices() {
    std::vector<char> used(static_cast<std::size_t>(mesh_.V.rows()), 0);
    for (const std::int32_t v : mesh_.F.reshaped()) used[toIndex(v)] = 1;
    std::optional<Vector3> unused;
    std::optional<Vector3> repeated;
    VertexWelder welder(used.size());
    std::int32_t seen = 0;
    for (Eigen::Index v = 0; v < mesh_.V.rows(); ++v) {
      const Vector3 p = mesh_.V.row(v).transpose();
      if (used[static_cast<std::size_t>(v)] == 0) {
        if (check_.unusedVertices++ == 0 && p.allFinite()) unused = p;
      } else if (!p.allFinite()) {
        if (check_.nonFiniteVertices++ == 0) {
          find(Severity::Error, "non-finite-vertex",
               fmt::format("vertex {} is ({}, {}, {})", v + 1, p.x(), p.y(), p.z()), std::nullopt,
               0.0);
        }
      } else if (welder.add(p.x(), p.y(), p.z()) < seen) {
        if (check_.duplicateVertices++ == 0) repeated = p;
      } else {
        ++seen;
      }
    }
    findCount(Severity::Note, "unused-vertices", check_.unusedVertices,
              "{} vertices belong to no face", unused);
    findCount(Severity::Warning, "duplicate-vertices", check_.duplicateVertices,
              "{} vertices lie exactly upon others: the surface is cut there", repeated);
  }

  void faces() {
    std::optional<Vector3> flat;
    std::optional<Vector3> repeated;
    std::vector<std::array<std::int32_t, 4>> keys;  // three vertices ascending, face
    keys.reserve(static_cast<std::size_t>(mesh_.F.rows()));
    for (Eigen::Index f = 0; f < mesh_.F.rows(); ++f) {
      const auto exact = [&](int k) {
        return Point(mesh_.V(mesh_.F(f, k), 0), mesh_.V(mesh_.F(f, k), 1),
                     mesh_.V(mesh_.F(f, k), 2));
      };
      if (CGAL::collinear(exact(0), exact(1), exact(2)) && check_.degenerateFaces++ == 0)
        flat = middle(f);
      std::array<std::int32_t, 4> key{mesh_.F(f, 0), mesh_.F(f, 1), mesh_.F(f, 2),
                                      static_cast<std::int32_t>(f)};
      std::sort(key.begin(), key.begin() + 3);
      keys.push_back(key);
    }
    std::ranges::sort(keys);
    for (std::size_t i = 1; i < keys.size(); ++i) {
      if (!std::equal(keys[i].begin(), keys[i].begin() + 3, keys[i - 1].begin())) continue;
      if (check_.duplicateFaces++ == 0) repeated = middle(keys[i][3]);
    }
    findCount(Severity::Warning, "degenerate-faces", check_.degenerateFaces,
              "{} faces have no area", flat);
    findCount(Severity::Warning, "duplicate-faces", check_.duplicateFaces,
              "{} faces lie exactly upon others", repeated);
  }

  void edges() {
    std::optional<Vector3> crowded;
    std::optional<Vector3> flipped;
    for (std::size_t e = 0; e < edges_.count(); ++e) {
      const std::int32_t a = edges_.ends[e][0];
      const std::int32_t b = edges_.ends[e][1];
      const Vector3 place = 0.5 * (at(a) + at(b));
      const std::int32_t faces = edges_.faceCount(e);
      if (faces == 1) ++check_.borderEdges;
      if (faces > 2 && check_.nonManifoldEdges++ == 0) crowded = place;
      if (faces != 2) continue;
      const auto runsUp = [&](std::int32_t use) {
        const std::int32_t s = edges_.slot[toIndex(edges_.first[e] + use)];
        return mesh_.F(s / 3, s % 3) == a;
      };
      if (runsUp(0) == runsUp(1) && check_.inconsistentEdges++ == 0) flipped = place;
    }
    findCount(Severity::Warning, "non-manifold-edges", check_.nonManifoldEdges,
              "{} edges have more than two faces", crowded);
    findCount(Severity::Warning, "inconsistent-orientation", check_.inconsistentEdges,
              "across {} edges the neighbouring faces look to opposite sides", flipped);
  }

  void fans() {
    fans_ = vertexFans(mesh_.F, edges_);
    check_.nonManifoldVertices = static_cast<std::int64_t>(fans_.nonManifoldVertices.size());
    std::optional<Vector3> first;
    if (!fans_.nonManifoldVertices.empty()) first = at(fans_.nonManifoldVertices.front());
    findCount(Severity::Warning, "non-manifold-vertices", check_.nonManifoldVertices,
              "{} vertices join pieces that hang together nowhere else around them", first);
  }

  void holes() {
    for (const Border& border : borders(edges_)) {
      SurfaceCheck::Hole hole;
      Box box;
      for (const std::int32_t e : border.edges) {
        const auto [a, b] = edges_.ends[toIndex(e)];
        box.add(at(a));
        box.add(at(b));
        hole.perimeter += (at(a) - at(b)).norm();
      }
      hole.place = box.centre();
      hole.extent = box.diagonal();
      hole.edges = static_cast<std::int64_t>(border.edges.size());
      const std::int32_t slot = edges_.slot[toIndex(edges_.first[toIndex(border.edges.front())])];
      hole.piece = labels_.label[toIndex(slot / 3)];
      hole.box = box;
      check_.holes.push_back(hole);
    }
    std::ranges::stable_sort(check_.holes, std::greater{}, &SurfaceCheck::Hole::extent);
    const std::vector<char> sheet = check_.holes.empty()
                                        ? std::vector<char>(toIndex(labels_.count), 0)
                                        : openSheets(mesh_.V, mesh_.F, edges_, labels_);
    tellSheets(sheet);
    std::vector<SurfaceCheck::Hole> told;
    std::ranges::copy_if(check_.holes, std::back_inserter(told),
                         [&](const auto& hole) { return sheet[toIndex(hole.piece)] == 0; });
    // The largest one by one; a mesh whose faces all stand alone has thousands of others
    for (std::size_t h = 0; h < std::min(kToldApart, told.size()); ++h) {
      const auto& hole = told[h];
      if (faceCount_[toIndex(hole.piece)] == 1) {
        find(Severity::Warning, "lone-face",
             fmt::format("a triangle hangs together with nothing, {:.3g} m across", hole.extent),
             hole.place, hole.extent);
      } else {
        find(Severity::Warning, "hole",
             fmt::format("a border of {} edges, {:.3g} m across", hole.edges, hole.extent),
             hole.place, hole.extent);
      }
    }
    if (told.size() > kToldApart) {
      const auto& next = told[kToldApart];
      find(Severity::Warning, "hole",
           fmt::format("{} more borders, none more than {:.3g} m across", told.size() - kToldApart,
                       next.extent),
           next.place, next.extent);
    }
  }

  void tellSheets(const std::vector<char>& sheet) {
    std::vector<char> partIs(mesh_.parts.size(), 0);
    std::vector<Box> boxes(sheet.size());
    for (std::size_t p = 0; p < mesh_.parts.size(); ++p) {
      const Part& part = mesh_.parts[p];
      const auto first = labels_.label.begin() + part.firstFace;
      partIs[p] = std::any_of(first, first + part.faceCount,
                              [&](std::int32_t piece) { return sheet[toIndex(piece)] != 0; });
    }
    for (const auto& hole : check_.holes) {
      if (sheet[toIndex(hole.piece)] != 0) boxes[toIndex(hole.piece)].add(hole.box);
    }
    std::int64_t count = 0;
    const Box* widest = nullptr;
    for (const Box& box : boxes) {
      if (box.empty()) continue;
      ++count;
      if (widest == nullptr || box.diagonal() > widest->diagonal()) widest = &box;
    }
    if (count == 0) return;
    const std::string names = partsNamed(mesh_, partIs);
    find(Severity::Warning, "sheet",
         fmt::format("{} open sheets that enclose nothing, up to {:.3g} m across{}{}", count,
                     widest->diagonal(), names.empty() ? "" : ": ", names),
         widest->centre(), widest->diagonal());
  }

  void pieces() {
    auto& list = check_.components;
    list.resize(toIndex(labels_.count));
    for (auto& c : list) {
      c.firstFace = -1;
      c.closed = true;
    }
    const Vector3 origin = boundingBox(mesh_).centre();
    for (Eigen::Index f = 0; f < mesh_.F.rows(); ++f) {
      auto& c = list[toIndex(labels_.label[static_cast<std::size_t>(f)])];
      if (c.firstFace < 0) c.firstFace = static_cast<std::int32_t>(f);
      ++c.faces;
      const Vector3 p = at(mesh_.F(f, 0)) - origin;
      const Vector3 q = at(mesh_.F(f, 1)) - origin;
      const Vector3 r = at(mesh_.F(f, 2)) - origin;
      for (const Vector3& x : {p, q, r}) c.box.add(x + origin);
      c.area += 0.5 * (q - p).cross(r - p).norm();
      c.volume += p.dot(q.cross(r)) / 6.0;
    }

    // Closed: as many faces run up every edge as run down. Manifold: then exactly one of each.
    std::vector<std::int64_t> edgeCount(list.size(), 0);
    std::vector<char> manifold(list.size(), 1);
    for (std::size_t e = 0; e < edges_.count(); ++e) {
      const auto piece = toIndex(labels_.label[toIndex(edges_.slot[toIndex(edges_.first[e])] / 3)]);
      ++edgeCount[piece];
      if (edges_.faceCount(e) != 2) manifold[piece] = 0;
      std::int32_t balance = 0;
      for (std::int32_t u = edges_.first[e]; u < edges_.first[e + 1]; ++u) {
        const std::int32_t s = edges_.slot[toIndex(u)];
        balance += mesh_.F(s / 3, s % 3) == edges_.ends[e][0] ? 1 : -1;
      }
      if (balance != 0) list[piece].closed = false;
    }
    // Fans stand for vertices, so that pieces which touch in a vertex count it once each
    std::vector<std::int64_t> fanCount(list.size(), 0);
    std::vector<char> fanSeen(toIndex(fans_.count), 0);
    for (std::size_t c = 0; c < fans_.fanOfCorner.size(); ++c) {
      char& seen = fanSeen[toIndex(fans_.fanOfCorner[c])];
      if (seen == 0) ++fanCount[toIndex(labels_.label[c / 3])];
      seen = 1;
    }
    for (std::size_t i = 0; i < list.size(); ++i) {
      auto& c = list[i];
      if (edgeCount[i] == 0) c.closed = false;
      c.inward = c.closed && c.volume < 0;
      const std::int64_t euler = fanCount[i] - edgeCount[i] + c.faces;
      if (c.closed && manifold[i] != 0 && euler % 2 == 0)
        c.genus = static_cast<int>((2 - euler) / 2);
    }
    tellInward();
    if (list.size() > 1) {
      find(Severity::Note, "components", fmt::format("the surface is in {} pieces", list.size()),
           std::nullopt, double(list.size()));
    }
  }

  void tellInward() {
    std::vector<const SurfaceCheck::Component*> inward;
    for (const auto& c : check_.components) {
      if (c.inward) inward.push_back(&c);
    }
    std::ranges::stable_sort(inward, {}, [](const auto* c) { return c->volume; });
    for (std::size_t i = 0; i < std::min(kToldApart, inward.size()); ++i) {
      const auto& c = *inward[i];
      find(Severity::Warning, "inward",
           fmt::format("a closed piece of {} faces and {:.3g} m³ faces inward", c.faces, -c.volume),
           c.box.centre(), -c.volume);
    }
    if (inward.size() <= kToldApart) return;
    const auto& next = *inward[kToldApart];
    find(Severity::Warning, "inward",
         fmt::format("{} more closed pieces face inward, none with more than {:.3g} m³",
                     inward.size() - kToldApart, -next.volume),
         next.box.centre(), -next.volume);
  }

  void crossings() {
    const auto pairs = selfIntersections(mesh_.V, mesh_.F);
    check_.selfIntersections = static_cast<std::int64_t>(pairs.size());
    std::optional<Vector3> first;
    if (!pairs.empty()) first = middle(pairs.front().first);
    findCount(Severity::Warning, "self-intersections", *check_.selfIntersections,
              "{} pairs of faces cut each other", first);
  }

  const SurfaceMesh& mesh_;
  SurfaceEdges edges_;
  FaceComponents labels_;
  std::vector<std::int64_t> faceCount_;  // of pieces
  VertexFans fans_;
  SurfaceCheck check_;
};

}  // namespace

bool SurfaceCheck::isSound() const {
  return !components.empty() && nonFiniteVertices == 0 && degenerateFaces == 0 &&
         duplicateFaces == 0 && borderEdges == 0 && nonManifoldEdges == 0 &&
         nonManifoldVertices == 0 && inconsistentEdges == 0;
}

SurfaceCheck checkSurface(const SurfaceMesh& mesh, const SurfaceCheckOptions& options) {
  return Checker(mesh).run(options);
}

bool isUncrossed(const SurfaceMesh& mesh) {
  const SurfaceCheck check = checkSurface(mesh, {.selfIntersections = true});
  return check.isSound() && check.selfIntersections.value_or(1) == 0;
}

}  // namespace ecorche::mesh
