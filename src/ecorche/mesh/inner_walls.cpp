#include <ecorche/core/index.h>
#include <ecorche/mesh/disjoint_sets.h>
#include <ecorche/mesh/hole_fill.h>
#include <ecorche/mesh/inner_walls.h>
#include <ecorche/mesh/orientation.h>
#include <ecorche/mesh/surface_topology.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <vector>

namespace ecorche::mesh {

namespace {

// A face has two sides: where its normal points, and behind it.
std::int32_t front(std::int32_t face) { return 2 * face; }
std::int32_t back(std::int32_t face) { return 2 * face + 1; }

/// The faces at an edge in the order in which a turn around it meets them.
class Turn {
 public:
  Turn(const LabelledFaces& faces, const SurfaceEdges& edges) : faces_(faces), edges_(edges) {}

  /// Slots of SurfaceEdges; the turn is counter-clockwise for someone who looks at the edge's first
  /// end from its second. Nothing where two of more than two faces lie upon one another there.
  [[nodiscard]] std::optional<std::vector<std::int32_t>> around(std::size_t e) const {
    std::vector<std::int32_t> slots(edges_.slot.begin() + edges_.first[e],
                                    edges_.slot.begin() + edges_.first[e + 1]);
    if (slots.size() < 3) return slots;
    const Vector3 a = at(edges_.ends[e][0]);
    const Vector3 b = at(edges_.ends[e][1]);
    const Vector3 start = apex(slots.front());
    struct Ray {
      std::int32_t slot;
      Vector3 apex;
      int sector;  // 0 the first face, 1 less than half a turn on, 2 half a turn, 3 more
    };
    std::vector<Ray> rays;
    for (const std::int32_t slot : slots) {
      const Vector3 p = apex(slot);
      const int side = orientation(a, b, start, p);
      const Vector3 along = (b - a).normalized();
      const Vector3 aside = (start - a) - (start - a).dot(along) * along;
      const bool opposite = side == 0 && aside.dot(p - a) < 0.0;
      rays.push_back({slot, p, side > 0 ? 1 : side < 0 ? 3 : opposite ? 2 : 0});
    }
    std::ranges::sort(rays, [&](const Ray& x, const Ray& y) {
      if (x.sector != y.sector) return x.sector < y.sector;
      return x.sector % 2 == 1 && orientation(a, b, x.apex, y.apex) > 0;
    });
    for (std::size_t k = 1; k < rays.size(); ++k) {
      const bool same = rays[k].sector == rays[k - 1].sector;
      if (same && orientation(a, b, rays[k - 1].apex, rays[k].apex) == 0) return std::nullopt;
    }
    std::ranges::transform(rays, slots.begin(), &Ray::slot);
    return slots;
  }

  /// The side of the face that looks on along the turn, and the one that looks back.
  [[nodiscard]] std::int32_t onward(std::size_t e, std::int32_t slot) const {
    return runsUp(e, slot) ? front(slot / 3) : back(slot / 3);
  }
  [[nodiscard]] std::int32_t backward(std::size_t e, std::int32_t slot) const {
    return runsUp(e, slot) ? back(slot / 3) : front(slot / 3);
  }

 private:
  [[nodiscard]] Vector3 at(std::int32_t v) const { return faces_.V.row(v).transpose(); }
  [[nodiscard]] Vector3 apex(std::int32_t slot) const {
    return at(faces_.F(slot / 3, (slot % 3 + 2) % 3));
  }
  [[nodiscard]] bool runsUp(std::size_t e, std::int32_t slot) const {
    return faces_.F(slot / 3, slot % 3) == edges_.ends[e][0];
  }

  const LabelledFaces& faces_;
  const SurfaceEdges& edges_;
};

/// What the faces divide space into, piece by piece: every piece has rooms of its own.
class Rooms {
 public:
  Rooms(const LabelledFaces& faces, const SurfaceEdges& edges, double holeRel)
      : faces_(faces), edges_(edges), pieces_(components(faces.F, edges)) {
    pieceOf_.resize(toIndex(pieces_.count));
    join();
    lookAtHoles(holeRel);
    measure();
    findOutsides();
    findSolids();
    findContraries();
  }

  /// Inside on both sides of it.
  [[nodiscard]] bool isWall(std::int32_t face) const {
    return !pieceAt(face).unclear && rooms_[roomAt(front(face))].solid &&
           rooms_[roomAt(back(face))].solid;
  }

 private:
  struct Piece {
    Box box;
    std::int32_t outside = -1;  // the room around it
    double outward = 0.0;       // area that looks to the outside, without what looks away [m²]
    bool unclear = false;
  };
  struct Room {
    std::int32_t piece = -1;
    double volume = 0.0;  // of the room around a piece: what it lacks [m³]
    bool atSkin = false;  // a neighbour of the outside
    bool seen = false;    // some face looks into it
    bool left = false;    // some face looks out of it
    bool solid = false;
  };

  [[nodiscard]] std::size_t roomAt(std::int32_t side) const {
    return toIndex(room_[toIndex(side)]);
  }
  [[nodiscard]] Piece& pieceAt(std::int32_t face) {
    return pieceOf_[toIndex(pieces_.label[toIndex(face)])];
  }
  [[nodiscard]] const Piece& pieceAt(std::int32_t face) const {
    return pieceOf_[toIndex(pieces_.label[toIndex(face)])];
  }
  [[nodiscard]] std::int32_t faceCount() const {
    return static_cast<std::int32_t>(faces_.F.rows());
  }
  [[nodiscard]] Vector3 corner(std::int32_t face, int k) const {
    return faces_.V.row(faces_.F(face, k)).transpose();
  }
  [[nodiscard]] bool isOutside(std::size_t room) const {
    return toIndex(pieceOf_[toIndex(rooms_[room].piece)].outside) == room;
  }

  // Sides that see each other around an edge are of one room. At an open edge none do: what is
  // missing there is taken for filled.
  void join() {
    DisjointSets sides(2 * toIndex(faceCount()));
    const Turn turn(faces_, edges_);
    for (std::size_t e = 0; e < edges_.count(); ++e) {
      if (edges_.faceCount(e) < 2) continue;
      const auto order = turn.around(e);
      if (!order) {
        pieceAt(edges_.slot[toIndex(edges_.first[e])] / 3).unclear = true;
        continue;
      }
      for (std::size_t k = 0; k < order->size(); ++k) {
        const std::int32_t next = (*order)[(k + 1) % order->size()];
        sides.unite(turn.onward(e, (*order)[k]), turn.backward(e, next));
      }
    }
    rooms_.resize(toIndex(sides.label(room_)));
  }

  void lookAtHoles(double holeRel) {
    for (std::int32_t f = 0; f < faceCount(); ++f) {
      for (int k = 0; k < 3; ++k) pieceAt(f).box.add(corner(f, k));
    }
    for (const Border& border : borders(edges_)) {
      Box box;
      for (const std::int32_t e : border.edges) {
        for (const std::int32_t v : edges_.ends[toIndex(e)]) box.add(faces_.V.row(v).transpose());
      }
      for (const std::int32_t e : border.edges) {
        Piece& piece = pieceAt(edges_.slot[toIndex(edges_.first[toIndex(e)])] / 3);
        if (!isSmallHole(box.diagonal(), border.edges.size(), piece.box.diagonal(), holeRel))
          piece.unclear = true;
      }
    }
  }

  void measure() {
    area_.resize(toIndex(faceCount()));
    for (std::int32_t f = 0; f < faceCount(); ++f) {
      const Vector3 centre = pieceAt(f).box.centre();
      const Vector3 a = corner(f, 0) - centre;
      const Vector3 b = corner(f, 1) - centre;
      const Vector3 c = corner(f, 2) - centre;
      const double volume = a.dot(b.cross(c)) / 6.0;
      area_[toIndex(f)] = 0.5 * (b - a).cross(c - a).norm();
      for (const std::int32_t side : {front(f), back(f)}) {
        rooms_[roomAt(side)].piece = pieces_.label[toIndex(f)];
        rooms_[roomAt(side)].volume += side == back(f) ? volume : -volume;
      }
    }
  }

  // The room around a piece is the one whose walls enclose less than nothing; where two do, the
  // piece is folded through itself.
  void findOutsides() {
    const auto none = [&](const Room& room, const Piece& piece) {
      return room.volume > -1e-12 * std::pow(piece.box.diagonal(), 3.0);
    };
    for (std::size_t r = 0; r < rooms_.size(); ++r) {
      Piece& piece = pieceOf_[toIndex(rooms_[r].piece)];
      if (none(rooms_[r], piece)) continue;
      if (piece.outside >= 0) piece.unclear = true;
      piece.outside = static_cast<std::int32_t>(r);
    }
    for (Piece& piece : pieceOf_) piece.unclear = piece.unclear || piece.outside < 0;
  }

  // A hollow is a room away from the skin into which all its walls look; all others are inside.
  void findSolids() {
    for (std::int32_t f = 0; f < faceCount(); ++f) {
      Room& before = rooms_[roomAt(front(f))];
      Room& behind = rooms_[roomAt(back(f))];
      if (&before == &behind) continue;
      before.seen = true;
      behind.left = true;
      if (isOutside(roomAt(front(f)))) {
        behind.atSkin = true;
        pieceAt(f).outward += area_[toIndex(f)];
      }
      if (isOutside(roomAt(back(f)))) {
        before.atSkin = true;
        pieceAt(f).outward -= area_[toIndex(f)];
      }
    }
    for (std::size_t r = 0; r < rooms_.size(); ++r) {
      Room& room = rooms_[r];
      const bool turned = pieceOf_[toIndex(room.piece)].outward < 0.0;  // inside out altogether
      room.solid = !isOutside(r) && (room.atSkin || (turned ? room.seen : room.left));
    }
  }

  void findContraries() {
    for (std::int32_t f = 0; f < faceCount(); ++f) {
      const bool before = rooms_[roomAt(front(f))].solid;
      const bool behind = rooms_[roomAt(back(f))].solid;
      Piece& piece = pieceAt(f);
      if (before != behind && before != (piece.outward < 0.0)) piece.unclear = true;
    }
  }

  const LabelledFaces& faces_;
  const SurfaceEdges& edges_;
  FaceComponents pieces_;
  std::vector<Piece> pieceOf_;      // by label
  std::vector<std::int32_t> room_;  // #F·2, of every side
  std::vector<Room> rooms_;
  std::vector<double> area_;  // #F [m²]
};

}  // namespace

StepReport dropInnerWalls(LabelledFaces& faces, double holeRel) {
  StepReport report;
  const SurfaceEdges edges = surfaceEdges(faces.F);
  bool crowded = false;
  for (std::size_t e = 0; e < edges.count() && !crowded; ++e) crowded = edges.faceCount(e) > 2;
  if (!crowded) return report;

  const Rooms rooms(faces, edges, holeRel);
  std::vector<char> kept(faces.label.size());
  for (std::size_t f = 0; f < kept.size(); ++f)
    kept[f] = rooms.isWall(static_cast<std::int32_t>(f)) ? 0 : 1;

  // A wall hangs together by edges that are its own
  DisjointSets walls(kept.size());
  for (std::size_t e = 0; e < edges.count(); ++e) {
    const std::int32_t u = edges.first[e];
    if (edges.faceCount(e) == 2)
      walls.unite(edges.slot[toIndex(u)] / 3, edges.slot[toIndex(u + 1)] / 3);
  }
  std::map<std::int32_t, Box> boxes;  // of each, by its first face
  for (std::size_t f = 0; f < kept.size(); ++f) {
    if (kept[f] != 0) continue;
    Box& box = boxes[walls.root(static_cast<std::int32_t>(f))];
    for (int k = 0; k < 3; ++k)
      box.add(faces.V.row(faces.F(static_cast<Eigen::Index>(f), k)).transpose());
  }
  for (const auto& [face, box] : boxes) report.see(box.centre(), box.diagonal());
  if (report.count > 0) faces.keep(kept);
  return report;
}

}  // namespace ecorche::mesh
