#include <ecorche/core/contract.h>
#include <ecorche/core/parallel.h>
#include <ecorche/envelope/envelope.h>
#include <ecorche/envelope/placement.h>
#include <ecorche/envelope/split_tets.h>
#include <ecorche/mesh/orientation.h>
#include <fmt/format.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <atomic>
#include <numeric>

namespace ecorche::envelope {

namespace {

// Edge names first, then faces, then tets; ascending within each
bool namesInOrder(const VertexName& a, const VertexName& b) {
  const int ca = a.count();
  const int cb = b.count();
  return ca != cb ? ca < cb : a < b;
}

// Numbers all names; the numbers depend on names alone, not on the order of visits
std::vector<VertexName> numberNames(CellComplex& cells, std::int32_t offset) {
  std::vector<VertexName> names;
  std::size_t total = 0;
  for (const SplitTet& split : cells.split) total += split.names.size();
  names.reserve(total);
  for (const SplitTet& split : cells.split)
    names.insert(names.end(), split.names.begin(), split.names.end());
  tbb::parallel_sort(names.begin(), names.end(), namesInOrder);
  names.erase(std::unique(names.begin(), names.end()), names.end());
  parallelFor(
      static_cast<std::int64_t>(cells.split.size()),
      [&](std::int64_t s) {
        SplitTet& split = cells.split[static_cast<std::size_t>(s)];
        split.id.clear();
        for (const VertexName& name : split.names) {
          const auto at = std::lower_bound(names.begin(), names.end(), name, namesInOrder);
          split.id.push_back(offset + static_cast<std::int32_t>(at - names.begin()));
        }
      },
      256);
  return names;
}

// Pulls every cell from its vertex of lowest number, every face from its own: neighbours split
// shared faces alike. emit(column, a, b, c, d) receives positively oriented tets.
template <class Emit>
void pullCells(const SplitTet& split, const mesh::Tets& T, const Emit& emit) {
  for (const auto& cell : split.cells) {
    std::int32_t apex = std::numeric_limits<std::int32_t>::max();
    for (const auto& face : cell.faces) {
      for (const std::int16_t v : face.loop) apex = std::min(apex, split.vertex(T, v));
    }
    for (const auto& face : cell.faces) {
      std::size_t low = 0;
      bool touches = false;
      for (std::size_t k = 0; k < face.loop.size(); ++k) {
        const std::int32_t v = split.vertex(T, face.loop[k]);
        touches = touches || v == apex;
        if (v < split.vertex(T, face.loop[low])) low = k;
      }
      if (touches) continue;
      const std::size_t n = face.loop.size();
      for (std::size_t k = 1; k + 1 < n; ++k) {
        emit(cell.column, apex, split.vertex(T, face.loop[low]),
             split.vertex(T, face.loop[(low + k) % n]),
             split.vertex(T, face.loop[(low + k + 1) % n]));
      }
    }
  }
}

void fillTets(const mesh::TetMesh& mesh, const CellComplex& cells, Envelope& out) {
  const auto tetCount = mesh.T.rows();
  std::vector<std::int64_t> first(static_cast<std::size_t>(tetCount) + 1, 0);
  parallelFor(tetCount, [&](std::int64_t t) {
    const std::int32_t s = cells.splitOf[static_cast<std::size_t>(t)];
    std::int64_t count = s < 0 ? 1 : 0;
    if (s >= 0) {
      pullCells(cells.split[static_cast<std::size_t>(s)], mesh.T, [&](auto...) { ++count; });
    }
    first[static_cast<std::size_t>(t) + 1] = count;
  });
  std::partial_sum(first.begin(), first.end(), first.begin());
  out.mesh.T.resize(first.back(), 4);
  out.label.resize(static_cast<std::size_t>(first.back()));
  out.parentTet.resize(out.label.size());
  parallelFor(tetCount, [&](std::int64_t t) {
    std::int64_t at = first[static_cast<std::size_t>(t)];
    const auto put = [&](std::int16_t column, std::int32_t a, std::int32_t b, std::int32_t c,
                         std::int32_t d) {
      out.mesh.T.row(at) << a, b, c, d;
      out.label[static_cast<std::size_t>(at)] = TissueId(column + 1);
      out.parentTet[static_cast<std::size_t>(at)] = static_cast<std::int32_t>(t);
      ++at;
    };
    const std::int32_t s = cells.splitOf[static_cast<std::size_t>(t)];
    if (s < 0) {
      put(cells.owner[static_cast<std::size_t>(t)], mesh.T(t, 0), mesh.T(t, 1), mesh.T(t, 2),
          mesh.T(t, 3));
    } else {
      pullCells(cells.split[static_cast<std::size_t>(s)], mesh.T, put);
    }
  });
}

void fillVertices(const mesh::TetMesh& mesh, const Placement& placement, mesh::Positions& V) {
  V.resize(mesh.V.rows() + static_cast<Eigen::Index>(placement.names().size()), 3);
  V.topRows(mesh.V.rows()) = mesh.V;
  parallelFor(static_cast<std::int64_t>(placement.names().size()), [&](std::int64_t n) {
    V.row(mesh.V.rows() + n) = placement.position(static_cast<std::size_t>(n)).transpose();
  });
}

// Split tets that hold an output tet without positive volume, ascending
std::vector<std::int32_t> badSplits(const Envelope& out, const CellComplex& cells,
                                    std::int64_t& badTets) {
  std::vector<std::uint8_t> bad(cells.split.size(), 0);
  std::atomic<std::int64_t> count{0};
  parallelFor(out.mesh.T.rows(), [&](std::int64_t t) {
    const std::int32_t s =
        cells.splitOf[static_cast<std::size_t>(out.parentTet[static_cast<std::size_t>(t)])];
    if (s < 0 || mesh::orientation(out.mesh, t) > 0) return;
    bad[static_cast<std::size_t>(s)] = 1;  // several writers, one value
    count.fetch_add(1, std::memory_order_relaxed);
  });
  badTets = count.load();
  std::vector<std::int32_t> list;
  for (std::size_t s = 0; s < bad.size(); ++s) {
    if (bad[s] != 0) list.push_back(static_cast<std::int32_t>(s));
  }
  return list;
}

// Output tets whose label is not the largest field at the centroid, to 1e-9 of the largest value
// anywhere
void countOffLabel(const mesh::TetMesh& mesh, const tissue::FieldMatrix& fields,
                   const CellComplex& cells, const Placement& placement,
                   const EnvelopeOptions& options, Envelope& out) {
  const double tolerance = 1e-9 * std::max(0.0, fields.size() > 0 ? fields.maxCoeff() : 0.0);
  const auto offset = static_cast<std::int32_t>(mesh.V.rows());
  std::vector<double> volume(static_cast<std::size_t>(out.mesh.T.rows()), 0.0);
  std::vector<std::uint8_t> kind(volume.size(), 0);
  parallelFor(out.mesh.T.rows(), [&](std::int64_t t) {
    const auto parent = out.parentTet[static_cast<std::size_t>(t)];
    const std::int32_t s = cells.splitOf[static_cast<std::size_t>(parent)];
    if (s < 0) return;
    Eigen::RowVectorXd f = Eigen::RowVectorXd::Zero(fields.cols());
    bool excused = cells.split[static_cast<std::size_t>(s)].struck;
    for (int c = 0; c < 4; ++c) {
      const std::int32_t v = out.mesh.T(t, c);
      if (v < offset) {
        f += 0.25 * fields.row(v);
        continue;
      }
      const Anatomy::Origin& o = placement.origins()[static_cast<std::size_t>(v - offset)];
      for (std::size_t k = 0; k < 4; ++k) {
        if (o.corner[k] >= 0) f += 0.25 * o.weight[k] * fields.row(o.corner[k]);
      }
      excused = excused ||
                placement.moved()[static_cast<std::size_t>(v - offset)] != Placement::Moved::No;
    }
    if (!options.fatIsCandidate) f[0] = -std::numeric_limits<double>::infinity();
    const double own = f[out.label[static_cast<std::size_t>(t)].value - 1];
    if (f.maxCoeff() - own <= tolerance) return;
    volume[static_cast<std::size_t>(t)] = mesh::signedVolume(out.mesh, t);
    kind[static_cast<std::size_t>(t)] = excused ? 1 : 2;
  });
  for (std::size_t t = 0; t < kind.size(); ++t) {
    if (kind[t] == 0) continue;
    ++out.stats.offLabelTets;
    out.stats.offLabelVolume += volume[t];
    out.stats.unexplainedOffLabelTets += kind[t] == 2;
  }
}

}  // namespace

Result<Envelope> computeEnvelope(const mesh::TetMesh& mesh, const mesh::TetNeighbours& neighbours,
                                 const tissue::FieldMatrix& fields, const EnvelopeOptions& options,
                                 RunContext& run) {
  EC_REQUIRE_EQ(mesh.V.rows(), fields.rows());
  EC_REQUIRE_EQ(mesh.T.rows(), neighbours.rows());
  EC_REQUIRE(fields.cols() >= (options.fatIsCandidate ? 1 : 2) && fields.cols() < 32000);
  auto cells = buildCells(mesh, neighbours, fields, options, run);
  if (!cells) return passOn(cells);

  Placement placement(mesh, fields, numberNames(*cells, static_cast<std::int32_t>(mesh.V.rows())),
                      options);
  Envelope out;
  fillVertices(mesh, placement, out.mesh.V);
  fillTets(mesh, *cells, out);
  if (run.cancelled()) return fail(ErrorCode::Cancelled, "stopped while filling the envelope");

  // Positions are doubles and exact ties have no room: move what stands in the way until every tet
  // has volume
  std::vector<std::int32_t> bad = badSplits(out, *cells, out.stats.nonPositiveTets);
  if (!options.exact) {
    for (int round = 0; round < 6 && !bad.empty(); ++round) {
      placement.relax(cells->split, bad, round == 0 ? 0.5 : 1.0, round >= 2);
      fillVertices(mesh, placement, out.mesh.V);
      bad = badSplits(out, *cells, out.stats.nonPositiveTets);
    }
  }

  out.origin = placement.origins();
  out.stats.newVertices = static_cast<std::int64_t>(placement.names().size());
  for (const auto moved : placement.moved()) {
    out.stats.clampedVertices += moved == Placement::Moved::Clamped;
    out.stats.repairedVertices += moved == Placement::Moved::Repaired;
  }
  for (std::size_t t = 0; t < cells->splitOf.size(); ++t) {
    const std::int32_t s = cells->splitOf[t];
    const std::size_t n = s < 0 ? 1 : cells->split[static_cast<std::size_t>(s)].cells.size();
    ++out.stats.tetsByTissueCount[std::min<std::size_t>(n, 6) - 1];
  }
  out.stats.islands = cells->islands;
  out.stats.fatPockets = cells->fatPockets;
  out.stats.islandVolume = std::move(cells->islandVolume);
  countOffLabel(mesh, fields, *cells, placement, options, out);
  return out;
}

Result<AnatomyBuild> buildAnatomy(const domain::Domain& domain, const tissue::TissueFields& fields,
                                  const tissue::CoreSamples& cores, const EnvelopeOptions& options,
                                  RunContext& run) {
  const Stage stage(run, "envelope");
  EnvelopeOptions own = options;
  own.fatIsCandidate = fields.fatIsCandidate;
  for (const tissue::CoreSample& sample : cores.samples)
    own.seeds.push_back({sample.tet, sample.tissue});
  std::ranges::sort(own.seeds);
  own.seeds.erase(std::unique(own.seeds.begin(), own.seeds.end()), own.seeds.end());

  auto envelope = computeEnvelope(domain.mesh, domain.neighbours, fields.values, own, run);
  if (!envelope) return passOn(envelope);

  AnatomyBuild out;
  out.stats = std::move(envelope->stats);
  Anatomy& anatomy = out.anatomy;
  anatomy.mesh = std::move(envelope->mesh);
  anatomy.label = std::move(envelope->label);
  anatomy.parentTet = std::move(envelope->parentTet);
  anatomy.origin = std::move(envelope->origin);
  anatomy.neighbours = mesh::tetAdjacency(anatomy.mesh.T).neighbours;

  // A boundary face lies on the parent's face whose corners carry all of its weight
  std::vector<std::array<std::int32_t, 4>> tagOf(static_cast<std::size_t>(domain.mesh.T.rows()),
                                                 {-1, -1, -1, -1});
  for (Eigen::Index b = 0; b < domain.boundaryF.rows(); ++b) {
    const std::int32_t t = domain.boundaryTet[static_cast<std::size_t>(b)];
    for (int k = 0; k < 4; ++k) {
      const std::int32_t opposite = domain.mesh.T(t, k);
      if ((domain.boundaryF.row(b).array() != opposite).all()) {
        tagOf[static_cast<std::size_t>(t)][static_cast<std::size_t>(k)] =
            static_cast<std::int32_t>(b);
      }
    }
  }
  const mesh::TetBoundary boundary = mesh::tetBoundary(anatomy.mesh.T, anatomy.neighbours);
  anatomy.boundaryF = boundary.F;
  anatomy.boundaryTet = boundary.tet;
  anatomy.boundaryTag.resize(boundary.tet.size());
  const auto offset = static_cast<std::int32_t>(domain.mesh.V.rows());
  for (Eigen::Index b = 0; b < boundary.F.rows(); ++b) {
    const std::int32_t parent =
        anatomy.parentTet[static_cast<std::size_t>(boundary.tet[static_cast<std::size_t>(b)])];
    std::int32_t found = -1;
    for (int k = 0; k < 4; ++k) {
      const std::int32_t tag = tagOf[static_cast<std::size_t>(parent)][static_cast<std::size_t>(k)];
      if (tag < 0) continue;
      const std::int32_t opposite = domain.mesh.T(parent, k);
      bool uses = false;
      for (int c = 0; c < 3; ++c) {
        const std::int32_t v = boundary.F(b, c);
        if (v < offset) {
          uses = uses || v == opposite;
        } else {
          const auto& corners = anatomy.origin[static_cast<std::size_t>(v - offset)].corner;
          uses = uses || std::ranges::find(corners, opposite) != corners.end();
        }
      }
      if (!uses) found = tag;
    }
    if (found < 0) {
      return fail(ErrorCode::Internal,
                  fmt::format("the envelope has a boundary face that the domain has not, in tet {}",
                              parent));
    }
    anatomy.boundaryTag[static_cast<std::size_t>(b)] =
        domain.boundaryTag[static_cast<std::size_t>(found)];
  }
  return out;
}

}  // namespace ecorche::envelope
