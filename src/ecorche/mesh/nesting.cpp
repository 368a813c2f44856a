#include <ecorche/core/index.h>
#include <ecorche/mesh/nesting.h>
#include <ecorche/mesh/surface_query.h>

#include <algorithm>
#include <memory>
#include <optional>

namespace ecorche::mesh {

namespace {

bool around(const Box& outer, const Box& inner) {
  return (outer.lo.array() <= inner.lo.array()).all() &&
         (outer.hi.array() >= inner.hi.array()).all();
}

class Nesting {
 public:
  Nesting(const Positions& V, const Triangles& F, const FaceComponents& pieces,
          const std::vector<char>& mayHold)
      : V_(V), F_(F), pieces_(pieces), faces_(facesByPiece(pieces)), own_(faces_.size()) {
    for (const auto& faces : faces_) {
      Box box;
      for (const Eigen::Index f : faces) {
        for (int k = 0; k < 3; ++k) box.add(corner(f, k));
      }
      boxes_.push_back(box);
    }
    for (Eigen::Index f = 0; f < F.rows(); ++f) {
      if (mayHold[toIndex(pieces.label[toIndex(f)])] != 0) holding_.push_back(f);
    }
    const Triangles all = F(holding_, Eigen::all);
    all_.emplace(V, all);
  }

  /// A ray out of the piece meets everything that holds it; each of these is then asked itself.
  [[nodiscard]] std::vector<std::int32_t> holdersOf(std::int32_t piece) {
    const Vector3 kAside(0.36, 0.48, 0.8);
    std::vector<std::int32_t> met;
    const Vector3 from = corner(faces_[toIndex(piece)].front(), 0);
    for (const SurfaceQuery::Hit& hit : all_->allHits(from, kAside))
      met.push_back(pieces_.label[toIndex(holding_[toIndex(hit.face)])]);
    std::ranges::sort(met);
    const auto repeated = std::ranges::unique(met);
    met.erase(repeated.begin(), repeated.end());
    std::erase_if(met, [&](std::int32_t outer) { return outer == piece || !holds(outer, piece); });
    return met;
  }

 private:
  [[nodiscard]] Vector3 corner(Eigen::Index f, int k) const { return V_.row(F_(f, k)).transpose(); }
  [[nodiscard]] bool holds(std::int32_t outer, std::int32_t inner) {
    if (!around(boxes_[toIndex(outer)], boxes_[toIndex(inner)])) return false;
    auto& query = own_[toIndex(outer)];
    if (!query) {
      const Triangles F = F_(faces_[toIndex(outer)], Eigen::all);
      query = std::make_unique<SurfaceQuery>(V_, F);
    }
    for (const Eigen::Index f : faces_[toIndex(inner)]) {
      if (const auto winding = query->windingNumber(corner(f, 0))) return *winding != 0;
    }
    return false;
  }

  const Positions& V_;
  const Triangles& F_;
  const FaceComponents& pieces_;
  std::vector<std::vector<Eigen::Index>> faces_;  // by piece
  std::vector<Box> boxes_;
  std::vector<Eigen::Index> holding_;  // faces of all that may hold
  std::optional<SurfaceQuery> all_;    // over these
  std::vector<std::unique_ptr<SurfaceQuery>> own_;
};

}  // namespace

std::vector<std::vector<Eigen::Index>> facesByPiece(const FaceComponents& pieces) {
  std::vector<std::vector<Eigen::Index>> out(toIndex(pieces.count));
  for (std::size_t f = 0; f < pieces.label.size(); ++f)
    out[toIndex(pieces.label[f])].push_back(static_cast<Eigen::Index>(f));
  return out;
}

std::vector<std::vector<std::int32_t>> holders(const Positions& V, const Triangles& F,
                                               const FaceComponents& pieces,
                                               const std::vector<char>& mayHold,
                                               const std::vector<char>& asked) {
  std::vector<std::vector<std::int32_t>> out(toIndex(pieces.count));
  if (std::ranges::count(mayHold, 0) == std::ssize(mayHold)) return out;
  Nesting nesting(V, F, pieces, mayHold);
  for (std::int32_t p = 0; p < pieces.count; ++p) {
    if (asked[toIndex(p)] != 0) out[toIndex(p)] = nesting.holdersOf(p);
  }
  return out;
}

}  // namespace ecorche::mesh
