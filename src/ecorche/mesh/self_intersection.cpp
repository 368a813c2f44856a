#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/box_intersection_d.h>
#include <ecorche/core/parallel.h>
#include <ecorche/mesh/self_intersection.h>

#include <algorithm>

namespace ecorche::mesh {

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;
using FaceBox = CGAL::Box_intersection_d::Box_with_info_d<double, 3, std::int32_t>;

Point point(const Vector3& p) { return {p.x(), p.y(), p.z()}; }
Kernel::Triangle_3 triangle(const FaceCorners& f) {
  return {point(f.at[0]), point(f.at[1]), point(f.at[2])};
}
Kernel::Segment_3 farEdge(const FaceCorners& f, std::size_t corner) {
  return {point(f.at[(corner + 1) % 3]), point(f.at[(corner + 2) % 3])};
}

}  // namespace

FaceCorners faceCorners(const Positions& V, const Triangles& F, Eigen::Index face) {
  FaceCorners out;
  for (int k = 0; k < 3; ++k) {
    out.vertex[static_cast<std::size_t>(k)] = F(face, k);
    out.at[static_cast<std::size_t>(k)] = V.row(F(face, k)).transpose();
  }
  return out;
}

bool isDegenerate(const FaceCorners& face) { return triangle(face).is_degenerate(); }

bool facesMeet(const FaceCorners& f, const FaceCorners& g) {
  // Corners of f that g has too, and where
  std::size_t shared = 0;
  std::size_t inF[3] = {0, 0, 0};
  std::size_t inG[3] = {0, 0, 0};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      if (f.vertex[i] != g.vertex[j]) continue;
      if (shared < 3) {
        inF[shared] = i;
        inG[shared] = j;
      }
      ++shared;
    }
  }
  switch (shared) {
    case 0:
      return CGAL::do_intersect(triangle(f), triangle(g));
    case 1:  // past the common corner, one triangle's far edge must cross the other triangle
      return CGAL::do_intersect(farEdge(f, inF[0]), triangle(g)) ||
             CGAL::do_intersect(farEdge(g, inG[0]), triangle(f));
    case 2: {  // only folded flat upon each other
      const Point a = point(f.at[inF[0]]);
      const Point b = point(f.at[inF[1]]);
      const Point c = point(f.at[3 - inF[0] - inF[1]]);
      const Point d = point(g.at[3 - inG[0] - inG[1]]);
      return CGAL::coplanar(a, b, c, d) && CGAL::coplanar_orientation(a, b, c, d) == CGAL::POSITIVE;
    }
    default:
      return false;
  }
}

std::vector<std::pair<std::int32_t, std::int32_t>> selfIntersections(const Positions& V,
                                                                     const Triangles& F) {
  std::vector<FaceBox> boxes;
  boxes.reserve(static_cast<std::size_t>(F.rows()));
  for (Eigen::Index f = 0; f < F.rows(); ++f) {
    const auto face = triangle(faceCorners(V, F, f));
    if (!face.is_degenerate()) boxes.emplace_back(face.bbox(), static_cast<std::int32_t>(f));
  }
  std::vector<std::pair<std::int32_t, std::int32_t>> pairs;
  CGAL::box_self_intersection_d(boxes.begin(), boxes.end(),
                                [&](const FaceBox& a, const FaceBox& b) {
                                  pairs.emplace_back(std::minmax(a.info(), b.info()));
                                });
  std::vector<char> meets(pairs.size());
  parallelFor(static_cast<std::int64_t>(pairs.size()), [&](std::int64_t i) {
    const auto p = static_cast<std::size_t>(i);
    const auto& [f, g] = pairs[p];
    meets[p] = facesMeet(faceCorners(V, F, f), faceCorners(V, F, g)) ? 1 : 0;
  });
  std::size_t kept = 0;
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    if (meets[p] != 0) pairs[kept++] = pairs[p];
  }
  pairs.resize(kept);
  std::ranges::sort(pairs);
  return pairs;
}

}  // namespace ecorche::mesh
