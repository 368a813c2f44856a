#include <ecorche/mesh/surface_mesh.h>

#include <Eigen/Geometry>
#include <cmath>

namespace ecorche::mesh {

Box boundingBox(const Positions& V) {
  Box box;
  for (Eigen::Index v = 0; v < V.rows(); ++v) box.add(V.row(v).transpose());
  return box;
}

Box boundingBox(const SurfaceMesh& mesh) {
  Box box;
  for (Eigen::Index f = 0; f < mesh.F.rows(); ++f) {
    for (int k = 0; k < 3; ++k) box.add(mesh.V.row(mesh.F(f, k)).transpose());
  }
  return box;
}

double signedVolume(const Positions& V, const Triangles& F) {
  if (F.rows() == 0) return 0.0;
  // About a point of the mesh, so that a model far from the origin loses no digits
  const Vector3 o = V.row(F(0, 0)).transpose();
  double six = 0.0;
  for (Eigen::Index f = 0; f < F.rows(); ++f) {
    const Vector3 a = V.row(F(f, 0)).transpose() - o;
    const Vector3 b = V.row(F(f, 1)).transpose() - o;
    const Vector3 c = V.row(F(f, 2)).transpose() - o;
    six += a.dot(b.cross(c));
  }
  return six / 6.0;
}

double surfaceArea(const Positions& V, const Triangles& F) {
  double twice = 0.0;
  for (Eigen::Index f = 0; f < F.rows(); ++f) {
    const Vector3 a = V.row(F(f, 0)).transpose();
    twice += (V.row(F(f, 1)).transpose() - a).cross(V.row(F(f, 2)).transpose() - a).norm();
  }
  return 0.5 * twice;
}

Directions vertexNormals(const Positions& V, const Triangles& F) {
  Directions N = Directions::Zero(V.rows(), 3);
  for (Eigen::Index f = 0; f < F.rows(); ++f) {
    for (int k = 0; k < 3; ++k) {
      const Vector3 a = V.row(F(f, k)).transpose();
      const Vector3 u = V.row(F(f, (k + 1) % 3)).transpose() - a;
      const Vector3 w = V.row(F(f, (k + 2) % 3)).transpose() - a;
      const Vector3 n = u.cross(w);
      const double length = n.norm();
      if (length > 0.0) N.row(F(f, k)) += (std::atan2(length, u.dot(w)) / length * n).transpose();
    }
  }
  for (Eigen::Index v = 0; v < V.rows(); ++v) {
    const double length = N.row(v).norm();
    if (length > 0.0) N.row(v) /= length;
  }
  return N;
}

namespace {

SurfaceMesh compactedFaces(const Positions& V, const Triangles& F) {
  std::vector<std::int32_t> fresh(static_cast<std::size_t>(V.rows()), -1);
  for (Eigen::Index f = 0; f < F.rows(); ++f) {
    for (int k = 0; k < 3; ++k) fresh[static_cast<std::size_t>(F(f, k))] = 0;
  }
  std::int32_t count = 0;
  for (auto& id : fresh) {
    if (id == 0) id = count++;
  }
  SurfaceMesh out;
  out.V.resize(count, 3);
  for (Eigen::Index v = 0; v < V.rows(); ++v) {
    if (fresh[static_cast<std::size_t>(v)] >= 0)
      out.V.row(fresh[static_cast<std::size_t>(v)]) = V.row(v);
  }
  out.F.resize(F.rows(), 3);
  for (Eigen::Index f = 0; f < F.rows(); ++f) {
    for (int k = 0; k < 3; ++k) out.F(f, k) = fresh[static_cast<std::size_t>(F(f, k))];
  }
  return out;
}

}  // namespace

SurfaceMesh compacted(const SurfaceMesh& mesh) {
  SurfaceMesh out = compactedFaces(mesh.V, mesh.F);
  out.name = mesh.name;
  out.parts = mesh.parts;
  return out;
}

SurfaceMesh partOf(const SurfaceMesh& mesh, std::size_t part) {
  const Part& p = mesh.parts.at(part);
  SurfaceMesh out = compactedFaces(mesh.V, mesh.F.middleRows(p.firstFace, p.faceCount));
  out.name = p.name;
  return out;
}

SurfaceMesh joined(const std::vector<SurfaceMesh>& meshes, std::string name) {
  Eigen::Index vertexCount = 0;
  Eigen::Index faceCount = 0;
  for (const auto& m : meshes) {
    vertexCount += m.V.rows();
    faceCount += m.F.rows();
  }
  SurfaceMesh out;
  out.name = std::move(name);
  out.V.resize(vertexCount, 3);
  out.F.resize(faceCount, 3);
  Eigen::Index v = 0;
  Eigen::Index f = 0;
  for (const auto& m : meshes) {
    out.V.middleRows(v, m.V.rows()) = m.V;
    out.F.middleRows(f, m.F.rows()) = m.F.array() + static_cast<std::int32_t>(v);
    out.parts.push_back(
        {m.name, static_cast<std::int32_t>(f), static_cast<std::int32_t>(m.F.rows())});
    v += m.V.rows();
    f += m.F.rows();
  }
  return out;
}

}  // namespace ecorche::mesh
