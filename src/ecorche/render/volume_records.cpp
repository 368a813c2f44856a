#include <ecorche/core/contract.h>
#include <ecorche/core/parallel.h>
#include <ecorche/render/volume_records.h>
#include <ecorche/tissue/segmentation.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <bit>
#include <cmath>

namespace ecorche::render {
namespace {

using mesh::Vector3;

constexpr std::int64_t kChunkTets = 1024;
constexpr std::size_t kJoinTexels = 64;  // changes closer than this go to the card as one
constexpr std::uint32_t kNoNormal = 0x80008000u;

std::uint32_t bits(double x) { return std::bit_cast<std::uint32_t>(static_cast<float>(x)); }

// Octahedral, twice 16 bits [Cigolle et al. 2014].
std::uint32_t packNormal(const Eigen::Vector3f& n) {
  const float sum = n.cwiseAbs().sum();
  if (!(sum > 0.0f)) return kNoNormal;
  Eigen::Vector2f p = n.head<2>() / sum;
  if (n.z() < 0.0f) {
    const Eigen::Vector2f q = p;
    p.x() = (1.0f - std::abs(q.y())) * (q.x() >= 0.0f ? 1.0f : -1.0f);
    p.y() = (1.0f - std::abs(q.x())) * (q.y() >= 0.0f ? 1.0f : -1.0f);
  }
  const auto word = [](float x) {
    const auto i = static_cast<std::int32_t>(std::lround(32767.0f * std::clamp(x, -1.0f, 1.0f)));
    return static_cast<std::uint32_t>(i) & 0xffffu;
  };
  return word(p.x()) | word(p.y()) << 16;
}

struct Candidate {
  Eigen::Index column;
  std::array<double, 4> value;  // at the tet's corners
};

// A third field shows inside a tet of two owners if and only if it beats both where they are equal
// on an edge: f_k − max(f_i, f_j) is linear on either side of that cut (DESIGN §6).
bool showsBetween(const std::array<double, 4>& i, const std::array<double, 4>& j,
                  const std::array<double, 4>& k) {
  for (std::size_t c = 0; c < 4; ++c)
    if (k[c] >= std::max(i[c], j[c])) return true;
  for (const auto& e : mesh::kTetEdge) {
    const auto a = static_cast<std::size_t>(e[0]);
    const auto b = static_cast<std::size_t>(e[1]);
    const double da = i[a] - j[a];
    const double db = i[b] - j[b];
    if ((da > 0.0) == (db > 0.0)) continue;
    const double s = da / (da - db);
    if (k[a] + s * (k[b] - k[a]) >= i[a] + s * (i[b] - i[a])) return true;
  }
  return false;
}

// Those of so many tets that a test takes, ascending.
template <class Test>
std::vector<std::int32_t> tetsWhere(Eigen::Index count, const Test& test) {
  const std::int64_t chunks = (count + kChunkTets - 1) / kChunkTets;
  std::vector<std::vector<std::int32_t>> found(static_cast<std::size_t>(chunks));
  parallelFor(
      chunks,
      [&](std::int64_t c) {
        const std::int64_t end = std::min<std::int64_t>(count, (c + 1) * kChunkTets);
        for (std::int64_t t = c * kChunkTets; t < end; ++t)
          if (test(static_cast<std::int32_t>(t)))
            found[static_cast<std::size_t>(c)].push_back(static_cast<std::int32_t>(t));
      },
      8);
  std::vector<std::int32_t> out;
  for (const auto& part : found) out.insert(out.end(), part.begin(), part.end());
  return out;
}

}  // namespace

std::vector<VolumeRecords::Range> VolumeRecords::takeChanges() {
  std::ranges::sort(changes_);
  std::vector<Range> joined;
  for (const Range& r : changes_) {
    if (!joined.empty() && r.first <= joined.back().second + kJoinTexels) {
      joined.back().second = std::max(joined.back().second, r.second);
    } else {
      joined.push_back(r);
    }
  }
  changes_.clear();
  return joined;
}

bool VolumeRecords::isCut(std::int32_t tet) const {
  if (kept_.empty()) return false;
  int count = 0;
  for (int k = 0; k < 4; ++k) count += kept_[static_cast<std::size_t>(geometry_->mesh().T(tet, k))];
  return count != 0 && count != 4;
}

std::int16_t VolumeRecords::ownerAt(std::int64_t vertex) const {
  return static_cast<std::int16_t>(tissue::ownerOf(fields_->row(vertex), fatIsCandidate_).value -
                                   1);
}

void VolumeRecords::updateOwners() {
  owner_.resize(static_cast<std::size_t>(fields_->rows()));
  parallelFor(fields_->rows(),
              [&](std::int64_t v) { owner_[static_cast<std::size_t>(v)] = ownerAt(v); });
}

// Those whose owner is another one now.
std::vector<std::int32_t> VolumeRecords::updateOwners(const std::vector<std::int32_t>& vertices) {
  std::vector<std::uint8_t> other(vertices.size(), 0);
  parallelFor(std::ssize(vertices), [&](std::int64_t i) {
    const std::int32_t v = vertices[static_cast<std::size_t>(i)];
    std::int16_t& owner = owner_[static_cast<std::size_t>(v)];
    const std::int16_t now = ownerAt(v);
    other[static_cast<std::size_t>(i)] = now != owner;
    owner = now;
  });
  std::vector<std::int32_t> out;
  for (std::size_t i = 0; i < vertices.size(); ++i)
    if (other[i] != 0) out.push_back(vertices[i]);
  return out;
}

// Whether a record tells of a column.
bool VolumeRecords::holds(std::int32_t tet, std::int32_t column) const {
  const std::int32_t slot = slotOfTet_[static_cast<std::size_t>(tet)];
  if (slot < 0) return false;
  const Drawn& drawn = drawn_[static_cast<std::size_t>(slot)];
  const Texel* record = &texels_[drawn.record];
  const std::uint32_t count = (record[3][0] & 0xffu) + (record[3][0] >> 8 & 0xffu);
  const auto idAt = [&](const Texel& t, std::uint32_t word, std::uint32_t i) {
    return static_cast<std::int32_t>((t[word + i / 2] >> (16 * (i % 2)) & 0xffffu) &
                                     ~std::uint32_t{kCutBit});
  };
  for (std::uint32_t i = 0; i < std::min(count, 4u); ++i)
    if (idAt(record[3], 2, i) == column) return true;
  // Further ones stand at the end, eight to a texel
  const Texel* further = record + drawn.size - (count > 4 ? (count - 4 + 7) / 8 : 0);
  for (std::uint32_t i = 4; i < count; ++i)
    if (idAt(further[(i - 4) / 8], 0, (i - 4) % 8) == column) return true;
  return false;
}

// Tets whose records may be other ones once these columns changed at these vertices: those with
// another owner at a corner, and those that one of the columns shows in, or did. In all others it
// lies below what shows before and after.
std::vector<std::int32_t> VolumeRecords::affected(const FieldChange& change,
                                                  const std::vector<std::int32_t>& others) const {
  const mesh::TetMesh& mesh = geometry_->mesh();
  constexpr std::uint8_t kNear = 1;
  constexpr std::uint8_t kOther = 2;
  std::vector<std::uint8_t> mark(static_cast<std::size_t>(mesh.V.rows()), 0);
  // Normals at a vertex look at its neighbours, and those at theirs
  for (const std::int32_t v : withNeighbours(*geometry_, change.vertices, 2))
    mark[static_cast<std::size_t>(v)] = kNear;
  for (const std::int32_t v : others) mark[static_cast<std::size_t>(v)] |= kOther;

  const auto covered = [&](std::int32_t t, std::int32_t column) {
    for (int o = 0; o < 4; ++o) {
      const auto owner = static_cast<Eigen::Index>(owner_[static_cast<std::size_t>(mesh.T(t, o))]);
      if (owner == column) return false;
      bool all = true;
      for (int k = 0; k < 4 && all; ++k)
        all = (*fields_)(mesh.T(t, k), column) <= (*fields_)(mesh.T(t, k), owner);
      if (all) return true;
    }
    return false;
  };
  return tetsWhere(mesh.T.rows(), [&](std::int32_t tet) {
    std::uint8_t any = 0;
    for (int k = 0; k < 4; ++k) any |= mark[static_cast<std::size_t>(mesh.T(tet, k))];
    if (any == 0) return false;
    return (any & kOther) != 0 || std::ranges::any_of(change.columns, [&](std::int32_t column) {
             return !covered(tet, column) || holds(tet, column);
           });
  });
}

// The tets that the plane cut before or cuts now.
std::vector<std::int32_t> VolumeRecords::updateClip(const std::optional<ClipPlane>& clip) {
  clip_ = clip;
  const mesh::TetMesh& mesh = geometry_->mesh();
  std::vector<std::int32_t> touched = std::move(cutTets_);
  cutTets_.clear();
  kept_.clear();
  if (!clip) return touched;
  kept_.resize(static_cast<std::size_t>(mesh.V.rows()));
  const Vector3 n = clip->normal.normalized();
  parallelFor(mesh.V.rows(), [&](std::int64_t v) {
    kept_[static_cast<std::size_t>(v)] = n.dot(mesh.V.row(v).transpose() - clip->point) >= 0.0;
  });
  cutTets_ = tetsWhere(mesh.T.rows(), [&](std::int32_t tet) { return isCut(tet); });
  touched.insert(touched.end(), cutTets_.begin(), cutTets_.end());
  return touched;
}

void VolumeRecords::update(const VolumeItem& item, const SmoothedFields& smoothed,
                           const VolumeLayer& layer, const std::optional<ClipPlane>& clip) {
  const bool otherTets = item.geometry != geometry_;
  const bool sameFields = item.fields == fields_ && item.fieldsRevision == fieldsRevision_;
  const bool nextFields = item.fieldsRevision == fieldsRevision_ + 1 && item.changed != nullptr;
  const bool all = otherTets || layer.role != layer_.role ||
                   item.fatIsCandidate != fatIsCandidate_ || !(sameFields || nextFields);
  const auto sameClip = [&] {
    if (clip.has_value() != clip_.has_value()) return false;
    return !clip || (clip->point == clip_->point && clip->normal == clip_->normal);
  };

  geometry_ = item.geometry;
  fields_ = item.fields;
  fieldsRevision_ = item.fieldsRevision;
  fatIsCandidate_ = item.fatIsCandidate;
  layer_ = layer;
  const mesh::TetMesh& mesh = geometry_->mesh();
  if (otherTets) {
    origin_ = geometry_->box().empty() ? Vector3::Zero() : geometry_->box().centre();
    slotOfTet_.assign(static_cast<std::size_t>(mesh.T.rows()), -1);
  }

  std::vector<std::int32_t> touched;
  if (otherTets || !sameClip()) touched = updateClip(clip);
  if (all) {
    EC_REQUIRE(fields_->cols() < static_cast<Eigen::Index>(kCutBit));
    updateOwners();
    rebuild(geometry_->tetsByCluster(), smoothed, true);
    return;
  }
  if (!sameFields) {
    const std::vector<std::int32_t> others = updateOwners(item.changed->vertices);
    const std::vector<std::int32_t> tets = affected(*item.changed, others);
    touched.insert(touched.end(), tets.begin(), tets.end());
  }
  std::ranges::sort(touched);
  touched.erase(std::unique(touched.begin(), touched.end()), touched.end());
  rebuild(touched, smoothed, false);
}

// Everything that can be seen in one tet; nothing is added where nothing can.
void VolumeRecords::make(std::int32_t tet, const SmoothedFields& smoothed, Chunk& out) const {
  const mesh::TetMesh& mesh = geometry_->mesh();
  std::array<std::int32_t, 4> vertex{};
  std::array<Eigen::Index, 4> owner{};
  for (std::size_t k = 0; k < 4; ++k) {
    vertex[k] = mesh.T(tet, static_cast<int>(k));
    owner[k] = owner_[static_cast<std::size_t>(vertex[k])];
  }
  const auto roleOf = [&](Eigen::Index column) {
    return layer_.role[static_cast<std::size_t>(column)];
  };
  const bool cut = isCut(tet);
  std::uint8_t boundary = 0;
  for (int k = 0; k < 4; ++k)
    if (geometry_->neighbours()(tet, k) < 0) boundary |= static_cast<std::uint8_t>(1u << k);

  // One owner all over: seen at the boundary or the cut, if at all
  const bool single = owner[0] == owner[1] && owner[0] == owner[2] && owner[0] == owner[3];
  if (single && !(cut && roleOf(owner[0]) != Role::Hidden) &&
      !(boundary != 0 && roleOf(owner[0]) == Role::Seen))
    return;

  // Candidates: owners of corners, and fields that no owner of a corner covers all over
  thread_local std::vector<Candidate> candidates;
  candidates.clear();
  const auto valuesOf = [&](Eigen::Index column) {
    std::array<double, 4> value{};
    for (std::size_t k = 0; k < 4; ++k) value[k] = (*fields_)(vertex[k], column);
    return value;
  };
  for (std::size_t k = 0; k < 4; ++k) {
    if (std::ranges::find(candidates, owner[k], &Candidate::column) == candidates.end())
      candidates.push_back({owner[k], valuesOf(owner[k])});
  }
  const std::size_t owners = candidates.size();
  if (!single) {
    for (Eigen::Index i = fatIsCandidate_ ? 0 : 1; i < fields_->cols(); ++i) {
      const std::array<double, 4> value = valuesOf(i);
      bool covered = false;
      for (std::size_t o = 0; o < owners && !covered; ++o) {
        covered = true;
        for (std::size_t k = 0; k < 4 && covered; ++k) covered = value[k] <= candidates[o].value[k];
      }
      if (covered) continue;
      if (std::ranges::find(candidates, i, &Candidate::column) != candidates.end()) continue;
      if (owners == 2 && !showsBetween(candidates[0].value, candidates[1].value, value)) continue;
      candidates.push_back({i, value});
    }
  }
  std::ranges::stable_partition(candidates,
                                [&](const Candidate& c) { return roleOf(c.column) == Role::Seen; });
  const auto seen = static_cast<std::size_t>(std::ranges::count_if(
      candidates, [&](const Candidate& c) { return roleOf(c.column) == Role::Seen; }));
  const std::size_t hidden = candidates.size() - seen;
  const bool cutShows = cut && std::ranges::any_of(candidates, [&](const Candidate& c) {
                          return roleOf(c.column) != Role::Hidden;
                        });
  if (!cutShows && !(seen > 0 && (hidden > 0 || boundary != 0))) return;
  EC_REQUIRE(candidates.size() < 128);

  // Which faces rays have to be followed from
  Made made;
  Drawn& drawn = made.drawn;
  drawn.tet = tet;
  drawn.vertex = vertex;
  const auto seenCorner = [&](std::size_t k) { return roleOf(owner[k]) == Role::Seen; };
  for (std::size_t k = 0; k < 4; ++k) {
    std::array<std::size_t, 3> corner{};
    for (std::size_t c = 0; c < 3; ++c) corner[c] = static_cast<std::size_t>(mesh::kTetFace[k][c]);
    const bool oneOwner =
        owner[corner[0]] == owner[corner[1]] && owner[corner[0]] == owner[corner[2]];
    // Where one seen tissue owns all corners it owns the face, and no ray comes from hidden there
    if (seen > 0 && hidden > 0 && !(oneOwner && seenCorner(corner[0])))
      drawn.innerFaces |= static_cast<std::uint8_t>(1u << k);
    if ((boundary >> k & 1) != 0 && seen > 0 && !(oneOwner && !seenCorner(corner[0])))
      drawn.boundaryFaces |= static_cast<std::uint8_t>(1u << k);
  }
  if (!cutShows && drawn.innerFaces == 0 && drawn.boundaryFaces == 0) return;

  // Barycentric coordinates
  const Vector3 a = mesh.V.row(vertex[0]).transpose() - origin_;
  Eigen::Matrix3d edges;
  for (int k = 1; k < 4; ++k)
    edges.col(k - 1) =
        Vector3(mesh.V.row(vertex[static_cast<std::size_t>(k)]).transpose()) - origin_ - a;
  const Eigen::Matrix3d gradient = edges.inverse();
  if (!gradient.allFinite()) return;  // no volume: rays pass it by
  for (int k = 0; k < 3; ++k) {
    drawn.barycentric.block<1, 3>(k, 0) = gradient.row(k).cast<float>();
    drawn.barycentric(k, 3) = static_cast<float>(-gradient.row(k).dot(a));
  }
  drawn.interface.setZero();
  if (seen == 1 && hidden == 1) {
    std::array<double, 4> g{};
    for (std::size_t k = 0; k < 4; ++k) g[k] = candidates[0].value[k] - candidates[1].value[k];
    const Vector3 n = gradient.transpose() * Vector3(g[1] - g[0], g[2] - g[0], g[3] - g[0]);
    const double length = n.norm();
    if (length > 0.0)
      drawn.interface << (n / length).cast<float>(), static_cast<float>((g[0] - n.dot(a)) / length);
  }

  // The record
  made.first = out.texels.size();
  for (int k = 0; k < 3; ++k)
    out.texels.push_back(
        {bits(gradient(k, 0)), bits(gradient(k, 1)), bits(gradient(k, 2)), bits(a(k))});
  const auto id = [&](std::size_t i) -> std::uint32_t {
    if (i >= candidates.size()) return 0;
    const bool shown = roleOf(candidates[i].column) == Role::Cut;
    return static_cast<std::uint32_t>(candidates[i].column) | (shown ? kCutBit : 0u);
  };
  out.texels.push_back({static_cast<std::uint32_t>(seen) | static_cast<std::uint32_t>(hidden) << 8 |
                            static_cast<std::uint32_t>(boundary) << 16,
                        static_cast<std::uint32_t>(tet), id(0) | id(1) << 16, id(2) | id(3) << 16});
  for (std::size_t i = 1; i < candidates.size(); ++i) {
    Texel t;
    for (std::size_t k = 0; k < 4; ++k)
      t[k] = bits(candidates[i].value[k] - candidates[0].value[k]);
    out.texels.push_back(t);
  }
  for (std::size_t i = 0; i < seen; ++i)
    for (std::size_t j = seen; j < candidates.size(); ++j) {
      Texel t;
      for (std::size_t k = 0; k < 4; ++k)
        t[k] = packNormal(interfaceNormal(*geometry_, smoothed, vertex[k], candidates[i].column,
                                          candidates[j].column));
      out.texels.push_back(t);
    }
  std::int32_t face = geometry_->firstBoundaryFace(tet);
  for (int k = 0; k < 4; ++k) {
    if ((boundary >> k & 1) == 0) continue;
    const auto& normal = geometry_->boundaryNormals(face++);
    out.texels.push_back({packNormal(normal[0]), packNormal(normal[1]), packNormal(normal[2]), 0});
  }
  for (std::size_t i = 4; i < candidates.size(); i += 8)
    out.texels.push_back({id(i) | id(i + 1) << 16, id(i + 2) | id(i + 3) << 16,
                          id(i + 4) | id(i + 5) << 16, id(i + 6) | id(i + 7) << 16});
  drawn.size = static_cast<std::uint32_t>(out.texels.size() - made.first);
  out.made.push_back(made);
}

void VolumeRecords::remove(std::int32_t tet) {
  const std::int32_t slot = slotOfTet_[static_cast<std::size_t>(tet)];
  if (slot < 0) return;
  Drawn& drawn = drawn_[static_cast<std::size_t>(slot)];
  freeRecords_[drawn.size].push_back(drawn.record);
  drawn.size = 0;
  auto& list = slotsOfCluster_[static_cast<std::size_t>(geometry_->clusterOf(tet))];
  list.erase(std::ranges::find(list, slot));
  freeSlots_.push_back(slot);
  slotOfTet_[static_cast<std::size_t>(tet)] = -1;
  --drawnCount_;
}

void VolumeRecords::store(const Made& made, const Chunk& from) {
  const std::int32_t tet = made.drawn.tet;
  const auto texels = from.texels.begin() + static_cast<std::ptrdiff_t>(made.first);
  std::int32_t slot = slotOfTet_[static_cast<std::size_t>(tet)];
  if (slot >= 0) {
    Drawn& now = drawn_[static_cast<std::size_t>(slot)];
    if (now.size == made.drawn.size) {
      const std::uint32_t record = now.record;
      now = made.drawn;
      now.record = record;
      if (std::equal(texels, texels + now.size, texels_.begin() + record)) return;
      std::copy_n(texels, now.size, texels_.begin() + record);
      changes_.emplace_back(record, record + now.size);
      return;
    }
    remove(tet);
  }
  std::uint32_t record = 0;
  auto& free = freeRecords_[made.drawn.size];
  if (free.empty()) {
    record = static_cast<std::uint32_t>(texels_.size());
    texels_.resize(texels_.size() + made.drawn.size);
  } else {
    record = free.back();
    free.pop_back();
  }
  if (freeSlots_.empty()) {
    slot = static_cast<std::int32_t>(drawn_.size());
    drawn_.emplace_back();
  } else {
    slot = freeSlots_.back();
    freeSlots_.pop_back();
  }
  drawn_[static_cast<std::size_t>(slot)] = made.drawn;
  drawn_[static_cast<std::size_t>(slot)].record = record;
  slotOfTet_[static_cast<std::size_t>(tet)] = slot;
  slotsOfCluster_[static_cast<std::size_t>(geometry_->clusterOf(tet))].push_back(slot);
  std::copy_n(texels, made.drawn.size, texels_.begin() + record);
  changes_.emplace_back(record, record + made.drawn.size);
  ++drawnCount_;
}

// @param all  every tet there is: records are laid out afresh
void VolumeRecords::rebuild(const std::vector<std::int32_t>& tets, const SmoothedFields& smoothed,
                            bool all) {
  const auto count = static_cast<std::int64_t>(tets.size());
  const std::int64_t chunkCount = (count + kChunkTets - 1) / kChunkTets;
  std::vector<Chunk> chunks(static_cast<std::size_t>(chunkCount));
  parallelFor(
      chunkCount,
      [&](std::int64_t c) {
        const std::int64_t end = std::min(count, (c + 1) * kChunkTets);
        for (std::int64_t i = c * kChunkTets; i < end; ++i)
          make(tets[static_cast<std::size_t>(i)], smoothed, chunks[static_cast<std::size_t>(c)]);
      },
      1);
  if (all) {
    std::ranges::fill(slotOfTet_, -1);
    drawn_.clear();
    freeSlots_.clear();
    slotsOfCluster_.assign(static_cast<std::size_t>(geometry_->clusterCount()), {});
    texels_.clear();
    freeRecords_.clear();
    changes_.clear();
    drawnCount_ = 0;
  }
  std::size_t next = 0;
  for (const Chunk& chunk : chunks)
    for (const Made& made : chunk.made) {
      // What lies between two tets that are drawn is not, or not any more
      for (; !all && tets[next] != made.drawn.tet; ++next) remove(tets[next]);
      ++next;
      store(made, chunk);
    }
  for (; !all && next < tets.size(); ++next) remove(tets[next]);
  if (all) changes_.assign(1, {0, texels_.size()});
}

}  // namespace ecorche::render
