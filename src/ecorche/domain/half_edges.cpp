#include <ecorche/domain/half_edges.h>

#include <algorithm>
#include <array>
#include <utility>

namespace ecorche::domain {

Result<HalfEdges> HalfEdges::build(const TaggedSurface& surface) {
  const auto faceCount = static_cast<std::int32_t>(surface.F.rows());
  struct Side {
    std::int32_t lo, hi, face, corner;
    bool forward;
  };
  std::vector<Side> sides;
  sides.reserve(at(faceCount) * 3);
  for (std::int32_t f = 0; f < faceCount; ++f) {
    for (int k = 0; k < 3; ++k) {
      const std::int32_t a = surface.F(f, k);
      const std::int32_t b = surface.F(f, (k + 1) % 3);
      sides.push_back({std::min(a, b), std::max(a, b), f, k, a < b});
    }
  }
  std::ranges::sort(sides, [](const Side& s, const Side& t) {
    return std::tie(s.lo, s.hi, s.face) < std::tie(t.lo, t.hi, t.face);
  });

  HalfEdges he;
  he.to_.resize(sides.size());
  he.next_.resize(sides.size());
  he.face_.resize(sides.size());
  he.out_.assign(at(static_cast<std::int32_t>(surface.V.rows())), -1);
  he.side_.resize(at(faceCount));
  he.tag_ = surface.tag;
  std::vector<std::array<std::int32_t, 3>> ofFace(at(faceCount));
  for (std::size_t i = 0; i < sides.size(); i += 2) {
    const bool paired = i + 1 < sides.size() && sides[i].lo == sides[i + 1].lo &&
                        sides[i].hi == sides[i + 1].hi && sides[i].forward != sides[i + 1].forward;
    const bool third =
        i + 2 < sides.size() && sides[i].lo == sides[i + 2].lo && sides[i].hi == sides[i + 2].hi;
    if (!paired || third || sides[i].lo == sides[i].hi) {
      return fail(ErrorCode::MeshNotRepairable,
                  "the surface of the domain is not closed or not a manifold",
                  {.point = surface.V.row(sides[i].lo).transpose()});
    }
    for (std::size_t k = i; k < i + 2; ++k) {
      const Side& s = sides[k];
      he.to_[k] = s.forward ? s.hi : s.lo;
      he.face_[k] = s.face;
      he.out_[at(s.forward ? s.lo : s.hi)] = static_cast<std::int32_t>(k);
      ofFace[at(s.face)][static_cast<std::size_t>(s.corner)] = static_cast<std::int32_t>(k);
    }
  }
  std::vector<std::int32_t> degree(he.out_.size(), 0);
  for (std::int32_t f = 0; f < faceCount; ++f) {
    for (std::size_t k = 0; k < 3; ++k) {
      he.next_[at(ofFace[at(f)][k])] = ofFace[at(f)][(k + 1) % 3];
      ++degree[at(surface.F(f, static_cast<Eigen::Index>(k)))];
    }
    he.side_[at(f)] = ofFace[at(f)][0];
  }
  // All faces of a vertex must be one fan: two sheets that share a point only are no surface there
  for (std::int32_t v = 0; v < he.vertexCount(); ++v) {
    std::int32_t ring = 0;
    if (he.vertexAlive(v)) he.forOutgoing(v, [&](std::int32_t) { ++ring; });
    if (ring != degree[at(v)]) {
      return fail(ErrorCode::MeshNotRepairable,
                  "the surface of the domain touches itself in a point",
                  {.point = surface.V.row(v).transpose()});
    }
  }
  he.valence_ = std::move(degree);
  return he;
}

bool HalfEdges::adjacent(std::int32_t v, std::int32_t w) const {
  // The smaller ring: faces of a cut plane may hang in hundreds on one vertex
  if (valence(w) < valence(v)) std::swap(v, w);
  bool found = false;
  forOutgoing(v, [&](std::int32_t h) { found |= to(h) == w; });
  return found;
}

void HalfEdges::setLoop(std::int32_t x, std::int32_t y, std::int32_t z, std::int32_t f) {
  next_[at(x)] = y;
  next_[at(y)] = z;
  next_[at(z)] = x;
  face_[at(x)] = face_[at(y)] = face_[at(z)] = f;
  side_[at(f)] = x;
}

// h: a→b with apex c, its opposite o: b→a with apex d
HalfEdges::Split HalfEdges::split(std::int32_t h) {
  const std::int32_t o = opposite(h);
  const std::int32_t b = to(h);
  const std::int32_t n0 = next(h), p0 = next(n0), c = to(n0);
  const std::int32_t m0 = next(o), q0 = next(m0), d = to(m0);
  const std::int32_t m = vertexCount();
  const std::int32_t e = halfEdgeCount();  // m→b, b→m
  const std::int32_t g = e + 2;            // m→c, c→m
  const std::int32_t k = e + 4;            // m→d, d→m
  const auto f2 = static_cast<std::int32_t>(side_.size());
  const std::int32_t f3 = f2 + 1;
  to_.insert(to_.end(), {b, m, c, m, d, m});
  next_.resize(at(e + 6));
  face_.resize(at(e + 6));
  out_.push_back(g);
  valence_.push_back(4);
  ++valence_[at(c)];
  ++valence_[at(d)];
  side_.insert(side_.end(), {e, e + 1});
  const std::int32_t tag0 = tag_[at(face(h))];
  const std::int32_t tag1 = tag_[at(face(o))];
  tag_.insert(tag_.end(), {tag0, tag1});

  to_[at(h)] = m;
  out_[at(b)] = e + 1;
  setLoop(h, g, p0, face(h));
  setLoop(o, m0, k + 1, face(o));
  setLoop(e, n0, g + 1, f2);
  setLoop(e + 1, k, q0, f3);
  return {m, e};
}

bool HalfEdges::canCollapse(std::int32_t h) const {
  const std::int32_t v = from(h);
  const std::int32_t w = to(h);
  const std::int32_t c = apex(h);
  const std::int32_t d = apex(opposite(h));
  if (c == d || valence(c) <= 3 || valence(d) <= 3) return false;
  // Link condition: v and w have no neighbours in common but the two apices
  bool good = true;
  forOutgoing(v, [&](std::int32_t x) {
    const std::int32_t u = to(x);
    if (good && u != w && u != c && u != d && adjacent(u, w)) good = false;
  });
  return good;
}

void HalfEdges::collapse(std::int32_t h) {
  const std::int32_t o = opposite(h);
  const std::int32_t v = from(h), w = to(h);
  const std::int32_t n0 = next(h), p0 = next(n0), c = to(n0);  // w→c, c→v
  const std::int32_t m0 = next(o), q0 = next(m0), d = to(m0);  // v→d, d→w
  std::vector<std::int32_t> outgoing;
  forOutgoing(v, [&](std::int32_t x) { outgoing.push_back(x); });
  for (const std::int32_t x : outgoing) to_[at(opposite(x))] = w;

  // The edge w–c takes the place of v–c in the face beyond it, and d–w that of d–v
  const auto replace = [&](std::int32_t gone, std::int32_t kept) {
    const std::int32_t after = next(gone);
    const std::int32_t before = next(after);
    next_[at(kept)] = after;
    next_[at(before)] = kept;
    face_[at(kept)] = face_[at(gone)];
    side_[at(face_[at(gone)])] = kept;
  };
  const std::int32_t f0 = face(h);
  const std::int32_t f1 = face(o);
  replace(opposite(p0), n0);
  replace(opposite(m0), q0);
  out_[at(w)] = n0;
  out_[at(c)] = opposite(n0);
  out_[at(d)] = q0;
  out_[at(v)] = -1;
  valence_[at(w)] += valence_[at(v)] - 4;
  --valence_[at(c)];
  --valence_[at(d)];
  valence_[at(v)] = 0;
  for (const std::int32_t x : {h, o, p0, opposite(p0), m0, opposite(m0)}) face_[at(x)] = -1;
  side_[at(f0)] = side_[at(f1)] = -1;
}

bool HalfEdges::canFlip(std::int32_t h) const {
  const std::int32_t c = apex(h);
  const std::int32_t d = apex(opposite(h));
  return c != d && valence(from(h)) > 3 && valence(to(h)) > 3 && !adjacent(c, d);
}

void HalfEdges::flip(std::int32_t h) {
  const std::int32_t o = opposite(h);
  const std::int32_t a = from(h), b = to(h);
  const std::int32_t n0 = next(h), p0 = next(n0), c = to(n0);
  const std::int32_t m0 = next(o), q0 = next(m0), d = to(m0);
  out_[at(a)] = m0;
  out_[at(b)] = n0;
  to_[at(h)] = c;
  to_[at(o)] = d;
  --valence_[at(a)];
  --valence_[at(b)];
  ++valence_[at(c)];
  ++valence_[at(d)];
  setLoop(h, p0, m0, face(h));
  setLoop(o, q0, n0, face(o));
}

TaggedSurface HalfEdges::toSurface(const std::vector<mesh::Vector3>& positions) const {
  TaggedSurface out;
  out.V.resize(static_cast<Eigen::Index>(positions.size()), 3);
  for (std::size_t v = 0; v < positions.size(); ++v) {
    out.V.row(static_cast<Eigen::Index>(v)) = positions[v].transpose();
  }
  out.F.resize(static_cast<Eigen::Index>(side_.size()), 3);
  Eigen::Index count = 0;
  for (std::size_t f = 0; f < side_.size(); ++f) {
    if (side_[f] < 0) continue;
    const std::int32_t h = side_[f];
    out.F.row(count++) << from(h), to(h), apex(h);
    out.tag.push_back(tag_[f]);
  }
  out.F.conservativeResize(count, 3);
  return compacted(out);
}

}  // namespace ecorche::domain
