// Times of the envelope on a Kuhn grid of 636 k tets with 39 muscles and fat, against the least
// that could be done: one pass for the largest field at every vertex. Prints one JSON object.
//
//   bench_envelope [runs, 5] [threads, all]

#include <ecorche/core/parallel.h>
#include <ecorche/core/run_context.h>
#include <ecorche/envelope/children.h>
#include <ecorche/envelope/diagram.h>
#include <ecorche/envelope/envelope.h>
#include <ecorche/envelope/islands.h>
#include <ecorche/envelope/placing.h>
#include <ecorche/envelope/repair.h>
#include <ecorche/envelope/splitting.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <iostream>
#include <nlohmann/json.hpp>

#include "support/generated_anatomy.h"
#include "support/generated_domain.h"

using namespace ecorche;

namespace {

constexpr std::uint64_t kSeed = 7;
constexpr int kMuscles = 39;

/// Median milliseconds.
template <class Body>
double timed(int runs, const Body& body) {
  std::vector<double> ms;
  for (int r = 0; r < runs; ++r) {
    const auto begin = std::chrono::steady_clock::now();
    body();
    ms.push_back(std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin)
                     .count());
  }
  std::ranges::sort(ms);
  return ms[ms.size() / 2];
}

/// The baseline: the largest field at every vertex, one thread, no ties.
std::int64_t argmaxPass(const tissue::FieldMatrix& fields) {
  std::int64_t sum = 0;
  for (Eigen::Index v = 0; v < fields.rows(); ++v) {
    Eigen::Index best = 0;
    fields.row(v).maxCoeff(&best);
    sum += best;
  }
  return sum;
}

/// Where every muscle is the largest, as if its curve ran there.
std::vector<envelope::TissueInTet> tetsAtMaxima(const mesh::TetMesh& mesh,
                                                const tissue::FieldMatrix& fields) {
  std::vector<envelope::TissueInTet> seeds;
  for (Eigen::Index column = 1; column < fields.cols(); ++column) {
    std::int32_t highest = 0;
    fields.col(column).maxCoeff(&highest);
    for (std::int32_t t = 0; t < mesh.T.rows(); ++t) {
      if ((mesh.T.row(t).array() == highest).any()) {
        seeds.push_back({t, TissueId(static_cast<std::int32_t>(column) + kFat.value)});
      }
    }
  }
  return seeds;
}

nlohmann::json bench(const std::string& name, const Eigen::Array3i& cells, int runs) {
  const domain::Domain domain = test::boxDomain({.cells = cells});
  const tissue::FieldMatrix fields = test::benchFields(domain.mesh.V, kMuscles, kSeed);
  const envelope::EnvelopeOptions options{.strikeIslands = false};
  const auto seeds = tetsAtMaxima(domain.mesh, fields);
  RunContext run;

  std::int64_t keep = 0;
  const double argmax = timed(runs, [&] { keep += argmaxPass(fields); });
  nlohmann::json metrics;
  metrics["argmax_ms"] = argmax;
  envelope::EnvelopeStats stats;
  const double total = timed(runs, [&] {
    stats = envelope::computeEnvelope(domain.mesh, domain.neighbours, fields, options, run)->stats;
  });
  metrics["p50_ms"] = total;
  metrics["islands_too_ms"] = timed(std::min(runs, 3), [&] {
    (void)envelope::strikeIslands(domain.mesh, domain.neighbours, fields, true, seeds, run);
  });

  // The stages by themselves
  const envelope::Candidates candidates(domain.mesh.T, kMuscles + 1, true, {});
  envelope::Diagram diagram;
  metrics["diagram_ms"] = timed(
      runs, [&] { diagram = *envelope::computeDiagram(domain.mesh.T, fields, candidates, run); });
  envelope::Split split;
  metrics["split_ms"] = timed(runs, [&] { split = envelope::splitTets(domain.mesh.T, diagram); });
  envelope::Placement placement;
  metrics["place_ms"] = timed(runs, [&] {
    placement = envelope::placeNames(domain.mesh.T, fields, diagram, options.clamp);
  });
  mesh::Positions V = envelope::positionsOf(domain.mesh.V, placement.origin);
  metrics["check_and_repair_ms"] = timed(runs, [&] {
    auto s = split;
    auto p = placement;
    envelope::repairPlaces(domain.mesh, fields, diagram, 1e-12, s, p, V);
  });
  metrics["neighbours_ms"] = timed(runs, [&] {
    const envelope::Ancestry ancestry(
        domain.mesh.T, static_cast<std::int32_t>(domain.mesh.V.rows()), placement.origin);
    (void)envelope::linkChildren(domain.mesh.T, domain.neighbours, diagram, split, ancestry);
  });

  metrics["tets_out"] = split.T.rows();
  metrics["new_vertices"] = stats.newVertices;
  metrics["face_points"] = stats.facePoints;
  metrics["tet_points"] = stats.tetPoints;
  metrics["tets_by_tissue_count"] = stats.tetsByTissueCount;
  metrics["clamped_vertices"] = stats.clampedVertices;
  metrics["repaired_vertices"] = stats.repairedVertices;
  metrics["non_positive_tets"] = stats.nonPositiveTets;
  metrics["non_positive_at_32_bits"] = stats.nonPositiveRounded;
  metrics["peak_memory_mb"] = static_cast<double>(peakMemory()) / 1e6;
  metrics["min_dihedral_deg"] = mesh::dihedralRangeDeg({V, split.T}).col(0).minCoeff();
  return {{"name", name},
          {"tets", domain.mesh.T.rows()},
          {"muscles", kMuscles},
          {"threads", threadCount()},
          {"metrics", metrics},
          {"ratios", {{"vs_argmax_pass", total / argmax}}},
          {"errors",
           {{"off_label_share", stats.offLabelVolume / domain.volume},
            {"unmatched_faces", stats.unmatchedFaces},
            {"checksum", keep % 1000}}}};
}

}  // namespace

int main(int argc, char** argv) {
  const int runs = argc > 1 ? std::max(1, std::atoi(argv[1])) : 5;
  const ThreadLimit limit(argc > 2 ? std::atoi(argv[2]) : 0);
  const nlohmann::json out = {
      {"bench", "envelope"},
      {"cases", {bench("79k", {24, 24, 23}, runs), bench("636k", {47, 47, 48}, runs)}}};
  std::cout << out.dump(2) << "\n";
}
