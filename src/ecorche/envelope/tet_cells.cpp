#include <ecorche/core/contract.h>
#include <ecorche/envelope/tet_cells.h>
#include <ecorche/mesh/types.h>

#include <algorithm>

namespace ecorche::envelope {

namespace {

constexpr std::int16_t kBisector = 4;  // planes from here on

// The two planes that two neighbouring corners of a simple polytope share, and with a third the
// corner they name
CellCorner meeting(const CellCorner& a, const CellCorner& b, std::int16_t third) {
  CellCorner out{};
  int count = 0;
  for (const std::int16_t p : a) {
    if (std::ranges::find(b, p) != b.end() && count < 2) out[static_cast<std::size_t>(count++)] = p;
  }
  EC_ASSERT(count == 2, "corners that are no neighbours");
  out[2] = third;
  std::ranges::sort(out);
  return out;
}

}  // namespace

MeetingPoint CellCutter::pointOf(const std::vector<std::int32_t>& candidates,
                                 std::int16_t candidate, const CellCorner& corner) {
  MeetingPoint point;
  bool onFace[4] = {false, false, false, false};
  int fields = 0;
  point.fields[static_cast<std::size_t>(fields++)] =
      candidates[static_cast<std::size_t>(candidate)];
  for (const std::int16_t plane : corner) {
    if (plane < kBisector) {
      onFace[plane] = true;
    } else {
      point.fields[static_cast<std::size_t>(fields++)] =
          candidates[static_cast<std::size_t>(plane - kBisector)];
    }
  }
  for (int c = 0; c < 4; ++c) {
    if (!onFace[c]) point.corners[static_cast<std::size_t>(point.count++)] = c;
  }
  EC_ASSERT(point.count == fields, "a corner of {} planes", 3);
  return point;
}

void CellCutter::startFromTet(Cell& cell) const {
  cell.corners.clear();
  cell.faces.resize(4);
  for (int c = 0; c < 4; ++c) {
    CellCorner planes{};
    int n = 0;
    for (std::int16_t p = 0; p < 4; ++p) {
      if (p != c) planes[static_cast<std::size_t>(n++)] = p;
    }
    cell.corners.push_back(planes);
  }
  for (int k = 0; k < 4; ++k) {
    CellFace& face = cell.faces[static_cast<std::size_t>(k)];
    face.plane = static_cast<std::int16_t>(k);
    face.loop.assign({static_cast<std::int16_t>(mesh::kTetFace[k][0]),
                      static_cast<std::int16_t>(mesh::kTetFace[k][1]),
                      static_cast<std::int16_t>(mesh::kTetFace[k][2])});
  }
}

void CellCutter::clip(Cell& cell, const CornerFields& f,
                      const std::vector<std::int32_t>& candidates, std::int16_t other) {
  // 1. Which corners the other field rises above. Corners that earlier clips dropped keep side 0.
  side_.assign(cell.corners.size(), 0);
  bool dropsAny = false;
  bool keepsAny = false;
  for (const CellFace& face : cell.faces) {
    for (const std::int16_t v : face.loop) {
      auto& side = side_[static_cast<std::size_t>(v)];
      if (side != 0) continue;
      const MeetingPoint p =
          pointOf(candidates, cell.candidate, cell.corners[static_cast<std::size_t>(v)]);
      side =
          static_cast<std::int8_t>(-signAbove(f, p, candidates[static_cast<std::size_t>(other)]));
      (side > 0 ? keepsAny : dropsAny) = true;
    }
  }
  if (!dropsAny) return;
  if (!keepsAny) {
    cell.faces.clear();
    return;
  }

  // 2. Every face keeps what lies on the good side; where it is cut it gains an edge, whose reverse
  // bounds the lid
  const auto plane = static_cast<std::int16_t>(kBisector + other);
  std::vector<std::array<std::int16_t, 2>> lidEdges;
  const auto cornerAt = [&](std::int16_t a, std::int16_t b) {
    const CellCorner named = meeting(cell.corners[static_cast<std::size_t>(a)],
                                     cell.corners[static_cast<std::size_t>(b)], plane);
    for (std::size_t k = side_.size(); k < cell.corners.size(); ++k) {
      if (cell.corners[k] == named) return static_cast<std::int16_t>(k);
    }
    cell.corners.push_back(named);
    return static_cast<std::int16_t>(cell.corners.size() - 1);
  };
  std::size_t kept = 0;
  for (std::size_t k = 0; k < cell.faces.size(); ++k) {
    CellFace& face = cell.faces[k];
    fresh_.clear();
    std::int16_t leave = -1;
    std::int16_t enter = -1;
    for (std::size_t i = 0; i < face.loop.size(); ++i) {
      const std::int16_t a = face.loop[i];
      const std::int16_t b = face.loop[(i + 1) % face.loop.size()];
      const bool keepA = side_[static_cast<std::size_t>(a)] > 0;
      const bool keepB = side_[static_cast<std::size_t>(b)] > 0;
      if (keepA) fresh_.push_back(a);
      if (keepA != keepB) {
        const std::int16_t at = cornerAt(a, b);
        fresh_.push_back(at);
        (keepA ? leave : enter) = at;
      }
    }
    if (fresh_.empty()) continue;
    if (leave >= 0) lidEdges.push_back({enter, leave});
    face.loop = fresh_;
    if (kept != k) std::swap(cell.faces[kept], face);
    ++kept;
  }
  cell.faces.resize(kept);

  // 3. The lid: follow its edges round
  CellFace lid;
  lid.plane = plane;
  std::int16_t at = lidEdges.front()[0];
  do {
    lid.loop.push_back(at);
    for (const auto& edge : lidEdges) {
      if (edge[0] == at) {
        at = edge[1];
        break;
      }
    }
  } while (at != lidEdges.front()[0] && lid.loop.size() <= lidEdges.size());
  EC_ASSERT(lid.loop.size() == lidEdges.size(), "the cut through a convex cell is one loop");
  cell.faces.push_back(std::move(lid));
}

const std::vector<Cell>& CellCutter::cut(const CornerFields& f,
                                         const std::vector<std::int32_t>& candidates) {
  cells_.resize(candidates.size());
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    Cell& cell = cells_[i];
    cell.candidate = static_cast<std::int16_t>(i);
    startFromTet(cell);
    for (std::size_t j = 0; j < candidates.size() && !cell.empty(); ++j) {
      if (j != i) clip(cell, f, candidates, static_cast<std::int16_t>(j));
    }
  }
  std::erase_if(cells_, [](const Cell& cell) { return cell.empty(); });
  return cells_;
}

}  // namespace ecorche::envelope
