#pragma once

#include <ecorche/mesh/surface_check.h>
#include <ecorche/mesh/surface_repair.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <string>

#include "support/shapes.h"

// For tests of repairs only, which speak of little else.
namespace ecorche::mesh {

inline Result<RepairedSurface> repair(const SurfaceMesh& m, const RepairOptions& options = {}) {
  RunContext run;
  return repairSurface(m, options, run);
}

inline bool repaired(const RepairedSurface& r, const std::string& kind) {
  return std::ranges::any_of(r.findings, [&](const Finding& f) {
    return f.kind == kind && f.severity == Severity::Repaired;
  });
}

// nullptr: there is none of that kind.
inline const Finding* findingOf(const RepairedSurface& r, const std::string& kind) {
  const auto at = std::ranges::find(r.findings, kind, &Finding::kind);
  return at == r.findings.end() ? nullptr : &*at;
}

// Sound, outward, of this volume.
inline void checkWhole(const Result<RepairedSurface>& r, double volume) {
  REQUIRE(r);
  const SurfaceCheck check = checkSurface(r->mesh);
  CHECK(check.isSound());
  CHECK(check.unusedVertices == 0);
  CHECK(signedVolume(r->mesh.V, r->mesh.F) == Approx(volume).epsilon(1e-3));
}

inline SurfaceMesh ball() { return test::sphere({0.1, 0.2, 0.3}, 1, 3); }
inline double volumeOf(const SurfaceMesh& m) { return signedVolume(m.V, m.F); }

// All of them as one part, as a file without groups has them.
inline SurfaceMesh onePart(const std::vector<SurfaceMesh>& meshes) {
  SurfaceMesh out = joined(meshes, "pieces");
  out.parts.clear();
  return out;
}

inline void dropFace(SurfaceMesh& m, Eigen::Index f) {
  m.F.row(f) = m.F.row(m.F.rows() - 1).eval();
  m.F.conservativeResize(m.F.rows() - 1, 3);
}

inline void addFace(SurfaceMesh& m, std::int32_t a, std::int32_t b, std::int32_t c) {
  m.F.conservativeResize(m.F.rows() + 1, 3);
  m.F.bottomRows(1) << a, b, c;
}

// Every face with vertices of its own, as a careless exporter writes them.
inline SurfaceMesh unwelded(const SurfaceMesh& m) {
  SurfaceMesh out = m;
  out.V.resize(3 * m.F.rows(), 3);
  for (Eigen::Index f = 0; f < m.F.rows(); ++f) {
    for (int k = 0; k < 3; ++k) {
      out.V.row(3 * f + k) = m.V.row(m.F(f, k));
      out.F(f, k) = static_cast<std::int32_t>(3 * f + k);
    }
  }
  return out;
}

}  // namespace ecorche::mesh
