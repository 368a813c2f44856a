#include <ecorche/mesh/disjoint_sets.h>
#include <ecorche/mesh/inner_walls.h>
#include <ecorche/mesh/surface_query.h>
#include <ecorche/mesh/surface_topology.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <vector>

namespace ecorche::mesh {

namespace {

std::size_t index(std::int64_t i) { return static_cast<std::size_t>(i); }

/// As many faces run up every edge as down: the surface winds around every point a whole number of
/// times.
bool isBalanced(const Triangles& F, const SurfaceEdges& edges) {
  for (std::size_t e = 0; e < edges.count(); ++e) {
    int balance = 0;
    for (std::int32_t u = edges.first[e]; u < edges.first[e + 1]; ++u) {
      const std::int32_t s = edges.slot[index(u)];
      balance += F(s / 3, s % 3) == edges.ends[e][0] ? 1 : -1;
    }
    if (balance != 0) return false;
  }
  return true;
}

struct Patch {
  std::vector<std::int32_t> faces;
  std::int64_t openEdges = 0;
  std::int64_t crowdedEdges = 0;
};

/// Faces that hang together by edges of two faces.
std::vector<Patch> patchesOf(const Triangles& F, const SurfaceEdges& edges) {
  DisjointSets sets(index(F.rows()));
  const auto face = [&](std::int32_t use) { return edges.slot[index(use)] / 3; };
  for (std::size_t e = 0; e < edges.count(); ++e) {
    if (edges.faceCount(e) == 2) sets.unite(face(edges.first[e]), face(edges.first[e] + 1));
  }
  std::vector<std::int32_t> label;
  std::vector<Patch> patches(index(sets.label(label)));
  for (std::size_t f = 0; f < label.size(); ++f)
    patches[index(label[f])].faces.push_back(static_cast<std::int32_t>(f));
  for (std::size_t e = 0; e < edges.count(); ++e) {
    for (std::int32_t u = edges.first[e]; u < edges.first[e + 1]; ++u) {
      Patch& patch = patches[index(label[index(face(u))])];
      patch.openEdges += edges.faceCount(e) == 1;
      patch.crowdedEdges += edges.faceCount(e) > 2;
    }
  }
  return patches;
}

/// Is what is left without the patch closed, with both sides of the patch inside?
bool isWall(const LabelledFaces& faces, const Patch& patch) {
  LabelledFaces rest = faces;
  std::vector<char> kept(faces.label.size(), 1);
  for (const std::int32_t f : patch.faces) kept[index(f)] = 0;
  rest.keep(kept);
  if (rest.F.rows() == 0 || !isBalanced(rest.F, surfaceEdges(rest.F))) return false;
  const SurfaceQuery query(rest.V, rest.F);
  const double step = 1e-6 * boundingBox(rest.V).diagonal();
  // The largest face is the farthest from the rim
  Vector3 place = Vector3::Zero();
  Vector3 normal = Vector3::Zero();
  for (const std::int32_t f : patch.faces) {
    const Vector3 a = faces.V.row(faces.F(f, 0)).transpose();
    const Vector3 b = faces.V.row(faces.F(f, 1)).transpose();
    const Vector3 c = faces.V.row(faces.F(f, 2)).transpose();
    const Vector3 n = (b - a).cross(c - a);
    if (n.norm() <= normal.norm()) continue;
    normal = n;
    place = (a + b + c) / 3.0;
  }
  if (!(normal.norm() > 0.0)) return false;
  const Vector3 aside = step * normal.normalized();
  return query.windingNumber(place + aside).value_or(0) != 0 &&
         query.windingNumber(place - aside).value_or(0) != 0;
}

}  // namespace

StepReport dropInnerWalls(LabelledFaces& faces) {
  constexpr std::size_t kMost = 64;  // patches looked at; more is no wall but a tangle
  StepReport report;
  for (bool found = true; found;) {
    found = false;
    const SurfaceEdges edges = surfaceEdges(faces.F);
    auto patches = patchesOf(faces.F, edges);
    std::erase_if(patches, [](const Patch& p) { return p.openEdges > 0 || p.crowdedEdges == 0; });
    if (patches.size() > kMost) return report;
    for (const Patch& patch : patches) {
      if (!isWall(faces, patch)) continue;
      Box box;
      std::vector<char> kept(faces.label.size(), 1);
      for (const std::int32_t f : patch.faces) {
        kept[index(f)] = 0;
        for (int k = 0; k < 3; ++k) box.add(faces.V.row(faces.F(f, k)).transpose());
      }
      faces.keep(kept);
      report.see(box.centre(), box.diagonal());
      found = true;
      break;  // rims have changed
    }
  }
  return report;
}

}  // namespace ecorche::mesh
