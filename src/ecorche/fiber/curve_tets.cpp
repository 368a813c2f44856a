#include <ecorche/fiber/curve_tets.h>
#include <ecorche/mesh/surface_mesh.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>

namespace ecorche::fiber {

using mesh::Vector3;

namespace {

// The part [lo, hi] of the segment a + s·(b − a), s in [0, 1], inside the tet; empty where lo >=
// hi.
std::array<double, 2> clipToTet(const std::array<Vector3, 4>& p, const Vector3& a,
                                const Vector3& b) {
  double lo = 0.0;
  double hi = 1.0;
  for (const auto& face : mesh::kTetFace) {
    const Vector3& o = p[static_cast<std::size_t>(face[0])];
    const Vector3 outward =
        (p[static_cast<std::size_t>(face[1])] - o).cross(p[static_cast<std::size_t>(face[2])] - o);
    const double from = outward.dot(a - o);
    const double slope = outward.dot(b - a);
    if (slope > 0.0) {
      hi = std::min(hi, -from / slope);
    } else if (slope < 0.0) {
      lo = std::max(lo, -from / slope);
    } else if (from > 0.0) {
      return {1.0, 0.0};
    }
    if (lo >= hi) break;
  }
  return {lo, hi};
}

// Calls visit(tet, segment, lo, hi) for every tet and every piece of the line inside, tets
// ascending.
template <class Visit>
void forEachPiece(const mesh::TetMesh& mesh, const std::vector<std::int32_t>& tets,
                  const std::vector<Vector3>& line, const Visit& visit) {
  std::vector<mesh::Box> boxes;
  mesh::Box whole;
  for (std::size_t k = 0; k + 1 < line.size(); ++k) {
    mesh::Box box;
    box.add(line[k]);
    box.add(line[k + 1]);
    whole.add(box);
    boxes.push_back(box);
  }
  const auto apart = [](const mesh::Box& a, const mesh::Box& b) {
    return (a.lo.array() > b.hi.array()).any() || (b.lo.array() > a.hi.array()).any();
  };
  for (const std::int32_t t : tets) {
    std::array<Vector3, 4> p;
    mesh::Box box;
    for (int k = 0; k < 4; ++k) {
      p[static_cast<std::size_t>(k)] = mesh.V.row(mesh.T(t, k)).transpose();
      box.add(p[static_cast<std::size_t>(k)]);
    }
    if (apart(box, whole)) continue;
    for (std::size_t k = 0; k + 1 < line.size(); ++k) {
      if (apart(box, boxes[k])) continue;
      const auto [lo, hi] = clipToTet(p, line[k], line[k + 1]);
      if (lo < hi) visit(t, k, lo, hi);
    }
  }
}

}  // namespace

std::vector<TetOnCurve> tetsOnCurve(const mesh::TetMesh& mesh,
                                    const std::vector<std::int32_t>& tets,
                                    const std::vector<Vector3>& line) {
  // The tangent gathers the pieces' vectors until all are known
  std::vector<TetOnCurve> out;
  forEachPiece(mesh, tets, line, [&](std::int32_t t, std::size_t k, double lo, double hi) {
    if (out.empty() || out.back().tet != t) out.push_back({t, 0.0, Vector3::Zero()});
    const Vector3 inside = (hi - lo) * (line[k + 1] - line[k]);
    out.back().length += inside.norm();
    out.back().tangent += inside;
  });
  std::erase_if(out, [](const TetOnCurve& hit) { return !(hit.tangent.norm() > 0.0); });
  for (TetOnCurve& hit : out) hit.tangent.normalize();
  return out;
}

namespace {

double lengthInside(const mesh::TetMesh& mesh, const std::vector<std::int32_t>& tets,
                    const std::vector<Vector3>& line) {
  struct Piece {
    std::size_t segment;
    double lo, hi;
    auto operator<=>(const Piece&) const = default;
  };
  std::vector<Piece> pieces;
  forEachPiece(mesh, tets, line, [&](std::int32_t, std::size_t k, double lo, double hi) {
    pieces.push_back({k, lo, hi});
  });
  std::ranges::sort(pieces);

  // Union of intervals, segment by segment
  double length = 0.0;
  double reached = 0.0;
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    const Piece& p = pieces[i];
    if (i == 0 || pieces[i - 1].segment != p.segment) reached = 0.0;
    if (p.hi <= reached) continue;
    length += (p.hi - std::max(p.lo, reached)) * (line[p.segment + 1] - line[p.segment]).norm();
    reached = p.hi;
  }
  return length;
}

}  // namespace

double shareInside(const mesh::TetMesh& mesh, const std::vector<std::int32_t>& tets,
                   const std::vector<std::vector<Vector3>>& lines) {
  double inside = 0.0;
  double length = 0.0;
  for (const std::vector<Vector3>& line : lines) {
    for (std::size_t k = 1; k < line.size(); ++k) length += (line[k] - line[k - 1]).norm();
    inside += lengthInside(mesh, tets, line);
  }
  return length > 0.0 ? std::min(1.0, inside / length) : 1.0;
}

}  // namespace ecorche::fiber
