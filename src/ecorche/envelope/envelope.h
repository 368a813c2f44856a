#pragma once

#include <ecorche/core/ids.h>
#include <ecorche/core/result.h>
#include <ecorche/core/run_context.h>
#include <ecorche/envelope/anatomy.h>
#include <ecorche/tissue/tissue_fields.h>

#include <array>
#include <vector>

namespace ecorche::envelope {

/// A tissue in a tet.
struct TissueInTet {
  std::int32_t tet = -1;
  TissueId tissue;
  auto operator<=>(const TissueInTet&) const = default;
};

struct EnvelopeOptions {
  /// How close to an edge's end, and to one another, crossings may lie [share of the edge].
  /// Positions only.
  double clamp = 1e-3;
  /// Keep raw places, count what has no volume, repair nothing.
  bool exact = false;
  /// Fat (column 0) takes part.
  bool fatIsCandidate = true;
  /// Strike islands: face-connected cells of one muscle that hold none of `seeds`. Fat pockets
  /// stay.
  bool strikeIslands = true;
  /// Tets in which a tissue's curve runs through the tissue itself.
  std::vector<TissueInTet> seeds;
};

struct EnvelopeStats {
  std::array<std::int64_t, 6>
      tetsByTissueCount{};  ///< domain tets with 1, 2, 3, 4, 5, 6 or more tissues
  std::int64_t newVertices = 0;
  std::int64_t clampedVertices = 0;   ///< moved off their exact place by clamping
  std::int64_t repairedVertices = 0;  ///< moved again because a tet had no positive volume
  std::int64_t nonPositiveTets = 0;   ///< left after repair; always 0 unless EnvelopeOptions::exact
  std::int64_t offLabelTets =
      0;  ///< label's field below the largest at the centroid by more than 1e-9 of the maximum
  double offLabelVolume = 0.0;  ///< of those [m³]: clamped, repaired, and islands
  std::int64_t unexplainedOffLabelTets =
      0;                     ///< of those, in parents with nothing clamped, repaired or struck: 0
  std::int64_t islands = 0;  ///< components struck
  std::int64_t fatPockets = 0;       ///< components of fat beyond the largest; they stay
  std::vector<double> islandVolume;  ///< per tissue id, upper bound: volume of the tets struck,
                                     ///< weighted by their cells [m³]
};

struct Envelope {
  mesh::TetMesh mesh;                   ///< domain vertices first
  std::vector<TissueId> label;          ///< #T
  std::vector<std::int32_t> parentTet;  ///< #T
  std::vector<Anatomy::Origin> origin;  ///< new vertices
  EnvelopeStats stats;
};

/// Subdivides tets by the largest field (maximisation diagram) [ABLSJ21 §4],
/// docs/algorithms/envelope.md.
///
/// Which tissue lies where is decided exactly, ties by ownerOf's rule; new vertices carry names, so
/// neighbours agree whatever order tets are visited in. The same bytes for any number of threads.
///
/// @param mesh    positively oriented tets
/// @param fields  #V×#fields, column j is tissue id j + 1
/// @return  conforming, positively oriented tets that fill the input exactly; every label's tets
/// form a manifold
///          where the input is one
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
[[nodiscard]] Result<AnatomyBuild> buildAnatomy(const domain::Domain& domain,
                                                const tissue::TissueFields& fields,
                                                const tissue::CoreSamples& cores,
                                                const EnvelopeOptions& options, RunContext& run);

}  // namespace ecorche::envelope
