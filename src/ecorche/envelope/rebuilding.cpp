#include <ecorche/core/contract.h>
#include <ecorche/core/index.h>
#include <ecorche/envelope/children.h>
#include <ecorche/envelope/rebuilding.h>
#include <ecorche/envelope/repair.h>
#include <ecorche/envelope/tied_point.h>

#include <algorithm>
#include <map>

namespace ecorche::envelope {
namespace {

using Origin = Anatomy::Origin;

/// A triangle of a parent's boundary, counter-clockwise seen from outside.
struct OuterTriangle {
  std::array<std::int32_t, 3> vertex;
  std::int32_t column;
};

/// Faces of children that no other child of the parent shares.
std::vector<OuterTriangle> boundaryOf(const Split& split, std::int32_t parent) {
  std::map<Face, OuterTriangle> open;
  for (std::int32_t c = split.firstChild[toIndex(parent)];
       c < split.firstChild[toIndex(parent) + 1]; ++c) {
    for (int k = 0; k < 4; ++k) {
      const auto& f = mesh::kTetFace[k];
      const OuterTriangle own{{split.T(c, f[0]), split.T(c, f[1]), split.T(c, f[2])},
                              split.column[toIndex(c)]};
      const auto [place, isNew] = open.try_emplace(sortedFace(split.T, c, k), own);
      if (!isNew) open.erase(place);
    }
  }
  std::vector<OuterTriangle> out;
  for (const auto& [face, triangle] : open) out.push_back(triangle);
  return out;
}

/// Of the owners on the boundary the one whose field is the largest at the parent's centre.
std::int32_t ownerOfMiddle(const tissue::FieldMatrix& fields, const mesh::Tets& T,
                           std::int32_t parent, const std::vector<OuterTriangle>& boundary) {
  const auto value = [&](std::int32_t column) {
    double sum = 0.0;
    for (int c = 0; c < 4; ++c) sum += 0.25 * fields(T(parent, c), column);
    return sum;
  };
  std::int32_t best = boundary.front().column;
  for (const OuterTriangle& t : boundary) {
    if (beats(value(t.column), t.column, value(best), best)) best = t.column;
  }
  return best;
}

/// Vertices of one parent's copy: where those of the boundary go, and the centre.
class Copy {
 public:
  Copy(const mesh::Tets& T, std::int32_t vertexCount, std::int32_t parent, Placement& placement)
      : vertexCount_(vertexCount), placement_(placement) {
    for (int c = 0; c < 4; ++c) centre_.corner[toIndex(c)] = T(parent, c);
    std::ranges::sort(centre_.corner);
    centre_.weight.fill(0.25);
    middle_ = add(centre_);
  }

  [[nodiscard]] std::int32_t centre() const { return middle_; }

  std::int32_t of(std::int32_t vertex) {
    const auto [place, isNew] = copyOf_.try_emplace(vertex, -1);
    if (isNew) place->second = add(halfWay(vertex));
    return place->second;
  }

 private:
  [[nodiscard]] Origin halfWay(std::int32_t vertex) const {
    Origin own = centre_;
    for (double& w : own.weight) w *= 0.5;
    const auto addTo = [&](std::int32_t corner, double weight) {
      own.weight[toIndex(std::ranges::find(own.corner, corner) - own.corner.begin())] +=
          0.5 * weight;
    };
    if (vertex < vertexCount_) {
      addTo(vertex, 1.0);
      return own;
    }
    const Origin& outer = placement_.origin[toIndex(vertex - vertexCount_)];
    for (std::size_t c = 0; c < 4; ++c) {
      if (outer.corner[c] >= 0) addTo(outer.corner[c], outer.weight[c]);
    }
    return own;
  }

  std::int32_t add(const Origin& origin) {
    placement_.origin.push_back(origin);
    placement_.placed.push_back(Placed::Repaired);
    return vertexCount_ + static_cast<std::int32_t>(placement_.origin.size()) - 1;
  }

  std::int32_t vertexCount_;
  Placement& placement_;
  Origin centre_;
  std::int32_t middle_ = -1;
  std::map<std::int32_t, std::int32_t> copyOf_;
};

std::vector<SubTet> layersAndMiddle(const std::vector<OuterTriangle>& boundary, std::int32_t middle,
                                    Copy& copy) {
  std::vector<SubTet> out;
  for (const OuterTriangle& triangle : boundary) {
    auto [a, b, c] = triangle.vertex;
    while (a > b || a > c) {
      const std::int32_t first = a;
      a = b;
      b = c;
      c = first;
    }
    const std::int32_t A = copy.of(a);
    const std::int32_t B = copy.of(b);
    const std::int32_t C = copy.of(c);
    out.push_back({{copy.centre(), A, B, C}, middle});
    // Sides of a layer are cut from their lowest outer vertex: layers side by side agree
    out.push_back({{A, B, C, a}, triangle.column});
    if (b < c) {
      out.push_back({{a, c, b, C}, triangle.column});
      out.push_back({{a, b, B, C}, triangle.column});
    } else {
      out.push_back({{a, c, b, B}, triangle.column});
      out.push_back({{a, c, B, C}, triangle.column});
    }
  }
  return out;
}

/// The split with other children for some parents.
Split withChildren(const Split& split, const std::map<std::int32_t, std::vector<SubTet>>& anew) {
  std::int64_t total = split.T.rows();
  for (const auto& [t, children] : anew) {
    total += static_cast<std::int64_t>(children.size()) -
             (split.firstChild[toIndex(t) + 1] - split.firstChild[toIndex(t)]);
  }
  Split out;
  out.T.resize(total, 4);
  const auto add = [&](const auto& vertices, std::int32_t column, std::int32_t parent) {
    const auto row = static_cast<Eigen::Index>(out.parent.size());
    for (int k = 0; k < 4; ++k) out.T(row, k) = vertices[k];
    out.column.push_back(column);
    out.parent.push_back(parent);
  };
  const auto parentCount = static_cast<std::int32_t>(split.firstChild.size()) - 1;
  for (std::int32_t t = 0; t < parentCount; ++t) {
    out.firstChild.push_back(static_cast<std::int32_t>(out.parent.size()));
    if (const auto own = anew.find(t); own != anew.end()) {
      for (const SubTet& child : own->second) add(child.vertex, child.column, t);
      continue;
    }
    for (std::int32_t c = split.firstChild[toIndex(t)]; c < split.firstChild[toIndex(t) + 1]; ++c) {
      add(split.T.row(c), split.column[toIndex(c)], t);
    }
  }
  out.firstChild.push_back(static_cast<std::int32_t>(out.parent.size()));
  EC_REQUIRE_EQ(out.firstChild.back(), total);
  return out;
}

/// Drops new vertices that no tet uses; the others keep their order.
void dropUnused(std::int32_t vertexCount, Split& split, Placement& placement) {
  std::vector<std::int32_t> number(placement.origin.size(), -1);
  for (Eigen::Index i = 0; i < split.T.size(); ++i) {
    if (split.T.data()[i] >= vertexCount) number[toIndex(split.T.data()[i] - vertexCount)] = 0;
  }
  std::int32_t next = 0;
  for (std::size_t k = 0; k < number.size(); ++k) {
    if (number[k] < 0) continue;
    placement.origin[toIndex(next)] = placement.origin[k];
    placement.placed[toIndex(next)] = placement.placed[k];
    number[k] = next++;
  }
  placement.origin.resize(toIndex(next));
  placement.placed.resize(toIndex(next));
  for (Eigen::Index i = 0; i < split.T.size(); ++i) {
    std::int32_t& v = split.T.data()[i];
    if (v >= vertexCount) v = vertexCount + number[toIndex(v - vertexCount)];
  }
}

}  // namespace

void rebuildTets(const mesh::TetMesh& domain, const tissue::FieldMatrix& fields,
                 std::span<const std::int32_t> parents, Split& split, Placement& placement,
                 mesh::Positions& V) {
  const auto vertexCount = static_cast<std::int32_t>(domain.V.rows());
  std::map<std::int32_t, std::vector<SubTet>> anew;
  for (const std::int32_t t : parents) {
    const auto boundary = boundaryOf(split, t);
    Copy copy(domain.T, vertexCount, t, placement);
    anew[t] = layersAndMiddle(boundary, ownerOfMiddle(fields, domain.T, t, boundary), copy);
  }
  split = withChildren(split, anew);
  dropUnused(vertexCount, split, placement);
  V = positionsOf(domain.V, placement.origin);
}

}  // namespace ecorche::envelope
