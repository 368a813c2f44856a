#include <ecorche/core/contract.h>
#include <ecorche/core/parallel.h>
#include <ecorche/fiber/curve_tets.h>
#include <ecorche/fiber/fiber_ends.h>
#include <ecorche/fiber/fiber_field.h>
#include <ecorche/fiber/fiber_trace.h>
#include <ecorche/fiber/flow_potential.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace ecorche::fiber {

using mesh::Vector3;

namespace {

// Everything about one muscle, with its own numbering, before it is merged into the field.
struct MuscleResult {
  MuscleMesh muscle;
  mesh::Directions tetFiber;
  mesh::Directions vertexFiber;
  std::vector<double> vertexVolume;  // of the muscle's tets around a vertex
  std::vector<double> flow;          // per tet
  MuscleFibers figures;
  Findings findings;
};

// Directions from gradients. Where there is none, neighbours lend theirs, ring by ring; returns
// those tets.
std::vector<std::uint8_t> normaliseAndSpread(MuscleResult& r, const FlowPotential& flow,
                                             const SelectedEnds& ends, const CurveGuide& guide,
                                             const std::vector<CurveGuide::Nearest>& nearest) {
  const MuscleMesh& m = r.muscle;
  const auto tetCount = m.mesh.T.rows();
  double length = 0.0;
  for (std::int32_t c = 0; c < guide.curveCount(); ++c) length = std::max(length, guide.length(c));
  // Below this the gradient is rounding: u is known to about 1e-13 and tets are a hundredth of the
  // length
  const double least = 1e-9 / length;

  r.tetFiber.setZero(tetCount, 3);
  std::vector<std::uint8_t> lent(static_cast<std::size_t>(tetCount), 0);
  std::vector<std::int32_t> open;
  for (Eigen::Index t = 0; t < tetCount; ++t) {
    const auto i = static_cast<std::size_t>(t);
    const double norm = flow.gradient.row(t).norm();
    if (ends.unended[static_cast<std::size_t>(m.component[i])]) {
      r.tetFiber.row(t) = nearest[i].tangent.transpose();
      lent[i] = 1;
    } else if (norm > least) {
      r.tetFiber.row(t) = flow.gradient.row(t) / norm;
    } else {
      lent[i] = 1;
      open.push_back(static_cast<std::int32_t>(t));
    }
  }

  while (!open.empty()) {
    std::vector<std::int32_t> later;
    std::vector<std::pair<std::int32_t, Vector3>> found;
    for (const std::int32_t t : open) {
      Vector3 sum = Vector3::Zero();
      for (int k = 0; k < 4; ++k) {
        const std::int32_t n = m.neighbours(t, k);
        if (n >= 0) sum += m.volume[n] * r.tetFiber.row(n).transpose();
      }
      if (sum.norm() > 0.0) {
        found.emplace_back(t, sum.normalized());
      } else {
        later.push_back(t);
      }
    }
    if (found.empty()) {
      for (const std::int32_t t : later) {
        r.tetFiber.row(t) = nearest[static_cast<std::size_t>(t)].tangent.transpose();
      }
      break;
    }
    for (const auto& [t, direction] : found) r.tetFiber.row(t) = direction.transpose();
    open = std::move(later);
  }
  return lent;
}

// Volume-weighted mean of the tets around; where they cancel, the largest of them.
void averageAtVertices(MuscleResult& r) {
  const MuscleMesh& m = r.muscle;
  r.vertexFiber.setZero(m.mesh.V.rows(), 3);
  r.vertexVolume.assign(m.vertexId.size(), 0.0);
  std::vector<std::int32_t> largest(m.vertexId.size(), -1);
  for (Eigen::Index t = 0; t < m.mesh.T.rows(); ++t) {
    for (int k = 0; k < 4; ++k) {
      const auto v = static_cast<std::size_t>(m.mesh.T(t, k));
      r.vertexFiber.row(static_cast<Eigen::Index>(v)) += m.volume[t] * r.tetFiber.row(t);
      r.vertexVolume[v] += m.volume[t];
      if (largest[v] < 0 || m.volume[t] > m.volume[largest[v]])
        largest[v] = static_cast<std::int32_t>(t);
    }
  }
  for (std::size_t v = 0; v < m.vertexId.size(); ++v) {
    const auto row = static_cast<Eigen::Index>(v);
    const double norm = r.vertexFiber.row(row).norm();
    if (norm > 1e-6 * r.vertexVolume[v] && norm > 0.0) {
      r.vertexFiber.row(row) /= norm;
    } else {
      r.vertexFiber.row(row) = r.tetFiber.row(largest[v]);
    }
  }
}

std::int64_t countInteriorExtrema(const MuscleMesh& m, const Eigen::VectorXd& u,
                                  const SelectedEnds& ends) {
  std::vector<double> lowest(m.vertexId.size(), std::numeric_limits<double>::infinity());
  std::vector<double> highest(m.vertexId.size(), -std::numeric_limits<double>::infinity());
  std::vector<std::uint8_t> counts(m.vertexId.size(), 0);
  for (Eigen::Index t = 0; t < m.mesh.T.rows(); ++t) {
    const bool unended =
        ends.unended[static_cast<std::size_t>(m.component[static_cast<std::size_t>(t)])];
    for (int a = 0; a < 4; ++a) {
      const auto v = static_cast<std::size_t>(m.mesh.T(t, a));
      counts[v] = !unended && !ends.attached[v];
      for (int b = 0; b < 4; ++b) {
        if (a == b) continue;
        lowest[v] = std::min(lowest[v], u[m.mesh.T(t, b)]);
        highest[v] = std::max(highest[v], u[m.mesh.T(t, b)]);
      }
    }
  }
  std::int64_t count = 0;
  for (std::size_t v = 0; v < counts.size(); ++v) {
    const double value = u[static_cast<Eigen::Index>(v)];
    count += counts[v] && (value < lowest[v] || value > highest[v]);
  }
  return count;
}

void measureAngles(MuscleResult& r, const tissue::CurveTissue& tissue, const CurveGuide& guide,
                   const std::vector<CurveGuide::Nearest>& nearest) {
  // Curves run through a tet only where they come as near to its centroid as its farthest corner;
  // the guide's poly-line is a little off the curve
  std::vector<std::int32_t> close;
  for (std::size_t t = 0; t < nearest.size(); ++t) {
    const auto row = static_cast<Eigen::Index>(t);
    const Vector3 centre = r.muscle.centroid(row);
    double reach = 0.0;
    for (int k = 0; k < 4; ++k) {
      const Vector3 corner = r.muscle.mesh.V.row(r.muscle.mesh.T(row, k)).transpose();
      reach = std::max(reach, (corner - centre).norm());
    }
    const double slack = 0.01 * guide.length(nearest[t].curve);
    if (nearest[t].distance <= reach + slack) close.push_back(static_cast<std::int32_t>(t));
  }
  double sum = 0.0;
  for (const auto& curve : tissue.curves) {
    const auto line = curve.spline.sample(curve.spline.length() / 200).point;
    for (const TetOnCurve& hit : tetsOnCurve(r.muscle.mesh, close, line)) {
      const double cosine =
          std::clamp(r.tetFiber.row(hit.tet).dot(hit.tangent.transpose()), -1.0, 1.0);
      sum += std::acos(cosine) * 180.0 / std::numbers::pi;
      ++r.figures.curveTets;
    }
  }
  if (r.figures.curveTets > 0)
    r.figures.angleToCurveDeg = sum / static_cast<double>(r.figures.curveTets);
}

void traceLengths(MuscleResult& r, const Eigen::VectorXd& progress, const SelectedEnds& ends,
                  const CurveGuide& guide, const FiberOptions& options) {
  if (options.tracedCount <= 0) return;
  double length = 0.0;
  for (std::int32_t c = 0; c < guide.curveCount(); ++c) length = std::max(length, guide.length(c));
  TracedFibers traced =
      traceFibers(r.muscle, progress, r.vertexFiber, ends.attached, options.tracedCount,
                  length / 100, options.tendonShare.value_or(0.0));
  const auto count = static_cast<double>(traced.length.size());
  if (traced.length.empty()) return;
  for (const double l : traced.length) r.figures.fiberLength += l / count;
  double variance = 0.0;
  for (const double l : traced.length) variance += std::pow(l - r.figures.fiberLength, 2) / count;
  r.figures.fiberLengthSd = std::sqrt(variance);
  r.figures.lines = std::move(traced.lines);
}

Result<MuscleResult> computeMuscle(const envelope::Anatomy& anatomy, const domain::Domain& domain,
                                   const tissue::CurveTissue& tissue, const MuscleEnds& muscleEnds,
                                   MuscleMesh muscle, const FiberOptions& options) {
  MuscleResult r;
  r.muscle = std::move(muscle);
  const MuscleMesh& m = r.muscle;
  r.figures.tissue = m.tissue;
  r.figures.name = tissue.name;
  r.figures.tetCount = m.mesh.T.rows();
  r.figures.vertexCount = m.mesh.V.rows();

  // How thick the muscle is along its curves tells how wide tubes and attachments are
  CurveGuide guide(tissue);
  std::vector<CurveGuide::Nearest> nearest(m.tetId.size());
  for (std::size_t t = 0; t < nearest.size(); ++t)
    nearest[t] = guide.nearest(m.centroid(static_cast<std::int64_t>(t)));
  guide.measureThickness(m, nearest);

  auto ends = selectEnds(m, guide, anatomy.boundaryTag, tissue, muscleEnds, options);
  if (!ends) return passOn(ends);
  auto flow = solveFlow(m, anatomy, domain, *ends, guide, nearest, options, tissue.name);
  if (!flow) return passOn(flow);

  const std::vector<std::uint8_t> lent = normaliseAndSpread(r, *flow, *ends, guide, nearest);
  averageAtVertices(r);
  const Eigen::VectorXd progress = progressAlongHeads(m, *ends, guide, flow->u);
  r.flow.resize(m.tetId.size());
  double lentVolume = 0.0;
  for (std::size_t t = 0; t < r.flow.size(); ++t) {
    double sum = 0.0;
    for (int k = 0; k < 4; ++k) sum += progress[m.mesh.T(static_cast<Eigen::Index>(t), k)];
    // Where nothing flows, arc length tells
    const bool unended = ends->unended[static_cast<std::size_t>(m.component[t])];
    r.flow[t] = unended ? nearest[t].arc / guide.length(nearest[t].curve) : 0.25 * sum;
    r.figures.spreadTets += lent[t];
    if (lent[t]) lentVolume += m.volume[static_cast<Eigen::Index>(t)];
  }
  r.figures.spreadVolumeShare = lentVolume / m.volume.sum();
  r.figures.origins = ends->origins;
  r.figures.insertions = ends->insertions;
  r.figures.interiorExtrema = countInteriorExtrema(m, flow->u, *ends);
  measureAngles(r, tissue, guide, nearest);
  traceLengths(r, progress, *ends, guide, options);

  r.findings = std::move(ends->findings);
  if (r.figures.spreadTets > 0) {
    r.findings.push_back(
        {Severity::Note, "fibers-spread", tissue.name,
         fmt::format("{} of {} tets of \"{}\" ({:.2g} % of its volume) have no flow of "
                     "their own and take their neighbours' direction",
                     r.figures.spreadTets, r.figures.tetCount, tissue.name,
                     100.0 * r.figures.spreadVolumeShare),
         std::nullopt, lentVolume});
  }
  return r;
}

// Muscles follow one another by id, so an interface vertex has the same owner whatever thread was
// faster.
void merge(FiberField& field, std::vector<double>& bestVolume, MuscleResult&& r,
           const FiberOptions& options) {
  for (std::size_t t = 0; t < r.muscle.tetId.size(); ++t) {
    const auto id = static_cast<std::size_t>(r.muscle.tetId[t]);
    field.tetFiber.row(r.muscle.tetId[t]) = r.tetFiber.row(static_cast<Eigen::Index>(t));
    field.flow[id] = r.flow[t];
    if (options.tendonShare) {
      field.tendon[id] = r.flow[t] < *options.tendonShare || r.flow[t] > 1.0 - *options.tendonShare;
    }
  }
  for (std::size_t v = 0; v < r.muscle.vertexId.size(); ++v) {
    double& best = bestVolume[static_cast<std::size_t>(r.muscle.vertexId[v])];
    if (r.vertexVolume[v] <= best) continue;
    best = r.vertexVolume[v];
    field.vertexFiber.row(r.muscle.vertexId[v]) = r.vertexFiber.row(static_cast<Eigen::Index>(v));
  }
  field.findings.insert(field.findings.end(), r.findings.begin(), r.findings.end());
  field.muscles.push_back(std::move(r.figures));
}

}  // namespace

Result<FiberField> computeFibers(const envelope::Anatomy& anatomy, const domain::Domain& domain,
                                 const std::vector<tissue::CurveTissue>& tissues,
                                 const std::vector<MuscleEnds>& ends, const FiberOptions& options,
                                 RunContext& run) {
  EC_REQUIRE_EQ(ends.size(), tissues.size());
  EC_REQUIRE_EQ(anatomy.label.size(), static_cast<std::size_t>(anatomy.mesh.T.rows()));
  EC_REQUIRE(!options.tendonShare || (*options.tendonShare > 0.0 && *options.tendonShare < 0.5));
  const Stage stage(run, "fibres");

  const auto tets = tetsByTissue(anatomy);
  const auto placeInTissue = placesInTissue(tets, anatomy.label.size());
  const auto boundaryOf = boundaryOfSlot(anatomy);
  std::vector<std::size_t> muscles;
  for (std::size_t i = 0; i < tissues.size(); ++i) {
    const std::size_t id = static_cast<std::size_t>(kFirstMuscle.value) + i;
    if (!tissues[i].filler && id < tets.size() && !tets[id].empty()) muscles.push_back(i);
  }

  std::vector<Result<MuscleResult>> results(muscles.size(), MuscleResult{});
  std::atomic<std::size_t> done{0};
  parallelFor(
      static_cast<std::int64_t>(muscles.size()),
      [&](std::int64_t k) {
        if (run.cancelled()) return;
        const std::size_t i = muscles[static_cast<std::size_t>(k)];
        const TissueId id{kFirstMuscle.value + static_cast<std::int64_t>(i)};
        results[static_cast<std::size_t>(k)] =
            computeMuscle(anatomy, domain, tissues[i], ends[i],
                          extractMuscle(anatomy, id, tets[static_cast<std::size_t>(id.value)],
                                        placeInTissue, boundaryOf),
                          options);
        run.progress("fibres", static_cast<double>(++done) / static_cast<double>(muscles.size()));
      },
      1);
  if (run.cancelled()) return fail(ErrorCode::Cancelled, "fibres");

  FiberField field;
  field.tetFiber.setZero(anatomy.mesh.T.rows(), 3);
  field.vertexFiber.setZero(anatomy.mesh.V.rows(), 3);
  field.flow.assign(anatomy.label.size(), std::numeric_limits<double>::quiet_NaN());
  if (options.tendonShare) field.tendon.assign(anatomy.label.size(), 0);
  std::vector<double> bestVolume(static_cast<std::size_t>(anatomy.mesh.V.rows()), 0.0);
  for (auto& result : results) {
    if (!result) return passOn(result);
    merge(field, bestVolume, std::move(*result), options);
  }
  return field;
}

}  // namespace ecorche::fiber
