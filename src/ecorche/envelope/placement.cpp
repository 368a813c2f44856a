#include <ecorche/core/parallel.h>
#include <ecorche/envelope/placement.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

namespace ecorche::envelope {

namespace {

MeetingPoint pointOf(const VertexName& name) {
  MeetingPoint point;
  point.count = name.count();
  for (int k = 0; k < point.count; ++k) {
    point.corners[static_cast<std::size_t>(k)] = k;
    point.fields[static_cast<std::size_t>(k)] = name.field[static_cast<std::size_t>(k)];
  }
  return point;
}

}  // namespace

Placement::Placement(const mesh::TetMesh& mesh, const tissue::FieldMatrix& fields,
                     std::vector<VertexName> names, const EnvelopeOptions& options)
    : mesh_(mesh), fields_(fields), clamp_(options.clamp), names_(std::move(names)) {
  origin_.resize(names_.size());
  moved_.assign(names_.size(), Moved::No);
  for (std::size_t n = 0; n < names_.size(); ++n) origin_[n].corner = names_[n].vertex;
  placeEdges(options.exact);
  placeInside(options.exact);
}

mesh::Vector3 Placement::position(std::size_t name) const {
  const Anatomy::Origin& o = origin_[name];
  mesh::Vector3 p = mesh::Vector3::Zero();
  for (std::size_t c = 0; c < 4; ++c) {
    if (o.corner[c] >= 0) p += o.weight[c] * mesh_.V.row(o.corner[c]).transpose();
  }
  return p;
}

// Crossings of one edge in the order in which the tissue changes along it. Each tissue but the
// first and last takes part in two crossings, so they form a chain; places in doubles could put
// near ones in the wrong order.
std::vector<std::size_t> Placement::alongEdge(std::size_t begin, std::size_t end) const {
  std::vector<std::size_t> order;
  for (std::size_t n = begin; n < end; ++n) order.push_back(n);
  if (order.size() < 2) return order;
  std::int16_t at = -1;
  for (const std::size_t n : order) {
    for (int k = 0; k < 2; ++k) {
      const std::int16_t c = names_[n].field[static_cast<std::size_t>(k)];
      const auto v = names_[n].vertex[0];
      const bool above = at < 0 || fields_(v, c) > fields_(v, at) ||
                         (fields_(v, c) == fields_(v, at) && comesFirst(c, at));
      if (c != at && above) at = c;
    }
  }
  for (std::size_t k = 0; k < order.size(); ++k) {
    for (std::size_t j = k; j < order.size(); ++j) {
      const auto& field = names_[order[j]].field;
      if (field[0] != at && field[1] != at) continue;
      std::swap(order[k], order[j]);
      at = field[0] == at ? field[1] : field[0];
      break;
    }
  }
  return order;
}

void Placement::placeEdges(bool exact) {
  for (std::size_t begin = 0; begin < names_.size() && names_[begin].count() == 2;) {
    std::size_t end = begin + 1;
    while (end < names_.size() && names_[end].vertex == names_[begin].vertex) ++end;

    const std::vector<std::size_t> order = alongEdge(begin, end);
    const auto count = static_cast<double>(order.size());
    const double gap = std::min(clamp_, 0.5 / (count + 1.0));
    std::vector<double> t;
    for (const std::size_t n : order) {
      const auto a = names_[n].vertex[0];
      const auto b = names_[n].vertex[1];
      const double da = fields_(a, names_[n].field[0]) - fields_(a, names_[n].field[1]);
      const double db = fields_(b, names_[n].field[0]) - fields_(b, names_[n].field[1]);
      const double raw = da == db ? 0.5 : da / (da - db);
      t.push_back(std::clamp(std::isfinite(raw) ? raw : 0.5, 0.0, 1.0));
    }
    std::vector<double> placed = t;
    if (!exact) {
      double low = gap;
      for (double& x : placed) {
        x = std::max(x, low);
        low = x + gap;
      }
      double high = 1.0 - gap;
      for (std::size_t k = placed.size(); k-- > 0;) {
        placed[k] = std::min(placed[k], high);
        high = placed[k] - gap;
      }
    }
    for (std::size_t k = 0; k < order.size(); ++k) {
      origin_[order[k]].weight = {1.0 - placed[k], placed[k], 0.0, 0.0};
      if (placed[k] != t[k]) moved_[order[k]] = Moved::Clamped;
    }
    begin = end;
  }
}

void Placement::placeInside(bool exact) {
  const auto first = static_cast<std::int64_t>(
      std::ranges::partition_point(names_, [](const VertexName& n) { return n.count() == 2; }) -
      names_.begin());
  parallelFor(static_cast<std::int64_t>(names_.size()) - first, [&](std::int64_t i) {
    const auto n = static_cast<std::size_t>(first + i);
    const MeetingPoint point = pointOf(names_[n]);
    CornerFields f;
    for (int c = 0; c < point.count; ++c) {
      f.row[static_cast<std::size_t>(c)] =
          &fields_(names_[n].vertex[static_cast<std::size_t>(c)], 0);
    }
    std::array<double, 4> w = meetingWeights(f, point);
    double sum = 0.0;
    bool changed = false;
    for (int c = 0; c < point.count; ++c) {
      double& x = w[static_cast<std::size_t>(c)];
      const double low = exact ? 0.0 : clamp_;
      if (!(x >= low)) {
        x = low;
        changed = true;
      }
      sum += x;
    }
    if (!(sum > 0.0)) {
      for (int c = 0; c < point.count; ++c) w[static_cast<std::size_t>(c)] = 1.0;
      sum = point.count;
      changed = true;
    }
    if (changed) {
      for (double& x : w) x /= sum;
      moved_[n] = Moved::Clamped;
    }
    origin_[n].weight = w;
  });
}

void Placement::relax(const std::vector<SplitTet>& all, const std::vector<std::int32_t>& badSplits,
                      double strength, bool edgesToo) {
  const auto offset = static_cast<std::int32_t>(mesh_.V.rows());
  std::set<std::int32_t> scope;  // names
  for (const std::int32_t s : badSplits) {
    for (const std::int32_t id : all[static_cast<std::size_t>(s)].id) scope.insert(id - offset);
  }

  if (edgesToo) {
    std::set<std::size_t> groups;
    for (const std::int32_t n : scope) {
      const auto name = static_cast<std::size_t>(n);
      if (names_[name].count() != 2) continue;
      std::size_t begin = name;
      while (begin > 0 && names_[begin - 1].vertex == names_[name].vertex) --begin;
      if (!groups.insert(begin).second) continue;
      std::size_t end = begin;
      while (end < names_.size() && names_[end].vertex == names_[name].vertex) ++end;
      const std::vector<std::size_t> order = alongEdge(begin, end);
      for (std::size_t k = 0; k < order.size(); ++k) {
        const double t = static_cast<double>(k + 1) / static_cast<double>(order.size() + 1);
        origin_[order[k]].weight = {1.0 - t, t, 0.0, 0.0};
        moved_[order[k]] = Moved::Repaired;
      }
    }
  }

  // Neighbours of names inside faces and tets: along polygon sides in the face, along all sides in
  // the tet
  std::map<std::int32_t, std::set<std::int32_t>> around;  // name → vertices
  for (const SplitTet& split : all) {
    if (std::ranges::none_of(split.id,
                             [&](std::int32_t id) { return scope.contains(id - offset); }))
      continue;
    for (const auto& cell : split.cells) {
      for (const auto& face : cell.faces) {
        for (std::size_t k = 0; k < face.loop.size(); ++k) {
          const std::int32_t a = split.vertex(mesh_.T, face.loop[k]);
          const std::int32_t b = split.vertex(mesh_.T, face.loop[(k + 1) % face.loop.size()]);
          for (const auto& [from, to] : {std::pair{a, b}, std::pair{b, a}}) {
            if (from < offset || !scope.contains(from - offset)) continue;
            const int kind = names_[static_cast<std::size_t>(from - offset)].count();
            if (kind == 4 || (kind == 3 && face.plane < 4)) around[from - offset].insert(to);
          }
        }
      }
    }
  }

  // A face name sees sides of both its tets' cells, and of other faces of the tet that pass through
  // it: keep its own face
  const auto inOwn = [&](std::int32_t name, std::int32_t vertex) {
    const auto& own = names_[static_cast<std::size_t>(name)].vertex;
    const auto holds = [&](std::int32_t v) { return std::ranges::find(own, v) != own.end(); };
    if (vertex < offset) return holds(vertex);
    const auto& other = names_[static_cast<std::size_t>(vertex - offset)];
    for (int c = 0; c < other.count(); ++c) {
      if (!holds(other.vertex[static_cast<std::size_t>(c)])) return false;
    }
    return true;
  };
  const auto weightOf = [&](std::int32_t vertex, std::int32_t corner) {
    if (vertex < offset) return vertex == corner ? 1.0 : 0.0;
    const Anatomy::Origin& o = origin_[static_cast<std::size_t>(vertex - offset)];
    for (std::size_t c = 0; c < 4; ++c) {
      if (o.corner[c] == corner) return o.weight[c];
    }
    return 0.0;
  };
  std::map<std::int32_t, Anatomy::Origin> before;
  for (const auto& [name, unused] : around) before[name] = origin_[static_cast<std::size_t>(name)];
  for (int sweep = 0; sweep < 40; ++sweep) {
    for (const auto& [name, vertices] : around) {
      Anatomy::Origin& o = origin_[static_cast<std::size_t>(name)];
      std::array<double, 4> mean{};
      int count = 0;
      for (const std::int32_t v : vertices) {
        if (!inOwn(name, v)) continue;
        for (std::size_t c = 0; c < 4; ++c) {
          if (o.corner[c] >= 0) mean[c] += weightOf(v, o.corner[c]);
        }
        ++count;
      }
      if (count == 0) continue;
      for (double& x : mean) x /= count;
      o.weight = mean;
    }
  }
  for (const auto& [name, raw] : before) {
    Anatomy::Origin& o = origin_[static_cast<std::size_t>(name)];
    for (std::size_t c = 0; c < 4; ++c)
      o.weight[c] = (1.0 - strength) * raw.weight[c] + strength * o.weight[c];
    moved_[static_cast<std::size_t>(name)] = Moved::Repaired;
  }
}

}  // namespace ecorche::envelope
