#include <CGAL/Polygon_mesh_processing/corefinement.h>
#include <ecorche/mesh/cgal_surface.h>
#include <ecorche/mesh/outer_hull.h>
#include <ecorche/mesh/piece_union.h>
#include <ecorche/mesh/self_intersection.h>
#include <ecorche/mesh/surface_check.h>
#include <ecorche/mesh/surface_topology.h>

#include <algorithm>
#include <span>
#include <vector>

namespace ecorche::mesh {

namespace {

/// Each with vertices of its own, in the order in which its faces name them.
std::vector<SurfaceMesh> piecesOf(const SurfaceMesh& mesh) {
  const FaceComponents all = components(mesh.F);
  std::vector<std::vector<Eigen::Index>> faces(static_cast<std::size_t>(all.count));
  for (Eigen::Index f = 0; f < mesh.F.rows(); ++f)
    faces[static_cast<std::size_t>(all.label[static_cast<std::size_t>(f)])].push_back(f);
  std::vector<SurfaceMesh> out;
  std::vector<std::int32_t> number(static_cast<std::size_t>(mesh.V.rows()), -1);
  for (const auto& own : faces) {
    SurfaceMesh piece;
    piece.F = mesh.F(own, Eigen::all);
    std::vector<std::int32_t> used;
    for (auto& v : piece.F.reshaped()) {
      std::int32_t& fresh = number[static_cast<std::size_t>(v)];
      if (fresh < 0) {
        fresh = static_cast<std::int32_t>(used.size());
        used.push_back(v);
      }
      v = fresh;
    }
    piece.V = mesh.V(used, Eigen::all);
    // Pieces that touch in a vertex share it
    for (const std::int32_t v : used) number[static_cast<std::size_t>(v)] = -1;
    out.push_back(std::move(piece));
  }
  return out;
}

/// a and b together, or nothing where the result would touch itself.
std::optional<CgalSurface> united(CgalSurface a, CgalSurface b) {
  namespace PMP = CGAL::Polygon_mesh_processing;
  CgalSurface out;
  try {
    if (!PMP::corefine_and_compute_union(a, b, out,
                                         CGAL::parameters::throw_on_self_intersection(true)))
      return std::nullopt;
  } catch (const std::exception&) {
    return std::nullopt;
  }
  return out;
}

/// Halves along the longest side of their box, so that most unions are small.
std::optional<CgalSurface> unionOf(std::span<SurfaceMesh> pieces, RunContext& run) {
  if (run.cancelled()) return std::nullopt;
  if (pieces.size() == 1) return toCgal(pieces.front());
  Box box;
  for (const SurfaceMesh& piece : pieces) box.add(boundingBox(piece).centre());
  int axis = 0;
  (box.hi - box.lo).maxCoeff(&axis);
  const std::size_t half = pieces.size() / 2;
  std::ranges::nth_element(pieces, pieces.begin() + static_cast<std::ptrdiff_t>(half), {},
                           [&](const SurfaceMesh& m) { return boundingBox(m).centre()[axis]; });
  auto left = unionOf(pieces.first(half), run);
  if (!left) return std::nullopt;
  auto right = unionOf(pieces.subspan(half), run);
  if (!right) return std::nullopt;
  return united(std::move(*left), std::move(*right));
}

}  // namespace

std::optional<SurfaceMesh> pieceUnion(const SurfaceMesh& mesh, RunContext& run) {
  std::vector<SurfaceMesh> pieces = piecesOf(mesh);
  if (pieces.size() < 2) return std::nullopt;
  for (SurfaceMesh& piece : pieces) {
    if (run.cancelled()) return std::nullopt;
    if (signedVolume(piece.V, piece.F) <= 0.0) return std::nullopt;
    if (selfIntersections(piece.V, piece.F).empty()) continue;
    auto hull = outerHull(piece, run);
    if (!hull) return std::nullopt;
    piece = std::move(*hull);
  }
  auto sum = unionOf(pieces, run);
  if (!sum) return std::nullopt;
  SurfaceMesh out = fromCgal(*sum, mesh.name);
  if (!isUncrossed(out)) return std::nullopt;
  return out;
}

}  // namespace ecorche::mesh
