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

class Faces {
 public:
  Faces(const Positions& V, const Triangles& F) : V_(V), F_(F) {}

  [[nodiscard]] Kernel::Triangle_3 triangle(std::int32_t f) const {
    return {point(F_(f, 0)), point(F_(f, 1)), point(F_(f, 2))};
  }

  [[nodiscard]] bool meet(std::int32_t f, std::int32_t g) const {
    // Corners of f that g has too, and where
    int shared = 0;
    int inF[3] = {0, 0, 0};
    int inG[3] = {0, 0, 0};
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        if (F_(f, i) != F_(g, j)) continue;
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
        const Point a = point(F_(f, inF[0]));
        const Point b = point(F_(f, inF[1]));
        const Point c = point(F_(f, 3 - inF[0] - inF[1]));
        const Point d = point(F_(g, 3 - inG[0] - inG[1]));
        return CGAL::coplanar(a, b, c, d) &&
               CGAL::coplanar_orientation(a, b, c, d) == CGAL::POSITIVE;
      }
      default:
        return false;
    }
  }

 private:
  [[nodiscard]] Point point(std::int32_t v) const { return {V_(v, 0), V_(v, 1), V_(v, 2)}; }
  [[nodiscard]] Kernel::Segment_3 farEdge(std::int32_t f, int corner) const {
    return {point(F_(f, (corner + 1) % 3)), point(F_(f, (corner + 2) % 3))};
  }
  const Positions& V_;
  const Triangles& F_;
};

}  // namespace

std::vector<std::pair<std::int32_t, std::int32_t>> selfIntersections(const Positions& V,
                                                                     const Triangles& F) {
  const Faces faces(V, F);
  std::vector<FaceBox> boxes;
  boxes.reserve(static_cast<std::size_t>(F.rows()));
  for (Eigen::Index f = 0; f < F.rows(); ++f) {
    const auto triangle = faces.triangle(static_cast<std::int32_t>(f));
    if (!triangle.is_degenerate())
      boxes.emplace_back(triangle.bbox(), static_cast<std::int32_t>(f));
  }
  std::vector<std::pair<std::int32_t, std::int32_t>> pairs;
  CGAL::box_self_intersection_d(boxes.begin(), boxes.end(),
                                [&](const FaceBox& a, const FaceBox& b) {
                                  pairs.emplace_back(std::minmax(a.info(), b.info()));
                                });
  std::vector<char> meets(pairs.size());
  parallelFor(static_cast<std::int64_t>(pairs.size()), [&](std::int64_t i) {
    const auto p = static_cast<std::size_t>(i);
    meets[p] = faces.meet(pairs[p].first, pairs[p].second) ? 1 : 0;
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
