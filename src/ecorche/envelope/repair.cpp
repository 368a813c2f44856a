#include <ecorche/core/contract.h>
#include <ecorche/core/index.h>
#include <ecorche/core/parallel.h>
#include <ecorche/envelope/collect.h>
#include <ecorche/envelope/rebuilding.h>
#include <ecorche/envelope/repair.h>
#include <ecorche/mesh/orientation.h>

#include <algorithm>
#include <map>

namespace ecorche::envelope {
namespace {

using mesh::Tets;
using mesh::Vector3;
using Origin = Anatomy::Origin;

Vector3 placeOf(const mesh::Positions& V, const Origin& o) {
  Vector3 p = Vector3::Zero();
  for (std::size_t c = 0; c < 4; ++c) {
    if (o.corner[c] >= 0) p += o.weight[c] * V.row(o.corner[c]).transpose();
  }
  return p;
}

class Repair {
 public:
  Repair(const mesh::TetMesh& domain, const tissue::FieldMatrix& fields, const Diagram& d,
         double thin, Split& split, Placement& placement, mesh::Positions& V)
      : domain_(domain),
        fields_(fields),
        d_(d),
        thin_(thin),
        safe_(domain.T, d),
        raw_(placement.origin),
        split_(split),
        placement_(placement),
        V_(V) {}

  RepairCount run();

 private:
  [[nodiscard]] int sign(std::int32_t child) const;
  [[nodiscard]] bool isThin(std::int32_t child) const;
  template <class IsSuch>
  [[nodiscard]] std::vector<std::int32_t> parentsWith(const IsSuch& isSuch) const;
  [[nodiscard]] std::vector<std::int32_t> namesOf(std::int32_t parent) const;
  [[nodiscard]] Origin safePlace(std::int32_t name) const;
  void put(std::int32_t name, const Origin& origin);
  bool raise(const std::vector<std::int32_t>& parents);
  std::vector<std::int32_t> secureFaces(std::vector<std::int32_t> parents);

  const mesh::TetMesh& domain_;
  const tissue::FieldMatrix& fields_;
  const Diagram& d_;
  double thin_;
  SafePlaces safe_;
  std::vector<Origin> raw_;
  Split& split_;
  Placement& placement_;
  mesh::Positions& V_;
  std::map<std::int32_t, std::size_t> level_;  ///< of names that were raised
};

// Share of the way to the safe place, by level
constexpr std::array<double, 5> kShare{0.0, 1.0 / 64, 1.0 / 16, 1.0 / 4, 1.0};

int Repair::sign(std::int32_t child) const {
  const auto corner = [&](int c) { return Vector3(V_.row(split_.T(child, c)).transpose()); };
  return mesh::orientation(corner(0), corner(1), corner(2), corner(3));
}

bool Repair::isThin(std::int32_t child) const {
  const auto volume = [](const mesh::Positions& P, const auto& tet) {
    return mesh::signedVolume(P.row(tet[0]).transpose(), P.row(tet[1]).transpose(),
                              P.row(tet[2]).transpose(), P.row(tet[3]).transpose());
  };
  const double own = volume(V_, split_.T.row(child));
  const double whole = volume(domain_.V, domain_.T.row(split_.parent[toIndex(child)]));
  return !(own > thin_ * whole);
}

/// Mixed parents with a child of that kind, ascending.
template <class IsSuch>
std::vector<std::int32_t> Repair::parentsWith(const IsSuch& isSuch) const {
  return collect<std::int32_t>(static_cast<std::int64_t>(d_.mixed.size()),
                               [&](std::int64_t m, auto& out) {
                                 const std::int32_t t = d_.mixed[toIndex(m)];
                                 for (std::int32_t c = split_.firstChild[toIndex(t)];
                                      c < split_.firstChild[toIndex(t) + 1]; ++c) {
                                   if (!isSuch(c)) continue;
                                   out.push_back(t);
                                   return;
                                 }
                               });
}

/// New vertices of a parent, ascending, counted from the first new one.
std::vector<std::int32_t> Repair::namesOf(std::int32_t parent) const {
  std::vector<std::int32_t> names;
  for (std::int32_t c = split_.firstChild[toIndex(parent)];
       c < split_.firstChild[toIndex(parent) + 1]; ++c) {
    for (int k = 0; k < 4; ++k) {
      if (split_.T(c, k) >= d_.vertexCount()) names.push_back(split_.T(c, k) - d_.vertexCount());
    }
  }
  std::ranges::sort(names);
  names.erase(std::unique(names.begin(), names.end()), names.end());
  return names;
}

Origin Repair::safePlace(std::int32_t name) const {
  const auto holder = [](const std::vector<std::int32_t>& first, std::int32_t i) {
    return static_cast<std::int32_t>(std::ranges::upper_bound(first, i) - first.begin()) - 1;
  };
  const std::int32_t facesBegin = d_.facePointId(0) - d_.vertexCount();
  const std::int32_t tetsBegin = d_.tetPointId(0) - d_.vertexCount();
  if (name < facesBegin) return safe_.ofCrossing(holder(d_.edgeFirst, name), name);
  if (name < tetsBegin) {
    const std::int32_t f = holder(d_.faceFirst, name - facesBegin);
    return safe_.ofFace(f)[toIndex(name - facesBegin - d_.faceFirst[toIndex(f)])];
  }
  const std::int32_t x = holder(d_.tetFirst, name - tetsBegin);
  return safe_.ofTet(x)[toIndex(name - tetsBegin - d_.tetFirst[toIndex(x)])];
}

void Repair::put(std::int32_t name, const Origin& origin) {
  placement_.origin[toIndex(name)] = origin;
  placement_.placed[toIndex(name)] = Placed::Repaired;
  V_.row(d_.vertexCount() + name) = placeOf(V_, origin).transpose();
}

/// One level further towards safety for every name of these parents; false if all are there
/// already.
bool Repair::raise(const std::vector<std::int32_t>& parents) {
  std::vector<std::int32_t> names;
  for (const std::int32_t t : parents) {
    const auto own = namesOf(t);
    names.insert(names.end(), own.begin(), own.end());
  }
  std::ranges::sort(names);
  names.erase(std::unique(names.begin(), names.end()), names.end());
  bool raised = false;
  for (const std::int32_t name : names) {
    std::size_t& level = level_[name];
    if (level + 1 == kShare.size()) continue;
    ++level;
    raised = true;
    put(name, blend(raw_[toIndex(name)], safePlace(name), kShare[level]));
  }
  return raised;
}

/// All names of these parents to their safe places; then of those that this has brought into
/// trouble, until no other is. With them safe, the faces of all of these are drawn without folds.
std::vector<std::int32_t> Repair::secureFaces(std::vector<std::int32_t> parents) {
  std::vector<std::int32_t> all;
  while (!parents.empty()) {
    for (const std::int32_t t : parents) {
      for (const std::int32_t name : namesOf(t)) put(name, safePlace(name));
    }
    all.insert(all.end(), parents.begin(), parents.end());
    std::ranges::sort(all);
    parents.clear();
    for (const std::int32_t t : parentsWith([&](std::int32_t c) { return sign(c) <= 0; })) {
      if (!std::ranges::binary_search(all, t)) parents.push_back(t);
    }
  }
  return all;
}

RepairCount Repair::run() {
  RepairCount count;
  std::vector<std::uint8_t> touched(toIndex(domain_.T.rows()), 0);
  const auto atFault = [&](std::int32_t c) { return isThin(c) || sign(c) <= 0; };
  for (auto bad = parentsWith(atFault); !bad.empty(); bad = parentsWith(atFault)) {
    for (const std::int32_t t : bad) touched[toIndex(t)] = 1;
    if (!raise(bad)) break;
  }
  const auto left = secureFaces(parentsWith([&](std::int32_t child) { return sign(child) <= 0; }));
  for (const std::int32_t t : left) touched[toIndex(t)] = 1;
  if (!left.empty()) rebuildTets(domain_, fields_, left, split_, placement_, V_);
  count.parents = std::ranges::count(touched, 1);
  count.rebuilt = static_cast<std::int64_t>(left.size());
  return count;
}

}  // namespace

mesh::Positions positionsOf(const mesh::Positions& V, const std::vector<Origin>& origin) {
  mesh::Positions all(V.rows() + static_cast<Eigen::Index>(origin.size()), 3);
  all.topRows(V.rows()) = V;
  parallelFor(static_cast<std::int64_t>(origin.size()), [&](std::int64_t k) {
    all.row(V.rows() + k) = placeOf(V, origin[toIndex(k)]).transpose();
  });
  return all;
}

RepairCount repairPlaces(const mesh::TetMesh& domain, const tissue::FieldMatrix& fields,
                         const Diagram& diagram, double thin, Split& split, Placement& placement,
                         mesh::Positions& V) {
  return Repair(domain, fields, diagram, thin, split, placement, V).run();
}

}  // namespace ecorche::envelope
