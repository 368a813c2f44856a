#include <ecorche/core/parallel.h>
#include <ecorche/envelope/split_tets.h>
#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>

namespace ecorche::envelope {

namespace {

using tissue::FieldMatrix;

struct Input {
  const mesh::TetMesh& mesh;
  const mesh::TetNeighbours& neighbours;
  const FieldMatrix& fields;
  const EnvelopeOptions& options;
};

using Struck = std::map<std::int32_t, std::vector<std::int16_t>>;  // tet → columns

// Largest field at a vertex among those allowed, by the tie rule; columns from 1 come before fat
std::int16_t ownerAt(const Input& in, std::int32_t v, const std::vector<std::int16_t>* struck) {
  const double* f = &in.fields(v, 0);
  const auto allowed = [&](std::int16_t c) {
    return struck == nullptr || std::ranges::find(*struck, c) == struck->end();
  };
  std::int16_t best = -1;
  for (std::int16_t c = 1; c < in.fields.cols(); ++c) {
    if ((best < 0 || f[c] > f[best]) && allowed(c)) best = c;
  }
  if (in.options.fatIsCandidate && (best < 0 || f[0] > f[best])) best = 0;
  return best;
}

// Columns that may show in the tet: not below one of the corners' owners at all four corners
void findCandidates(const Input& in, std::int32_t tet, const std::array<std::int16_t, 4>& owners,
                    const std::vector<std::int16_t>* struck, std::vector<std::int32_t>& out) {
  const double* f[4];
  for (int c = 0; c < 4; ++c) f[c] = &in.fields(in.mesh.T(tet, c), 0);
  out.clear();
  const auto first = static_cast<std::int32_t>(in.options.fatIsCandidate ? 0 : 1);
  for (std::int32_t m = first; m < in.fields.cols(); ++m) {
    const bool owns = std::ranges::find(owners, m) != owners.end();
    bool beaten = false;
    for (int o = 0; o < 4 && !owns && !beaten; ++o) {
      const std::int16_t by = owners[static_cast<std::size_t>(o)];
      beaten = true;
      for (int c = 0; c < 4 && beaten; ++c) {
        beaten = f[c][m] < f[c][by] || (f[c][m] == f[c][by] && comesFirst(by, m));
      }
    }
    if (beaten) continue;
    if (struck != nullptr && std::ranges::find(*struck, m) != struck->end()) continue;
    out.push_back(m);
  }
}

VertexName nameOf(const Input& in, std::int32_t tet, const MeetingPoint& point) {
  VertexName name;
  for (int k = 0; k < point.count; ++k) {
    name.vertex[static_cast<std::size_t>(k)] =
        in.mesh.T(tet, point.corners[static_cast<std::size_t>(k)]);
    name.field[static_cast<std::size_t>(k)] =
        static_cast<std::int16_t>(point.fields[static_cast<std::size_t>(k)]);
  }
  std::sort(name.vertex.begin(), name.vertex.begin() + point.count);
  std::sort(name.field.begin(), name.field.begin() + point.count);
  return name;
}

struct Scratch {
  CellCutter cutter;
  std::vector<std::int32_t> candidates;
};

SplitTet splitTet(const Input& in, std::int32_t tet, const std::array<std::int16_t, 4>& owners,
                  const std::vector<std::int16_t>* struck, Scratch& scratch) {
  SplitTet out;
  out.tet = tet;
  out.struck = struck != nullptr;
  findCandidates(in, tet, owners, struck, scratch.candidates);
  CornerFields f;
  for (int c = 0; c < 4; ++c) f.row[static_cast<std::size_t>(c)] = &in.fields(in.mesh.T(tet, c), 0);

  for (const Cell& cell : scratch.cutter.cut(f, scratch.candidates)) {
    SplitTet::Cell to;
    to.column =
        static_cast<std::int16_t>(scratch.candidates[static_cast<std::size_t>(cell.candidate)]);
    to.faces.reserve(cell.faces.size());
    for (const CellFace& face : cell.faces) {
      SplitTet::Face loop;
      loop.plane = face.plane;
      loop.loop.reserve(face.loop.size());
      for (const std::int16_t corner : face.loop) {
        const MeetingPoint point = CellCutter::pointOf(
            scratch.candidates, cell.candidate, cell.corners[static_cast<std::size_t>(corner)]);
        if (point.count == 1) {
          loop.loop.push_back(static_cast<std::int16_t>(point.corners[0]));
          continue;
        }
        const VertexName name = nameOf(in, tet, point);
        auto known = std::ranges::find(out.names, name);
        if (known == out.names.end()) known = out.names.insert(out.names.end(), name);
        loop.loop.push_back(static_cast<std::int16_t>(4 + (known - out.names.begin())));
      }
      to.faces.push_back(std::move(loop));
    }
    out.cells.push_back(std::move(to));
  }
  return out;
}

Result<void> checkFinite(const FieldMatrix& fields) {
  std::atomic<std::int64_t> culprit{std::numeric_limits<std::int64_t>::max()};
  parallelFor(fields.rows(), [&](std::int64_t v) {
    if (fields.row(v).allFinite()) return;
    std::int64_t seen = culprit.load();
    while (v < seen && !culprit.compare_exchange_weak(seen, v)) {
    }
  });
  if (culprit.load() == std::numeric_limits<std::int64_t>::max()) return {};
  const std::int64_t v = culprit.load();
  Eigen::Index column = 0;
  while (std::isfinite(fields(v, column))) ++column;
  return fail(
      ErrorCode::NonFiniteField,
      fmt::format(
          "the field of tissue {} is not a number at vertex {}; the tissue solve went wrong there",
          column + 1, v));
}

// Cells as nodes of a graph, linked across tet faces where both sides show the same tissue
class CellGraph {
 public:
  CellGraph(const Input& in, const CellComplex& cells) : in_(in), cells_(cells) {
    const auto tetCount = static_cast<std::size_t>(in.mesh.T.rows());
    first_.resize(tetCount + 1, 0);
    for (std::size_t t = 0; t < tetCount; ++t) {
      const std::int32_t s = cells.splitOf[t];
      first_[t + 1] =
          first_[t] +
          (s < 0
               ? 1
               : static_cast<std::int32_t>(cells.split[static_cast<std::size_t>(s)].cells.size()));
    }
    parent_.resize(static_cast<std::size_t>(first_.back()));
    std::iota(parent_.begin(), parent_.end(), 0);
    link();
  }

  [[nodiscard]] std::int32_t nodeCount() const { return first_.back(); }
  [[nodiscard]] std::int32_t first(std::int32_t tet) const {
    return first_[static_cast<std::size_t>(tet)];
  }
  std::int32_t root(std::int32_t n) {
    while (parent_[static_cast<std::size_t>(n)] != n) {
      auto& p = parent_[static_cast<std::size_t>(n)];
      p = parent_[static_cast<std::size_t>(p)];
      n = p;
    }
    return n;
  }
  [[nodiscard]] std::int16_t column(std::int32_t tet, std::int32_t node) const {
    const std::int32_t s = cells_.splitOf[static_cast<std::size_t>(tet)];
    return s < 0 ? cells_.owner[static_cast<std::size_t>(tet)]
                 : cells_.split[static_cast<std::size_t>(s)]
                       .cells[static_cast<std::size_t>(node - first(tet))]
                       .column;
  }
  // Node of a tissue in a tet; -1 where it does not show
  [[nodiscard]] std::int32_t node(std::int32_t tet, std::int16_t wanted) const {
    for (std::int32_t n = first(tet); n < first_[static_cast<std::size_t>(tet) + 1]; ++n) {
      if (column(tet, n) == wanted) return n;
    }
    return -1;
  }

 private:
  const Input& in_;
  const CellComplex& cells_;
  std::vector<std::int32_t> first_;
  std::vector<std::int32_t> parent_;

  void join(std::int32_t a, std::int32_t b) {
    a = root(a);
    b = root(b);
    if (a != b) parent_[static_cast<std::size_t>(std::max(a, b))] = std::min(a, b);
  }

  void link() {
    for (std::int32_t t = 0; t < in_.mesh.T.rows(); ++t) {
      const std::int32_t s = cells_.splitOf[static_cast<std::size_t>(t)];
      for (int k = 0; k < 4; ++k) {
        const std::int32_t n = in_.neighbours(t, k);
        if (n < 0) continue;
        const bool plainNeighbour = cells_.splitOf[static_cast<std::size_t>(n)] < 0;
        if (s < 0) {
          // Both plain: same owner, for they share corners. A split neighbour links from its own
          // side.
          if (plainNeighbour && t < n) join(first(t), first(n));
          continue;
        }
        if (!plainNeighbour && t > n) continue;
        const SplitTet& split = cells_.split[static_cast<std::size_t>(s)];
        for (std::size_t c = 0; c < split.cells.size(); ++c) {
          const auto onFace = [&](const SplitTet::Face& f) { return f.plane == k; };
          if (std::ranges::none_of(split.cells[c].faces, onFace)) continue;
          const std::int32_t other = node(n, split.cells[c].column);
          if (other >= 0) join(first(t) + static_cast<std::int32_t>(c), other);
        }
      }
    }
  }
};

// Cells of islands, as columns to strike from tets; counts components
Struck findIslands(const Input& in, CellComplex& cells) {
  CellGraph graph(in, cells);
  std::vector<std::uint8_t> held(static_cast<std::size_t>(graph.nodeCount()), 0);
  for (const TissueInTet& seed : in.options.seeds) {
    const std::int32_t n = graph.node(seed.tet, static_cast<std::int16_t>(seed.tissue.value - 1));
    if (n >= 0) held[static_cast<std::size_t>(graph.root(n))] = 1;
  }
  Struck struck;
  std::vector<std::uint8_t> counted(held.size(), 0);
  std::int64_t fatComponents = 0;
  for (std::int32_t t = 0; t < in.mesh.T.rows(); ++t) {
    const std::int32_t s = cells.splitOf[static_cast<std::size_t>(t)];
    const std::int32_t count =
        s < 0 ? 1
              : static_cast<std::int32_t>(cells.split[static_cast<std::size_t>(s)].cells.size());
    for (std::int32_t c = 0; c < count; ++c) {
      const std::int32_t node = graph.first(t) + c;
      const auto root = static_cast<std::size_t>(graph.root(node));
      const std::int16_t column = graph.column(t, node);
      const bool fresh = counted[root] == 0;
      counted[root] = 1;
      if (column == 0) {
        fatComponents += fresh;
        continue;
      }
      if (held[root] != 0) continue;
      cells.islands += fresh;
      struck[t].push_back(column);
      // Cells of one tet share its volume; the exact share is known only once vertices have places
      const double volume = mesh::signedVolume(in.mesh, t) / count;
      cells.islandVolume[static_cast<std::size_t>(column + 1)] += volume;
    }
  }
  cells.fatPockets = std::max<std::int64_t>(0, fatComponents - 1);
  return struck;
}

}  // namespace

Result<CellComplex> buildCells(const mesh::TetMesh& mesh, const mesh::TetNeighbours& neighbours,
                               const FieldMatrix& fields, const EnvelopeOptions& options,
                               RunContext& run) {
  const Input in{mesh, neighbours, fields, options};
  if (auto finite = checkFinite(fields); !finite) return passOn(finite);

  // 1. One argmax per vertex; a tet whose corners agree needs no more: linear functions cannot rise
  // above inside
  std::vector<std::int16_t> vertexOwner(static_cast<std::size_t>(mesh.V.rows()));
  parallelFor(mesh.V.rows(), [&](std::int64_t v) {
    vertexOwner[static_cast<std::size_t>(v)] = ownerAt(in, static_cast<std::int32_t>(v), nullptr);
  });
  CellComplex out;
  out.islandVolume.assign(static_cast<std::size_t>(fields.cols()) + 1, 0.0);
  const auto tetCount = static_cast<std::size_t>(mesh.T.rows());
  out.owner.assign(tetCount, -1);
  out.splitOf.assign(tetCount, -1);
  std::vector<std::int32_t> mixed;
  for (std::size_t t = 0; t < tetCount; ++t) {
    const auto row = static_cast<Eigen::Index>(t);
    const std::int16_t o = vertexOwner[static_cast<std::size_t>(mesh.T(row, 0))];
    bool same = true;
    for (int c = 1; c < 4; ++c)
      same = same && vertexOwner[static_cast<std::size_t>(mesh.T(row, c))] == o;
    if (same) {
      out.owner[t] = o;
    } else {
      out.splitOf[t] = static_cast<std::int32_t>(mixed.size());
      mixed.push_back(static_cast<std::int32_t>(t));
    }
  }
  if (run.cancelled()) return fail(ErrorCode::Cancelled, "stopped while dividing the domain");

  // 2. Cells of mixed tets
  const auto ownersOf = [&](std::int32_t t) {
    std::array<std::int16_t, 4> owners{};
    for (int c = 0; c < 4; ++c)
      owners[static_cast<std::size_t>(c)] = vertexOwner[static_cast<std::size_t>(mesh.T(t, c))];
    return owners;
  };
  out.split.resize(mixed.size());
  constexpr std::int64_t kChunk = 256;
  const auto count = static_cast<std::int64_t>(mixed.size());
  parallelFor(
      (count + kChunk - 1) / kChunk,
      [&](std::int64_t chunk) {
        if (run.cancelled()) return;
        Scratch scratch;
        for (std::int64_t i = chunk * kChunk; i < std::min(count, (chunk + 1) * kChunk); ++i) {
          const std::int32_t t = mixed[static_cast<std::size_t>(i)];
          out.split[static_cast<std::size_t>(i)] = splitTet(in, t, ownersOf(t), nullptr, scratch);
        }
      },
      1);
  if (run.cancelled()) return fail(ErrorCode::Cancelled, "stopped while dividing the domain");

  // 3. Islands: strike their tissue from their tets and look again; what takes over may be cut off
  // in turn
  Struck struckSoFar;
  while (options.strikeIslands) {
    const Struck found = findIslands(in, out);
    if (found.empty()) break;
    Scratch scratch;
    for (const auto& [t, columns] : found) {
      auto& all = struckSoFar[t];
      all.insert(all.end(), columns.begin(), columns.end());
      std::array<std::int16_t, 4> owners{};
      for (int c = 0; c < 4; ++c)
        owners[static_cast<std::size_t>(c)] = ownerAt(in, mesh.T(t, c), &all);
      if (owners[0] < 0) {
        return fail(ErrorCode::Internal,
                    fmt::format("tet {} belongs to no tissue: fat is no candidate and every "
                                "muscle there is an island; give fat a value",
                                t));
      }
      auto& place = out.splitOf[static_cast<std::size_t>(t)];
      if (place < 0) {
        place = static_cast<std::int32_t>(out.split.size());
        out.split.emplace_back();
        out.owner[static_cast<std::size_t>(t)] = -1;
      }
      out.split[static_cast<std::size_t>(place)] = splitTet(in, t, owners, &all, scratch);
    }
    if (run.cancelled()) return fail(ErrorCode::Cancelled, "stopped while striking islands");
  }
  if (!struckSoFar.empty()) {
    std::ranges::sort(out.split, {}, &SplitTet::tet);
    for (std::size_t i = 0; i < out.split.size(); ++i) {
      out.splitOf[static_cast<std::size_t>(out.split[i].tet)] = static_cast<std::int32_t>(i);
    }
  }
  return out;
}

}  // namespace ecorche::envelope
