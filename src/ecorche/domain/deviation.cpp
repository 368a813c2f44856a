#include <ecorche/core/parallel.h>
#include <ecorche/domain/deviation.h>
#include <ecorche/domain/face_samples.h>
#include <ecorche/domain/triangle_tree.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>

namespace ecorche::domain {

namespace {

using mesh::Vector3;
using FacesOfTag = std::map<BoundaryTag, std::vector<Eigen::Index>>;

struct OneWay {
  double max = 0.0;
  double mean = 0.0;  // by area
};

OneWay distances(const mesh::Positions& V, const mesh::Triangles& F,
                 const std::vector<Eigen::Index>& faces, const TriangleTree& to, double spacing) {
  std::vector<OneWay> of(faces.size());
  std::vector<double> area(faces.size());
  parallelFor(
      static_cast<std::int64_t>(faces.size()),
      [&](std::int64_t i) {
        const auto at = static_cast<std::size_t>(i);
        const auto points = faceSamples(V, F, faces[at], spacing);
        for (const Vector3& p : points) {
          const double d = std::sqrt(to.closest(p).distance2);
          of[at].max = std::max(of[at].max, d);
          of[at].mean += d / static_cast<double>(points.size());
        }
        area[at] = mesh::surfaceArea(V, F.row(faces[at]));
      },
      64);
  OneWay out;
  double whole = 0.0;
  for (std::size_t i = 0; i < of.size(); ++i) {
    out.max = std::max(out.max, of[i].max);
    out.mean += area[i] * of[i].mean;
    whole += area[i];
  }
  if (whole > 0.0) out.mean /= whole;
  return out;
}

/// Faces of a wrapped hole that lie open: kept, inside the skin, and nothing of any hole straight
/// ahead.
std::vector<Eigen::Index> openFaces(const Hole& hole, const CarveInput& input,
                                    const TriangleTree& holes, const TriangleTree& carved,
                                    double clearance) {
  std::vector<Eigen::Index> out;
  const auto& V = hole.mesh.V;
  const auto& F = hole.mesh.F;
  for (Eigen::Index f = 0; f < F.rows(); ++f) {
    const std::array<Vector3, 3> points{V.row(F(f, 0)).transpose(), V.row(F(f, 1)).transpose(),
                                        V.row(F(f, 2)).transpose()};
    const Vector3 n = (points[1] - points[0]).cross(points[2] - points[0]).normalized();
    const auto kept = [&](const Vector3& p) {
      for (const CutPlane& plane : input.cutPlanes) {
        if (plane.normal.dot(p - plane.point) < clearance) return false;
      }
      return true;
    };
    if (!n.allFinite() || !std::ranges::all_of(points, kept)) continue;
    // Straight ahead there is room, and where the room ends is a wall of the domain that looks this
    // way
    const Vector3 from = (points[0] + points[1] + points[2]) / 3.0;
    if (holes.firstHit(from, n, 1e-6 * clearance, 2.0 * clearance)) continue;
    const Vector3 ahead = from + 2.0 * clearance * n;
    if (!carved.firstHit(ahead, n, 0.0, 1e6 * clearance)) continue;
    const auto back = carved.closest(ahead);
    const Vector3 wall = carved.normal(back.triangle);
    if (wall.dot(ahead - back.point) > 0)
      continue;  // outside the domain: beyond the skin or in a bone
    out.push_back(f);
  }
  return out;
}

}  // namespace

std::vector<SurfaceDeviation> measureDeviations(const Domain& domain, const Carved& carved,
                                                const CarveInput& input, double tolerance,
                                                RunContext& run) {
  const Stage stage(run, "domain: deviation");
  const double spacing = kSampleSpacing * tolerance;
  const TriangleTree toDomain(domain.mesh.V, domain.boundaryF);
  FacesOfTag domainFaces;
  for (std::size_t f = 0; f < domain.boundaryTag.size(); ++f) {
    domainFaces[domain.boundaryTag[f]].push_back(static_cast<Eigen::Index>(f));
  }
  FacesOfTag carvedFaces;
  for (std::size_t f = 0; f < carved.surface.tag.size(); ++f) {
    carvedFaces[unpacked(carved.surface.tag[f])].push_back(static_cast<Eigen::Index>(f));
  }

  std::vector<SurfaceDeviation> out;
  const auto look = [&](BoundaryTag tag, const std::string& name, const mesh::SurfaceMesh& original,
                        double moved, const OneWay& fromInput) {
    const TriangleTree toInput(original.V, original.F);
    const OneWay back =
        distances(domain.mesh.V, domain.boundaryF, domainFaces[tag], toInput, spacing);
    // What the mesh was moved before it came here counts on top
    out.push_back(
        {name, fromInput.max + moved, fromInput.mean + moved, back.max + moved, back.mean + moved});
  };
  const auto exact = [&](BoundaryTag tag) {
    return distances(carved.surface.V, carved.surface.F, carvedFaces[tag], toDomain, spacing);
  };
  const BoundaryTag skin{BoundaryTag::Kind::Skin, 0};
  look(skin, input.skin.name, input.skin, input.skinMoved, exact(skin));

  std::optional<TriangleTree> holes;
  std::optional<TriangleTree> walls;
  for (std::size_t h = 0; h < input.holes.size(); ++h) {
    const Hole& hole = input.holes[h];
    if (!domainFaces.contains(hole.tag)) continue;
    if (!std::ranges::binary_search(carved.wrapped, h)) {
      look(hole.tag, hole.name, hole.mesh, hole.moved, exact(hole.tag));
      continue;
    }
    if (!holes) {
      std::vector<mesh::SurfaceMesh> meshes;
      for (const Hole& each : input.holes) meshes.push_back(each.mesh);
      const auto all = mesh::joined(meshes, "holes");
      holes.emplace(all.V, all.F);
      walls.emplace(carved.surface.V, carved.surface.F);
    }
    const auto open = openFaces(hole, input, *holes, *walls, 0.5 * tolerance);
    look(hole.tag, hole.name, hole.mesh, hole.moved,
         distances(hole.mesh.V, hole.mesh.F, open, toDomain, spacing));
  }
  return out;
}

}  // namespace ecorche::domain
