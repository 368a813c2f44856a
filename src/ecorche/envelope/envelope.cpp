#include <ecorche/core/contract.h>
#include <ecorche/core/index.h>
#include <ecorche/core/parallel.h>
#include <ecorche/envelope/children.h>
#include <ecorche/envelope/collect.h>
#include <ecorche/envelope/diagram.h>
#include <ecorche/envelope/envelope.h>
#include <ecorche/envelope/islands.h>
#include <ecorche/envelope/placing.h>
#include <ecorche/envelope/repair.h>
#include <ecorche/envelope/splitting.h>
#include <ecorche/mesh/orientation.h>

#include <algorithm>
#include <atomic>
#include <limits>

namespace ecorche::envelope {
namespace {

/// A child thinner than this share of its parent, times clamp³, is repaired: three clamped
/// crossings around a corner leave clamp³ by themselves.
constexpr double kThinPerClamp3 = 1e-3;

void countNames(const mesh::Tets& T, const Diagram& d, EnvelopeStats& stats) {
  auto& counts = stats.tetsByTissueCount;
  counts[0] = T.rows() - static_cast<std::int64_t>(d.mixed.size());
  counts[1] = static_cast<std::int64_t>(d.mixed.size() - d.complex.size());
  for (const auto& owners : ownersOfComplexTets(d))
    ++counts[std::min(owners.size(), counts.size()) - 1];
  stats.edgePoints = static_cast<std::int64_t>(d.labelAfter.size());
  stats.facePoints = static_cast<std::int64_t>(d.facePoints.size());
  stats.tetPoints = static_cast<std::int64_t>(d.tetPoints.size());
}

void countOrientations(const Envelope& envelope, EnvelopeStats& stats) {
  std::atomic<std::int64_t> zero{0};
  std::atomic<std::int64_t> negative{0};
  std::atomic<std::int64_t> rounded{0};
  const mesh::Positions V32 = envelope.mesh.V.cast<float>().cast<double>();
  const auto sign = [&](const mesh::Positions& V, std::int64_t t) {
    const auto corner = [&](int c) {
      return mesh::Vector3(V.row(envelope.mesh.T(t, c)).transpose());
    };
    return mesh::orientation(corner(0), corner(1), corner(2), corner(3));
  };
  parallelFor(
      envelope.mesh.T.rows(),
      [&](std::int64_t t) {
        const int own = sign(envelope.mesh.V, t);
        if (own == 0) ++zero;
        if (own < 0) ++negative;
        if (sign(V32, t) <= 0) ++rounded;
      },
      8192);
  stats.zeroTets = zero;
  stats.nonPositiveTets = zero + negative;
  stats.nonPositiveRounded = rounded;
}

/// Fields at the centroid of an output tet.
void fieldsAtCentroid(const tissue::FieldMatrix& fields, const Envelope& envelope, std::int64_t t,
                      Eigen::RowVectorXd& f) {
  const auto base = static_cast<std::int32_t>(fields.rows());
  f.setZero(fields.cols());
  for (int c = 0; c < 4; ++c) {
    const std::int32_t v = envelope.mesh.T(t, c);
    if (v < base) {
      f += 0.25 * fields.row(v);
      continue;
    }
    const Anatomy::Origin& o = envelope.origin[toIndex(v - base)];
    for (std::size_t k = 0; k < 4; ++k) {
      if (o.corner[k] >= 0) f += 0.25 * o.weight[k] * fields.row(o.corner[k]);
    }
  }
}

/// Children whose label is not the largest field at their centroid.
void countOffLabel(const tissue::FieldMatrix& fields, const EnvelopeOptions& options,
                   const std::vector<TissueInTet>& struck, const Placement& placement,
                   Envelope& envelope) {
  const double tolerance = 1e-9 * std::max(0.0, fields.maxCoeff());
  const auto base = static_cast<std::int32_t>(fields.rows());
  struct Off {
    std::int32_t tet;
    bool excused;
  };
  const auto off = collect<Off>(envelope.mesh.T.rows(), [&](std::int64_t t, auto& out) {
    const std::int32_t parent = envelope.parentTet[toIndex(t)];
    const auto first = std::ranges::lower_bound(struck, TissueInTet{parent, TissueId(0)});
    const bool isStruck = first != struck.end() && first->tet == parent;
    // A tet that stayed whole has its corners' owner on top everywhere
    if (envelope.firstChild[toIndex(parent) + 1] - envelope.firstChild[toIndex(parent)] == 1 &&
        !isStruck)
      return;
    thread_local Eigen::RowVectorXd f;
    fieldsAtCentroid(fields, envelope, t, f);
    if (!options.fatIsCandidate) f[0] = -std::numeric_limits<double>::infinity();
    if (f.maxCoeff() - f[envelope.label[toIndex(t)].value - kFat.value] <= tolerance) return;
    bool excused = isStruck;
    for (int c = 0; c < 4; ++c) {
      const std::int32_t v = envelope.mesh.T(t, c);
      excused |= v >= base && placement.placed[toIndex(v - base)] != Placed::Exact;
    }
    out.push_back({static_cast<std::int32_t>(t), excused});
  });
  EnvelopeStats& stats = envelope.stats;
  stats.offLabelTets = static_cast<std::int64_t>(off.size());
  for (const Off& o : off) {
    stats.offLabelVolume += mesh::signedVolume(envelope.mesh, o.tet);
    stats.unexplainedOffLabelTets += !o.excused;
  }
}

/// The diagram, with islands struck if that is asked for.
Result<Islands> findDiagram(const mesh::TetMesh& mesh, const mesh::TetNeighbours& neighbours,
                            const tissue::FieldMatrix& fields, const EnvelopeOptions& options,
                            RunContext& run) {
  if (options.strikeIslands) {
    return strikeIslands(mesh, neighbours, fields, options.fatIsCandidate, options.seeds, run);
  }
  const Candidates all(mesh.T, static_cast<std::int32_t>(fields.cols()), options.fatIsCandidate,
                       {});
  auto diagram = computeDiagram(mesh.T, fields, all, run);
  if (!diagram) return passOn(diagram);
  Islands none;
  none.diagram = std::move(*diagram);
  return none;
}

}  // namespace

Result<Envelope> computeEnvelope(const mesh::TetMesh& mesh, const mesh::TetNeighbours& neighbours,
                                 const tissue::FieldMatrix& fields, const EnvelopeOptions& options,
                                 RunContext& run) {
  EC_REQUIRE_EQ(mesh.V.rows(), fields.rows());
  EC_REQUIRE_EQ(mesh.T.rows(), neighbours.rows());
  EC_REQUIRE(fields.cols() >= (options.fatIsCandidate ? 1 : 2));
  EC_REQUIRE(options.clamp > 0.0 && options.clamp < 0.25);
  const auto cancelled = [] {
    return fail(ErrorCode::Cancelled, "stopped while dividing the domain");
  };

  // Names
  auto islands = findDiagram(mesh, neighbours, fields, options, run);
  if (!islands) return passOn(islands);
  const Diagram& diagram = islands->diagram;

  // Tets, places
  Split split = splitTets(mesh.T, diagram);
  if (run.cancelled()) return cancelled();
  Placement placement = placeNames(mesh.T, fields, diagram,
                                   options.exact ? std::nullopt : std::optional(options.clamp));
  Envelope out;
  EnvelopeStats& stats = out.stats;
  out.mesh.V = positionsOf(mesh.V, placement.origin);
  if (!options.exact) {
    const double thin = kThinPerClamp3 * options.clamp * options.clamp * options.clamp;
    const RepairCount count =
        repairPlaces(mesh, fields, diagram, thin, split, placement, out.mesh.V);
    stats.repairedTets = count.parents;
    stats.rebuiltTets = count.rebuilt;
  }
  if (run.cancelled()) return cancelled();

  // Neighbours
  const Ancestry ancestry(mesh.T, static_cast<std::int32_t>(mesh.V.rows()), placement.origin);
  auto adjacency = linkChildren(mesh.T, neighbours, diagram, split, ancestry);
  out.neighbours = std::move(adjacency.neighbours);
  stats.unmatchedFaces = adjacency.unmatchedFaces;

  out.mesh.T = std::move(split.T);
  out.parentTet = std::move(split.parent);
  out.firstChild = std::move(split.firstChild);
  out.label.resize(split.column.size());
  for (std::size_t t = 0; t < split.column.size(); ++t)
    out.label[t] = TissueId(split.column[t] + kFat.value);
  out.origin = placement.origin;

  // What can be said about it
  countNames(mesh.T, diagram, stats);
  stats.newVertices = static_cast<std::int64_t>(out.origin.size());
  stats.clampedVertices = std::ranges::count(placement.placed, Placed::Clamped);
  stats.repairedVertices = std::ranges::count(placement.placed, Placed::Repaired);
  countOrientations(out, stats);
  stats.islands = islands->count;
  stats.keptIslands = islands->kept;
  stats.fatPockets = islands->fatPockets;
  stats.islandVolume = std::move(islands->volume);
  stats.lostTissues = std::move(islands->lost);
  countOffLabel(fields, options, islands->struck, placement, out);
  return out;
}

}  // namespace ecorche::envelope
