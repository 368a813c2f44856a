#include <CGAL/Mesh_complex_3_in_triangulation_3.h>
#include <CGAL/Mesh_criteria_3.h>
#include <CGAL/Mesh_triangulation_3.h>
#include <CGAL/Polyhedral_mesh_domain_with_features_3.h>
#include <CGAL/exceptions.h>
#include <CGAL/make_mesh_3.h>
#include <ecorche/domain/fill_mesh_3.h>
#include <ecorche/domain/resample.h>
#include <ecorche/domain/triangle_tree.h>
#include <ecorche/mesh/cgal_surface.h>
#include <fmt/format.h>

#include <array>
#include <unordered_map>

namespace ecorche::domain {

namespace {

using mesh::Vector3;
using Kernel = mesh::CgalKernel;
using MeshDomain = CGAL::Polyhedral_mesh_domain_with_features_3<Kernel, mesh::CgalSurface>;
using Triangulation = CGAL::Mesh_triangulation_3<MeshDomain>::type;
using Complex = CGAL::Mesh_complex_3_in_triangulation_3<Triangulation, MeshDomain::Corner_index,
                                                        MeshDomain::Curve_index>;
using Criteria = CGAL::Mesh_criteria_3<Triangulation>;

constexpr double kRidgeDeg = 40.0;
constexpr double kSliverBoundDeg = 8.0;  // no limit of time: the same tets every time

// Mesh_3 asks for circumradii, of a regular tet and of a regular triangle of edge 1; it takes them
// for bounds, and its tets come out smaller by this much on average (measured on balls)
constexpr double kBoundOverSize = 1.37;
constexpr double kTetRadius = 0.612 * kBoundOverSize;
constexpr double kTriangleRadius = 0.577 * kBoundOverSize;

/// The wanted length times a factor, in the form that Mesh_3 asks for it.
struct Size {
  using FT = Kernel::FT;
  using Point_3 = MeshDomain::Point_3;
  using Index = MeshDomain::Index;
  const LengthField* length;
  double factor;
  template <class P>
  FT operator()(const P& p, int, const Index&) const {
    return factor * (*length)(Vector3(p.x(), p.y(), p.z()));
  }
};

TetAnswer toAnswer(const Complex& complex) {
  TetAnswer answer;
  const Triangulation& tr = complex.triangulation();
  std::unordered_map<Triangulation::Vertex_handle, std::int32_t> number;
  std::vector<Vector3> positions;
  const auto numberOf = [&](Triangulation::Vertex_handle v) {
    const auto [it, fresh] = number.try_emplace(v, static_cast<std::int32_t>(positions.size()));
    if (fresh) {
      const auto p = tr.point(v);
      positions.emplace_back(CGAL::to_double(p.x()), CGAL::to_double(p.y()),
                             CGAL::to_double(p.z()));
    }
    return it->second;
  };
  answer.T.resize(static_cast<Eigen::Index>(complex.number_of_cells_in_complex()), 4);
  Eigen::Index t = 0;
  for (auto c = complex.cells_in_complex_begin(); c != complex.cells_in_complex_end(); ++c, ++t) {
    for (int k = 0; k < 4; ++k) answer.T(t, k) = numberOf(c->vertex(k));
  }
  answer.F.resize(static_cast<Eigen::Index>(complex.number_of_facets_in_complex()), 3);
  Eigen::Index f = 0;
  for (auto it = complex.facets_in_complex_begin(); it != complex.facets_in_complex_end();
       ++it, ++f) {
    for (int k = 0; k < 3; ++k) {
      answer.F(f, k) = numberOf(it->first->vertex((it->second + 1 + k) % 4));
    }
  }
  answer.V.resize(static_cast<Eigen::Index>(positions.size()), 3);
  for (std::size_t v = 0; v < positions.size(); ++v) {
    answer.V.row(static_cast<Eigen::Index>(v)) = positions[v].transpose();
  }
  return answer;
}

/// Every face belongs to what its middle is closest to; on a cut plane its vertices are put there.
void tagFaces(TetAnswer& answer, const TaggedSurface& surface,
              const std::vector<CutPlane>& cutPlanes) {
  const TriangleTree tree(surface.V, surface.F);
  for (Eigen::Index f = 0; f < answer.F.rows(); ++f) {
    const Vector3 middle =
        (answer.V.row(answer.F(f, 0)) + answer.V.row(answer.F(f, 1)) + answer.V.row(answer.F(f, 2)))
            .transpose() /
        3.0;
    answer.tag.push_back(surface.tag[static_cast<std::size_t>(tree.closest(middle).triangle)]);
    const BoundaryTag tag = unpacked(answer.tag.back());
    if (tag.kind != BoundaryTag::Kind::CutPlane) continue;
    for (int k = 0; k < 3; ++k) {
      const std::int32_t v = answer.F(f, k);
      answer.V.row(v) =
          ontoPlane(cutPlanes[static_cast<std::size_t>(tag.index)], answer.V.row(v).transpose())
              .transpose();
    }
  }
}

}  // namespace

Result<TetAnswer> fillByMesh3(const FillRequest& request) {
  try {
    // The same random numbers every time
    CGAL::get_default_random() = CGAL::Random(0);
    const LengthField edgeLength = [&](const Vector3& p) {
      return request.scale * request.sizing.at(p);
    };
    const auto mesh = mesh::toCgal({.V = request.surface.V, .F = request.surface.F});
    if (!mesh) return fail(ErrorCode::MeshingFailed, "the walls are no manifold surface");
    MeshDomain domain(*mesh);
    domain.detect_features(kRidgeDeg);
    namespace params = CGAL::parameters;
    const Criteria criteria(params::edge_size = Size{&edgeLength, 1.0}, params::facet_angle = 25.0,
                            params::facet_size = Size{&edgeLength, kTriangleRadius},
                            params::facet_distance = 0.4 * request.tolerance,
                            params::cell_radius_edge_ratio = 2.0,
                            params::cell_size = Size{&edgeLength, kTetRadius});
    const Complex complex =
        CGAL::make_mesh_3<Complex>(domain, criteria, params::manifold(), params::no_exude(),
                                   params::perturb(params::sliver_bound = kSliverBoundDeg));
    if (complex.number_of_cells_in_complex() == 0) {
      return fail(ErrorCode::MeshingFailed, "CGAL Mesh_3 found no inside");
    }
    TetAnswer answer = toAnswer(complex);
    tagFaces(answer, request.surface, request.cutPlanes);
    return answer;
  } catch (const CGAL::Failure_exception& e) {
    // Its what() is a page with paths of the machine it was built on
    const auto slash = e.filename().find_last_of('/');
    return fail(ErrorCode::MeshingFailed,
                fmt::format("CGAL Mesh_3 gave up at {}:{}",
                            e.filename().substr(slash == std::string::npos ? 0 : slash + 1),
                            e.line_number()));
  } catch (const std::exception& e) {
    return fail(ErrorCode::MeshingFailed, fmt::format("CGAL Mesh_3 gave up: {}", e.what()));
  }
}

}  // namespace ecorche::domain
