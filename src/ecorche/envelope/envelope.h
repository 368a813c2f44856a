#pragma once

#include <ecorche/core/ids.h>
#include <ecorche/core/result.h>
#include <ecorche/core/run_context.h>
#include <ecorche/envelope/anatomy.h>
#include <ecorche/envelope/tissue_in_tet.h>
#include <ecorche/tissue/tissue_fields.h>

#include <array>
#include <vector>

namespace ecorche::envelope {

struct EnvelopeOptions {
  /// How far from the boundary of its edge, face or tet a new vertex stays, as weight, and from the
  /// next crossing of its edge. Positions only. In (0, 0.25).
  double clamp = 1e-3;
  /// Keep raw places, count what has no volume, repair nothing.
  bool exact = false;
  /// Fat (column 0) takes part.
  bool fatIsCandidate = true;
  /// Strike islands: face-connected cells of one muscle that hold none of `seeds` (islands.h). Fat
  /// pockets stay.
  bool strikeIslands = true;
  /// Tets through which a tissue's curve runs.
  std::vector<TissueInTet> seeds;
};

struct EnvelopeStats {
  std::array<std::int64_t, 6>
      tetsByTissueCount{};  ///< domain tets with 1, 2, 3, 4, 5, 6 or more tissues
  std::int64_t newVertices = 0;
  std::int64_t edgePoints = 0;          ///< of the new vertices: two tissues meet on an edge
  std::int64_t facePoints = 0;          ///< three on a face
  std::int64_t tetPoints = 0;           ///< four in a tet
  std::int64_t clampedVertices = 0;     ///< moved off their exact place by clamping
  std::int64_t repairedVertices = 0;    ///< moved again because a tet had no positive volume
  std::int64_t repairedTets = 0;        ///< domain tets that needed it
  std::int64_t rebuiltTets = 0;         ///< of those, cut anew because moving was not enough
  std::int64_t zeroTets = 0;            ///< exact volume 0
  std::int64_t nonPositiveTets = 0;     ///< those and the negative ones
  std::int64_t nonPositiveRounded = 0;  ///< the same if coordinates are stored in 32 bits
  std::int64_t unmatchedFaces = 0;      ///< neither shared nor on the boundary: 0
  /// Label's field below the largest at the centroid by more than 1e-9 of the maximum.
  std::int64_t offLabelTets = 0;
  double offLabelVolume = 0.0;  ///< of those [m³]: clamped, repaired, and islands
  std::int64_t unexplainedOffLabelTets =
      0;                         ///< of those, with nothing clamped, repaired or struck: 0
  std::int64_t islands = 0;      ///< components struck
  std::int64_t keptIslands = 0;  ///< components that stay because nothing else could own their tets
  std::int64_t fatPockets = 0;   ///< components of fat beyond the first; they stay
  std::vector<double> islandVolume;  ///< per tissue id: volume it lost as islands [m³]
  /// Tissues left with nothing because no part of them holds one of their curves.
  std::vector<TissueId> lostTissues;
};

struct Envelope {
  mesh::TetMesh mesh;                    ///< domain vertices first; children in order of parents
  mesh::TetNeighbours neighbours;        ///< #T×4
  std::vector<TissueId> label;           ///< #T
  std::vector<std::int32_t> parentTet;   ///< #T
  std::vector<std::int32_t> firstChild;  ///< #T(domain) + 1
  std::vector<Anatomy::Origin> origin;   ///< new vertices
  EnvelopeStats stats;
};

/// Subdivides tets by the largest field (maximisation diagram) [ABLSJ21 §4],
/// docs/algorithms/envelope.md.
///
/// Which tissue lies where is decided exactly, ties by ownerOf's rule; new vertices carry names, so
/// neighbours agree whatever order tets are visited in. The same bytes for any number of threads.
///
/// @param mesh        positively oriented tets
/// @param neighbours  as mesh::tetAdjacency gives them
/// @param fields      #V×#fields, column j is tissue id j + 1
/// @return  conforming, positively oriented tets that fill the input exactly; every label's tets
/// form a manifold where the input is one
/// @errors  NonFiniteField (tissue and vertex), Cancelled
[[nodiscard]] Result<Envelope> computeEnvelope(const mesh::TetMesh& mesh,
                                               const mesh::TetNeighbours& neighbours,
                                               const tissue::FieldMatrix& fields,
                                               const EnvelopeOptions& options, RunContext& run);

/// The same for a domain, with boundary faces and their tags carried over.
struct AnatomyBuild {
  Anatomy anatomy;
  EnvelopeStats stats;
};

/// Checks what it promises: faces matched, volume and the area of every boundary tag kept to 1e-9.
/// @param cores  give the seeds of islands, added to options.seeds
/// @errors  those above; CheckFailed where a promise is broken, naming it
[[nodiscard]] Result<AnatomyBuild> buildAnatomy(const domain::Domain& domain,
                                                const tissue::TissueFields& fields,
                                                const tissue::CoreSamples& cores,
                                                const EnvelopeOptions& options, RunContext& run);

}  // namespace ecorche::envelope
