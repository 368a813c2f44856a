#include <ecorche/core/index.h>
#include <ecorche/mesh/disjoint_sets.h>
#include <ecorche/mesh/face_repair.h>
#include <ecorche/mesh/nesting.h>
#include <ecorche/mesh/self_intersection.h>
#include <ecorche/mesh/surface_check.h>
#include <ecorche/mesh/surface_query.h>
#include <ecorche/mesh/surface_topology.h>
#include <ecorche/mesh/weld.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <unordered_map>
#include <unordered_set>

namespace ecorche::mesh {

namespace {

Vector3 at(const LabelledFaces& faces, std::int32_t v) { return faces.V.row(v).transpose(); }

Vector3 middle(const LabelledFaces& faces, Eigen::Index f) {
  return (at(faces, faces.F(f, 0)) + at(faces, faces.F(f, 1)) + at(faces, faces.F(f, 2))) / 3.0;
}

void renumber(LabelledFaces& faces, const std::vector<std::int32_t>& fresh) {
  faces.F = faces.F.unaryExpr([&](std::int32_t v) { return fresh[toIndex(v)]; }).eval();
}

// Cells of a grid; what is closer than a cell's width is in neighbouring cells.
using Cell = std::array<std::int64_t, 3>;
struct CellHash {
  std::size_t operator()(const Cell& c) const {
    return static_cast<std::size_t>(c[0] * 73856093 ^ c[1] * 19349663 ^ c[2] * 83492791);
  }
};

// Drops patches of faces that may be walls where both their sides lie inside what is left without
// all of them.
std::int64_t dropWalls(LabelledFaces& faces, const std::vector<char>& mayBeWall,
                       DisjointSets& patches) {
  if (std::ranges::find(mayBeWall, 1) == mayBeWall.end()) return 0;
  LabelledFaces rest = faces;
  std::vector<char> others(mayBeWall.size());
  std::ranges::transform(mayBeWall, others.begin(), [](char w) { return w == 0 ? 1 : 0; });
  rest.keep(others);
  if (!isClosed(rest.F)) return 0;

  const SurfaceQuery query(rest.V, rest.F);
  const double step = 1e-6 * boundingBox(rest.V).diagonal();
  std::vector<char> inside(mayBeWall.size(), 0);  // by patch: 1 yes, 2 no
  std::vector<char> stays(mayBeWall.size(), 1);
  std::int64_t dropped = 0;
  for (std::size_t f = 0; f < mayBeWall.size(); ++f) {
    if (mayBeWall[f] == 0) continue;
    char& known = inside[toIndex(patches.root(static_cast<std::int32_t>(f)))];
    if (known == 0) {
      const auto row = static_cast<Eigen::Index>(f);
      const Vector3 a = at(faces, faces.F(row, 0));
      const Vector3 normal = (at(faces, faces.F(row, 1)) - a).cross(at(faces, faces.F(row, 2)) - a);
      const Vector3 aside =
          normal.norm() > 0 ? Vector3(step * normal.normalized()) : Vector3::Zero();
      const Vector3 p = middle(faces, row);
      const auto solid = [&](const Vector3& q) { return query.windingNumber(q).value_or(0) != 0; };
      known = solid(p + aside) && solid(p - aside) ? 1 : 2;
    }
    if (known == 2) continue;
    stays[f] = 0;
    ++dropped;
  }
  faces.keep(stays);
  return dropped;
}

}  // namespace

void LabelledFaces::keep(const std::vector<char>& kept) {
  Eigen::Index next = 0;
  for (Eigen::Index f = 0; f < F.rows(); ++f) {
    if (kept[toIndex(f)] == 0) continue;
    F.row(next) = F.row(f).eval();
    label[toIndex(next++)] = label[toIndex(f)];
  }
  F.conservativeResize(next, 3);
  label.resize(toIndex(next));
}

StepReport weldEqual(LabelledFaces& faces) {
  StepReport report;
  std::vector<char> used(toIndex(faces.V.rows()), 0);
  for (const std::int32_t v : faces.F.reshaped()) used[toIndex(v)] = 1;
  VertexWelder welder(used.size());
  std::vector<std::int32_t> fresh(used.size(), 0);
  for (std::size_t v = 0; v < used.size(); ++v) {
    if (used[v] == 0) continue;
    const auto row = static_cast<Eigen::Index>(v);
    const std::int32_t before = welder.count();
    fresh[v] = welder.add(faces.V(row, 0), faces.V(row, 1), faces.V(row, 2));
    if (welder.count() == before) report.see(faces.V.row(row).transpose());
  }
  renumber(faces, fresh);
  faces.V = welder.positions();
  return report;
}

StepReport weldBorders(LabelledFaces& faces, double tolerance) {
  StepReport report;
  if (!(tolerance > 0.0)) return report;
  const SurfaceEdges edges = surfaceEdges(faces.F);
  std::map<std::int32_t, double> reach;  // border vertices, and how far each may be moved
  for (std::size_t e = 0; e < edges.count(); ++e) {
    if (edges.faceCount(e) != 1) continue;
    const auto [a, b] = edges.ends[e];
    const double length = (at(faces, a) - at(faces, b)).norm();
    for (const std::int32_t v : {a, b}) {
      double& r = reach.try_emplace(v, tolerance).first->second;
      r = std::min(r, 0.25 * length);
    }
  }

  // Of two the one with less reach decides. Those with much come first, and cells shrink with the
  // reach: a vertex far away, which makes the tolerance large, does not put all others into one.
  std::vector<std::pair<double, std::int32_t>> byReach;
  for (const auto& [v, r] : reach) {
    if (r > 0.0) byReach.emplace_back(r, v);
  }
  std::ranges::sort(byReach, [](const auto& x, const auto& y) {
    return x.first != y.first ? x.first > y.first : x.second < y.second;
  });
  std::unordered_map<Cell, std::vector<std::int32_t>, CellHash> grid;
  double width = tolerance;
  const double narrowest = 1e-12 * tolerance;  // cells are counted in 64 bits
  const Vector3 origin = reach.empty() ? Vector3::Zero() : at(faces, reach.begin()->first);
  const auto cellOf = [&](const Vector3& p) {
    Cell c;
    for (int k = 0; k < 3; ++k)
      c[toIndex(k)] = static_cast<std::int64_t>(std::floor((p[k] - origin[k]) / width));
    return c;
  };
  DisjointSets sets(toIndex(faces.V.rows()));
  for (std::size_t i = 0; i < byReach.size(); ++i) {
    const auto [r, v] = byReach[i];
    if (r < 0.25 * width && width > narrowest) {
      width = std::max(r, narrowest);
      grid.clear();
      for (std::size_t j = 0; j < i; ++j)
        grid[cellOf(at(faces, byReach[j].second))].push_back(byReach[j].second);
    }
    const Vector3 p = at(faces, v);
    const Cell home = cellOf(p);
    for (int n = 0; n < 27; ++n) {
      const auto near =
          grid.find({home[0] + n % 3 - 1, home[1] + n / 3 % 3 - 1, home[2] + n / 9 - 1});
      if (near == grid.end()) continue;
      for (const std::int32_t w : near->second) {
        const double gap = (at(faces, w) - p).norm();
        if (gap > r || sets.root(v) == sets.root(w)) continue;
        sets.unite(v, w);
        report.see(p, gap);
      }
    }
    grid[home].push_back(v);
  }
  if (report.count == 0) return report;
  std::vector<std::int32_t> fresh(toIndex(faces.V.rows()));
  for (std::size_t v = 0; v < fresh.size(); ++v) fresh[v] = sets.root(static_cast<std::int32_t>(v));
  renumber(faces, fresh);
  return report;
}

StepReport dropCollapsed(LabelledFaces& faces) {
  StepReport report;
  std::vector<char> kept(toIndex(faces.F.rows()), 1);
  for (Eigen::Index f = 0; f < faces.F.rows(); ++f) {
    if (faces.F(f, 0) != faces.F(f, 1) && faces.F(f, 1) != faces.F(f, 2) &&
        faces.F(f, 2) != faces.F(f, 0))
      continue;
    kept[toIndex(f)] = 0;
    report.see(middle(faces, f));
  }
  if (report.count > 0) faces.keep(kept);
  return report;
}

StepReport dropDoubled(LabelledFaces& faces) {
  StepReport report;
  std::vector<std::array<std::int32_t, 4>> keys;  // three vertices ascending, face
  keys.reserve(toIndex(faces.F.rows()));
  for (Eigen::Index f = 0; f < faces.F.rows(); ++f) {
    std::array<std::int32_t, 4> key{faces.F(f, 0), faces.F(f, 1), faces.F(f, 2),
                                    static_cast<std::int32_t>(f)};
    std::sort(key.begin(), key.begin() + 3);
    keys.push_back(key);
  }
  std::ranges::sort(keys);
  std::vector<char> kept(keys.size(), 1);
  std::vector<char> wasDoubled(keys.size(), 0);
  std::size_t first = 0;
  for (std::size_t i = 1; i < keys.size(); ++i) {
    if (!std::equal(keys[i].begin(), keys[i].begin() + 3, keys[first].begin())) {
      first = i;
      continue;
    }
    kept[toIndex(keys[i][3])] = 0;
    wasDoubled[toIndex(keys[first][3])] = 1;
    report.see(middle(faces, keys[i][3]));
  }
  if (report.count == 0) return report;
  std::vector<char> doubled;
  for (std::size_t f = 0; f < kept.size(); ++f) {
    if (kept[f] != 0) doubled.push_back(wasDoubled[f]);
  }
  faces.keep(kept);

  // Patches of doubled faces, and whether they end at edges of three faces or more everywhere
  const SurfaceEdges edges = surfaceEdges(faces.F);
  DisjointSets patches(doubled.size());
  const auto faceAt = [&](std::int32_t use) { return edges.slot[toIndex(use)] / 3; };
  for (std::size_t e = 0; e < edges.count(); ++e) {
    const std::int32_t u = edges.first[e];
    if (edges.faceCount(e) == 2 && doubled[toIndex(faceAt(u))] && doubled[toIndex(faceAt(u + 1))]) {
      patches.unite(faceAt(u), faceAt(u + 1));
    }
  }
  std::vector<std::int64_t> borderEdges(doubled.size(), 0);
  std::vector<std::int64_t> wallEdges(doubled.size(), 0);
  for (std::size_t e = 0; e < edges.count(); ++e) {
    for (std::int32_t u = edges.first[e]; u < edges.first[e + 1]; ++u) {
      const std::int32_t f = faceAt(u);
      if (doubled[toIndex(f)] == 0) continue;
      const bool inPatch = edges.faceCount(e) == 2 &&
                           doubled[toIndex(faceAt(edges.first[e]))] != 0 &&
                           doubled[toIndex(faceAt(edges.first[e] + 1))] != 0;
      if (inPatch) continue;
      ++borderEdges[toIndex(patches.root(f))];
      if (edges.faceCount(e) >= 3) ++wallEdges[toIndex(patches.root(f))];
    }
  }
  std::vector<char> wall(doubled.size(), 0);
  for (std::size_t f = 0; f < doubled.size(); ++f) {
    const std::size_t patch = toIndex(patches.root(static_cast<std::int32_t>(f)));
    wall[f] = doubled[f] != 0 && borderEdges[patch] > 0 && wallEdges[patch] == borderEdges[patch];
  }
  report.count += dropWalls(faces, wall, patches);
  return report;
}

StepReport dropSpecks(LabelledFaces& faces, double extent) {
  StepReport report;
  const FaceComponents pieces = components(faces.F);
  if (!(extent > 0.0) || pieces.count < 2) return report;
  struct Piece {
    Box box;
    double area = 0.0;
    bool open = false;
  };
  std::vector<Piece> list(toIndex(pieces.count));
  double area = 0.0;
  for (Eigen::Index f = 0; f < faces.F.rows(); ++f) {
    Piece& piece = list[toIndex(pieces.label[toIndex(f)])];
    const Vector3 a = at(faces, faces.F(f, 0));
    const Vector3 b = at(faces, faces.F(f, 1));
    const Vector3 c = at(faces, faces.F(f, 2));
    for (const Vector3& p : {a, b, c}) piece.box.add(p);
    const double own = 0.5 * (b - a).cross(c - a).norm();
    piece.area += own;
    area += own;
  }
  const SurfaceEdges edges = surfaceEdges(faces.F);
  for (std::size_t e = 0; e < edges.count(); ++e) {
    if (edges.faceCount(e) == 1)
      list[toIndex(pieces.label[toIndex(edges.slot[toIndex(edges.first[e])] / 3)])].open = true;
  }
  const auto largest =
      std::ranges::max_element(list, {}, [](const Piece& p) { return p.box.diagonal(); });
  std::vector<char> stays(list.size(), 1);
  for (std::size_t p = 0; p < list.size(); ++p) {
    const bool speck =
        list[p].box.diagonal() < extent || (list[p].open && list[p].area < 1e-4 * area);
    if (!speck || p == static_cast<std::size_t>(largest - list.begin())) continue;
    stays[p] = 0;
    report.see(list[p].box.centre(), list[p].box.diagonal());
  }
  if (report.count == 0) return report;
  std::vector<char> kept(toIndex(faces.F.rows()));
  for (std::size_t f = 0; f < kept.size(); ++f) kept[f] = stays[toIndex(pieces.label[f])];
  faces.keep(kept);
  return report;
}

std::vector<char> crumbs(const Positions& V, const Triangles& F, const FaceComponents& pieces,
                         const std::vector<SurfaceCheck::Component>& check) {
  constexpr double kShort = 0.04;  // of the extent
  const double most = kCrumbShare * std::abs(signedVolume(V, F));
  std::vector<char> goes(check.size(), 0);
  std::vector<char> large(check.size(), 0);
  for (std::size_t p = 0; p < check.size(); ++p) {
    goes[p] = check[p].closed && std::abs(check[p].volume) < most;
    large[p] = check[p].closed && goes[p] == 0;
  }
  if (check.size() < 2 || std::ranges::find(goes, 1) == goes.end())
    return std::vector<char>(check.size(), 0);
  Box all;
  for (const SurfaceCheck::Component& piece : check) all.add(piece.box);
  const auto heldBy = holders(V, F, pieces, large, goes);
  for (std::size_t p = 0; p < check.size(); ++p) {
    if (!heldBy[p].empty() && check[p].box.diagonal() > kShort * all.diagonal()) goes[p] = 0;
  }
  // What hangs together by touching stays or goes together
  DisjointSets clusters(check.size());
  for (const auto& [f, g] : selfIntersections(V, F))
    clusters.unite(pieces.label[toIndex(f)], pieces.label[toIndex(g)]);
  std::vector<char> stays(check.size(), 0);
  const auto cluster = [&](std::size_t p) {
    return toIndex(clusters.root(static_cast<std::int32_t>(p)));
  };
  for (std::size_t p = 0; p < check.size(); ++p) {
    if (goes[p] == 0) stays[cluster(p)] = 1;
  }
  for (std::size_t p = 0; p < check.size(); ++p) goes[p] = stays[cluster(p)] == 0;
  return goes;
}

StepReport dropCrumbs(LabelledFaces& faces) {
  StepReport report;
  const auto check = checkSurface({.V = faces.V, .F = faces.F}).components;
  const FaceComponents pieces = components(faces.F);
  const std::vector<char> goes = crumbs(faces.V, faces.F, pieces, check);
  for (std::size_t p = 0; p < check.size(); ++p) {
    if (goes[p] != 0) report.see(check[p].box.centre(), check[p].box.diagonal());
  }
  if (report.count == 0) return report;
  std::vector<char> kept(toIndex(faces.F.rows()));
  for (std::size_t f = 0; f < kept.size(); ++f) kept[f] = goes[toIndex(pieces.label[f])] == 0;
  faces.keep(kept);
  return report;
}

StepReport orientOutward(LabelledFaces& faces) {
  StepReport report;
  const FaceComponents pieces = components(faces.F);
  const auto check = checkSurface({.V = faces.V, .F = faces.F}).components;
  std::vector<char> turned(check.size(), 0);
  std::vector<char> closed(check.size(), 0);
  for (std::size_t p = 0; p < check.size(); ++p) {
    closed[p] = check[p].closed;
    turned[p] = check[p].closed && check[p].inward;
  }

  // Closed pieces that lie inside others go the way of the outermost
  if (std::ranges::any_of(check, &SurfaceCheck::Component::inward)) {
    const auto heldBy = holders(faces.V, faces.F, pieces, closed, closed);
    const auto size = [&](std::size_t p) { return check[p].box.diagonal(); };
    std::vector<std::size_t> bySize(check.size());
    std::iota(bySize.begin(), bySize.end(), std::size_t{0});
    std::ranges::stable_sort(bySize, std::greater{}, size);
    std::vector<char> nested(check.size(), 0);
    for (const std::size_t inner : bySize) {
      std::optional<std::size_t> outer;
      for (const std::int32_t holder : heldBy[inner]) {
        const std::size_t h = toIndex(holder);
        if (nested[h] == 0 && size(h) > size(inner) && (!outer || size(h) > size(*outer)))
          outer = h;
      }
      if (!outer) continue;
      nested[inner] = 1;
      turned[inner] = turned[*outer];
    }
  }
  const auto own = facesByPiece(pieces);
  for (std::size_t p = 0; p < check.size(); ++p) {
    if (!check[p].closed) {
      const Vector3 centre = check[p].box.centre();
      double volume = 0.0;
      for (const Eigen::Index f : own[p]) {
        const auto [a, b, c] = std::array{Vector3(at(faces, faces.F(f, 0)) - centre),
                                          Vector3(at(faces, faces.F(f, 1)) - centre),
                                          Vector3(at(faces, faces.F(f, 2)) - centre)};
        volume += a.dot(b.cross(c)) / 6.0;
      }
      turned[p] = volume < -0.02 * std::pow(check[p].area, 1.5);
    }
    if (turned[p] != 0) report.see(check[p].box.centre(), std::abs(check[p].volume));
  }
  for (Eigen::Index f = 0; f < faces.F.rows(); ++f) {
    if (turned[toIndex(pieces.label[toIndex(f)])] != 0) std::swap(faces.F(f, 1), faces.F(f, 2));
  }
  return report;
}

}  // namespace ecorche::mesh
