#include <ecorche/core/parallel.h>
#include <ecorche/exchange/check_parts.h>
#include <ecorche/exchange/surface_faults.h>
#include <ecorche/mesh/orientation.h>
#include <ecorche/mesh/surface_mesh.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace ecorche::exchange {

using mesh::kTetFace;

namespace {

Eigen::Vector3d vertex(const CheckedFiles& files, std::int32_t v) {
  return files.anatomy->mesh.V.row(v).transpose();
}

void checkFormatsAgree(const CheckedFiles& files, Checks& checks) {
  if (!files.vtu || !files.medit) return;
  const AnatomyFile& a = *files.vtu;
  const AnatomyFile& b = *files.medit;
  Check c{"formats-agree"};
  if (a.mesh.V.rows() != b.mesh.V.rows() || a.mesh.T.rows() != b.mesh.T.rows()) {
    c.value = static_cast<double>(std::abs(a.mesh.V.rows() - b.mesh.V.rows()) +
                                  std::abs(a.mesh.T.rows() - b.mesh.T.rows()));
    c.detail = fmt::format("anatomy.vtu has {} points and {} tets, anatomy.mesh {} and {}",
                           a.mesh.V.rows(), a.mesh.T.rows(), b.mesh.V.rows(), b.mesh.T.rows());
  } else {
    // Differences count by rows: a NaN differs from everything, itself included
    std::int64_t points = 0;
    for (Eigen::Index v = 0; v < a.mesh.V.rows(); ++v) {
      const bool differs = a.mesh.V.row(v) != b.mesh.V.row(v);
      if (differs && !c.point) c.point = a.mesh.V.row(v).transpose();
      points += differs;
    }
    std::int64_t tets = 0;
    for (Eigen::Index t = 0; t < a.mesh.T.rows(); ++t) {
      tets += a.mesh.T.row(t) != b.mesh.T.row(t) ||
              a.tissue[static_cast<std::size_t>(t)] != b.tissue[static_cast<std::size_t>(t)];
    }
    c.value = static_cast<double>(points + tets);
    c.detail = fmt::format("{} points and {} tets differ between anatomy.vtu and anatomy.mesh",
                           points, tets);
  }
  c.pass = c.value == 0.0;
  checks.push_back(std::move(c));
}

void checkLabels(const CheckedFiles& files, Checks& checks) {
  Check c{"labels-known"};
  std::int64_t unknown = 0;
  for (std::size_t t = 0; t < files.anatomy->tissue.size(); ++t) {
    const std::int32_t id = files.anatomy->tissue[t];
    if (files.tissue(id) != nullptr) continue;
    if (unknown++ == 0) {
      c.object = fmt::format("tissue {}", id);
      c.point = files.centroid(static_cast<std::int64_t>(t));
    }
  }
  // Names in the VTU have to be those of model.json
  std::int64_t misnamed = 0;
  if (files.vtu) {
    for (const TissueName& n : files.vtu->names) {
      const TissueRecord* tissue = files.tissue(n.id);
      if (tissue == nullptr || tissue->name != n.name) {
        ++misnamed;
        c.object = n.name;
      }
    }
    misnamed += files.vtu->names.size() != files.record.tissues.size();
  }
  c.value = static_cast<double>(unknown + misnamed);
  c.pass = c.value == 0.0;
  c.detail = fmt::format("{} tets of unknown tissue, {} names that differ from model.json", unknown,
                         misnamed);
  checks.push_back(std::move(c));
}

void checkPositive(const CheckedFiles& files, Checks& checks) {
  const mesh::TetMesh& m = files.anatomy->mesh;
  std::vector<std::int8_t> sign(static_cast<std::size_t>(m.T.rows()));
  parallelFor(m.T.rows(), [&](std::int64_t t) {
    bool finite = true;
    for (int k = 0; k < 4; ++k) finite &= m.V.row(m.T(t, k)).allFinite();
    sign[static_cast<std::size_t>(t)] =
        finite ? static_cast<std::int8_t>(mesh::orientation(m, t)) : -1;
  });
  Check c{"tets-positive"};
  const auto flat = std::ranges::count(sign, 0);
  const auto turned = std::ranges::count(sign, -1);
  c.value = static_cast<double>(flat + turned);
  c.pass = c.value == 0.0;
  if (!c.pass) {
    const auto first = std::ranges::find_if(sign, [](int s) { return s <= 0; }) - sign.begin();
    c.point = files.centroid(first);
    c.object = fmt::format("tet {}", first);
  }
  c.detail =
      fmt::format("{} of {} tets have no volume, {} negative volume or no finite corners (exact)",
                  flat, m.T.rows(), turned);
  checks.push_back(std::move(c));
}

// True where two tets see their common face from opposite sides.
bool oppositeSides(const mesh::Tets& T, Eigen::Index t, int k, std::int32_t n) {
  std::array<std::int32_t, 3> own{};
  for (std::size_t c = 0; c < 3; ++c) own[c] = T(t, kTetFace[k][c]);
  for (const auto& face : kTetFace) {
    // The same face read backwards is a rotation of (0, 2, 1)
    for (std::size_t turn = 0; turn < 3; ++turn) {
      if (T(n, face[0]) == own[turn] && T(n, face[1]) == own[(turn + 2) % 3] &&
          T(n, face[2]) == own[(turn + 1) % 3]) {
        return true;
      }
    }
  }
  return false;
}

void checkFacesShared(const CheckedFiles& files, Checks& checks) {
  const mesh::Tets& T = files.anatomy->mesh.T;
  Check c{"faces-shared"};
  std::int64_t folded = 0;
  for (Eigen::Index t = 0; t < T.rows(); ++t) {
    for (int k = 0; k < 4; ++k) {
      const std::int32_t n = files.adjacency.neighbours(t, k);
      if (n < t || oppositeSides(T, t, k, n)) continue;
      if (folded++ == 0) c.point = files.centroid(t);
    }
  }
  c.value = static_cast<double>(files.adjacency.nonManifoldFaces + folded);
  c.pass = c.value == 0.0;
  c.detail = fmt::format("{} faces in three tets or more, {} whose two tets lie on the same side",
                         files.adjacency.nonManifoldFaces, folded);
  checks.push_back(std::move(c));
}

using FaceKey = std::array<std::int32_t, 3>;

FaceKey keyOf(std::int32_t a, std::int32_t b, std::int32_t c) {
  FaceKey key{a, b, c};
  std::ranges::sort(key);
  return key;
}

struct Tagged {
  FaceKey key;
  std::int32_t inner, outer;  // tissues on both sides; outer 0 on the boundary
  auto operator<=>(const Tagged&) const = default;
};

// Every face with one tet and every face between tissues stands in the file as a triangle, and no
// other: a crack inside the domain would be a face of one tet that no triangle marks.
void checkFacesMarked(const CheckedFiles& files, Checks& checks) {
  if (!files.medit || files.medit->F.rows() == 0) return;
  const AnatomyFile& a = *files.anatomy;
  std::vector<Tagged> due;
  for (Eigen::Index t = 0; t < a.mesh.T.rows(); ++t) {
    for (int k = 0; k < 4; ++k) {
      const std::int32_t n = files.adjacency.neighbours(t, k);
      const std::int32_t own = a.tissue[static_cast<std::size_t>(t)];
      const std::int32_t other = n < 0 ? 0 : a.tissue[static_cast<std::size_t>(n)];
      if (n >= 0 && other >= own) continue;
      due.push_back({keyOf(a.mesh.T(t, kTetFace[k][0]), a.mesh.T(t, kTetFace[k][1]),
                           a.mesh.T(t, kTetFace[k][2])),
                     own, other});
    }
  }
  std::ranges::sort(due);

  std::vector<FaceKey> marked;
  for (Eigen::Index f = 0; f < files.medit->F.rows(); ++f) {
    marked.push_back(keyOf(files.medit->F(f, 0), files.medit->F(f, 1), files.medit->F(f, 2)));
  }
  std::ranges::sort(marked);

  Check c{"faces-marked"};
  std::int64_t missing = 0;
  std::size_t at = 0;
  for (const Tagged& face : due) {
    while (at < marked.size() && marked[at] < face.key) ++at;
    if (at < marked.size() && marked[at] == face.key) continue;
    if (missing++ == 0) c.point = vertex(files, face.key[0]);
  }
  std::int64_t stray = 0;
  std::size_t d = 0;
  for (std::size_t m = 0; m < marked.size(); ++m) {
    while (d < due.size() && due[d].key < marked[m]) ++d;
    const bool repeated = m > 0 && marked[m] == marked[m - 1];
    if (!repeated && d < due.size() && due[d].key == marked[m]) continue;
    if (stray++ == 0 && !c.point) c.point = vertex(files, marked[m][0]);
  }
  c.value = static_cast<double>(missing + stray);
  c.pass = c.value == 0.0;
  c.detail = fmt::format(
      "{} faces of one tet or between tissues have no triangle, {} triangles are no such face",
      missing, stray);
  checks.push_back(std::move(c));
}

void checkBoundary(const CheckedFiles& files, Checks& checks) {
  const SurfaceFaults faults = surfaceFaults(files.boundary.F);
  Check c{"boundary-closed"};
  c.value =
      static_cast<double>(faults.openEdges + faults.nonManifoldEdges + faults.misorientedEdges);
  c.pass = c.value == 0.0;
  c.detail = fmt::format(
      "{} triangles around the domain: {} open edges, {} with three faces or more, {} misoriented",
      files.boundary.F.rows(), faults.openEdges, faults.nonManifoldEdges, faults.misorientedEdges);
  const std::int32_t at = faults.openAt >= 0 ? faults.openAt : faults.nonManifoldEdgeAt;
  if (at >= 0) c.point = vertex(files, at);
  checks.push_back(std::move(c));
}

void checkVolumes(const CheckedFiles& files, Checks& checks) {
  // Divergence theorem on the boundary against sums over tets, tissue by tissue
  const double around = mesh::signedVolume(files.anatomy->mesh.V, files.boundary.F);
  double tissues = 0.0;
  for (const auto& tets : files.tetsOf) {
    double sum = 0.0;
    for (const std::int32_t t : tets) sum += files.volume[t];
    tissues += sum;
  }
  Check c{"volumes-add-up"};
  c.limit = 1e-9;
  c.value = around > 0.0 ? std::abs(tissues - around) / around : INFINITY;
  c.pass = c.value <= c.limit;
  c.detail = fmt::format("tissues {:.9g} cm³, enclosed by the boundary {:.9g} cm³", tissues * 1e6,
                         around * 1e6);
  checks.push_back(std::move(c));
}

}  // namespace

void checkTets(const CheckedFiles& files, Checks& checks) {
  checkFormatsAgree(files, checks);
  checkLabels(files, checks);
  checkPositive(files, checks);
  checkFacesShared(files, checks);
  checkFacesMarked(files, checks);
  checkBoundary(files, checks);
  checkVolumes(files, checks);
}

}  // namespace ecorche::exchange
