#pragma once

#include <ecorche/core/finding.h>
#include <ecorche/core/run_context.h>
#include <ecorche/domain/domain.h>
#include <ecorche/domain/sizing_field.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace ecorche::domain {

/// Everything in one frame, metres. Meshes may be in the state in which people have them.
struct DomainInput {
  mesh::SurfaceMesh skin;
  std::vector<mesh::SurfaceMesh> bones;
  std::vector<mesh::SurfaceMesh> obstacles;  ///< closed meshes that stay as they are
  std::vector<mesh::SurfaceMesh> cavities;
  std::vector<CutPlane> cutPlanes;
  std::vector<WantedLength> lengths;  ///< where tets should be small
};

inline constexpr std::int64_t kDefaultTets = 200000;

struct DomainOptions {
  /// How many tets to aim at. Unset: as edgeLength says; both unset: kDefaultTets.
  std::optional<std::int64_t> tets;
  /// Mean edge length where nothing asks for a finer one [m]. Used where `tets` is unset.
  std::optional<double> edgeLength;
  /// How far resampled skin and bones may lie from the input, and the input from them, as a share
  /// of the diagonal of the uncut skin.
  double surfaceToleranceRel = 0.001;
  /// How fast edge lengths may grow with distance [unitless]. 0: all alike.
  double gradation = 0.15;
  /// After this the mesher is taken for hung [s].
  double workerTimeout = 300.0;
  /// Look into cacheFolder()/domains first and leave the result there.
  bool useCache = true;
};

/// How far one input surface and the domain's boundary are apart, where the input is exposed (see
/// docs/algorithms/domain.md).
struct SurfaceDeviation {
  std::string name;
  double maxFromInput = 0.0;  ///< of the input's exposed points from the domain's boundary [m]
  double meanFromInput = 0.0;
  double maxToInput = 0.0;  ///< of the domain's boundary from the input [m]
  double meanToInput = 0.0;
};

struct DomainReport {
  Findings findings;  ///< what was seen in the input, and done to it
  std::vector<SurfaceDeviation>
      deviations;             ///< skin first, then the bones that have faces in the domain
  double maxDeviation = 0.0;  ///< largest of all of them [m]
  double tolerance = 0.0;     ///< what was asked for [m]
  std::int64_t requestedTets = 0;
  std::int64_t tets = 0;
  std::int64_t vertices = 0;
  std::int64_t freeVertices = 0;
  std::int64_t boundaryFaces = 0;
  double volume = 0.0;  ///< [m³]
  double minDihedralDeg = 0.0;
  double maxDihedralDeg = 0.0;
  std::int64_t poorTets = 0;  ///< with a dihedral angle under 5°
  std::int64_t bonesUsed = 0;
  std::int64_t bonesLeftOut = 0;  ///< beyond a cut plane or outside the skin
  int wraps = 0;                  ///< clusters of bones that had to be wrapped
  int components = 0;
  std::string mesher;          ///< "TetGen" or "CGAL Mesh_3"
  bool fallback = false;       ///< TetGen refused
  std::string fallbackReason;  ///< its words
  bool fromCache = false;
};

struct DomainBuild {
  Domain domain;
  DomainReport report;
};

/// Skin minus bones, obstacles and cavities on the kept side of every cut plane, in tets fit for a
/// Laplacian.
///
/// The seven steps of docs/algorithms/domain.md: check, repair what is certain, unite, subtract and
/// clip, resample, fill with tets, verify. The same input gives the same domain to the last bit on
/// one machine.
///
/// @return  all tets positive; boundary faces tagged; a manifold (the link of every vertex is a
/// disc or a sphere);
///          every component touches skin; cut-plane vertices lie on their plane
/// @errors  MeshWithoutFaces, NonFiniteVertex, SkinNotClosed, MeshNotRepairable, BonesOutsideSkin,
/// EmptyDomain,
///          ComponentWithoutSkin, ValueOutOfRange, MeshingFailed, WorkerMissing, WorkerCrashed,
///          WorkerTimedOut, OutOfMemory, Cancelled
[[nodiscard]] Result<DomainBuild> buildDomain(const DomainInput& input,
                                              const DomainOptions& options, RunContext& run);

}  // namespace ecorche::domain
