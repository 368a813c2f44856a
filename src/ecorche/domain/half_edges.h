#pragma once

#include <ecorche/core/result.h>
#include <ecorche/domain/tagged_surface.h>

#include <vector>

namespace ecorche::domain {

/// Connectivity of a closed triangle surface that is being resampled. Half-edges 2e and 2e + 1 are
/// the two sides of edge e. Removed vertices and faces stay as holes in the numbering (-1) until
/// toSurface().
class HalfEdges {
 public:
  /// @errors MeshNotRepairable where an edge has not exactly two faces that agree on its direction
  [[nodiscard]] static Result<HalfEdges> build(const TaggedSurface& surface);

  [[nodiscard]] std::int32_t halfEdgeCount() const { return static_cast<std::int32_t>(to_.size()); }
  [[nodiscard]] std::int32_t vertexCount() const { return static_cast<std::int32_t>(out_.size()); }
  [[nodiscard]] bool edgeAlive(std::int32_t h) const { return face_[at(h)] >= 0; }
  [[nodiscard]] bool vertexAlive(std::int32_t v) const { return out_[at(v)] >= 0; }

  [[nodiscard]] static std::int32_t opposite(std::int32_t h) { return h ^ 1; }
  [[nodiscard]] std::int32_t to(std::int32_t h) const { return to_[at(h)]; }
  [[nodiscard]] std::int32_t from(std::int32_t h) const { return to_[at(h ^ 1)]; }
  [[nodiscard]] std::int32_t next(std::int32_t h) const { return next_[at(h)]; }
  [[nodiscard]] std::int32_t face(std::int32_t h) const { return face_[at(h)]; }
  [[nodiscard]] std::int32_t tag(std::int32_t h) const { return tag_[at(face_[at(h)])]; }
  /// The corner of h's face that h does not touch.
  [[nodiscard]] std::int32_t apex(std::int32_t h) const { return to(next(h)); }
  [[nodiscard]] std::int32_t someOutgoing(std::int32_t v) const { return out_[at(v)]; }
  /// The next outgoing half-edge around from(h).
  [[nodiscard]] std::int32_t around(std::int32_t h) const { return next(h ^ 1); }

  /// fn(outgoing half-edge) for each; fn returns nothing.
  template <class Fn>
  void forOutgoing(std::int32_t v, const Fn& fn) const {
    const std::int32_t first = someOutgoing(v);
    std::int32_t h = first;
    do {
      fn(h);
      h = around(h);
    } while (h != first);
  }

  [[nodiscard]] std::int32_t valence(std::int32_t v) const { return valence_[at(v)]; }
  [[nodiscard]] bool adjacent(std::int32_t v, std::int32_t w) const;

  /// A new vertex in the middle of h; h then ends there. @return the vertex; edge(from new to old
  /// end) is the half-edge that someOutgoing of the old end's side gives.
  struct Split {
    std::int32_t vertex;
    std::int32_t second;  ///< half-edge from the new vertex to where h ended before
  };
  Split split(std::int32_t h);
  /// Closed surfaces stay closed and manifold if from(h) goes to to(h).
  [[nodiscard]] bool canCollapse(std::int32_t h) const;
  /// from(h) vanishes into to(h). The merged edges keep the ids of the edges at to(h).
  void collapse(std::int32_t h);
  [[nodiscard]] bool canFlip(std::int32_t h) const;
  void flip(std::int32_t h);

  /// Faces in order of their numbers, vertices with the positions given by number.
  [[nodiscard]] TaggedSurface toSurface(const std::vector<mesh::Vector3>& positions) const;

 private:
  /// Half-edges x, y, z become the sides of face f, in this order.
  void setLoop(std::int32_t x, std::int32_t y, std::int32_t z, std::int32_t f);
  static std::size_t at(std::int32_t i) { return static_cast<std::size_t>(i); }

  std::vector<std::int32_t> to_, next_, face_;  // per half-edge
  std::vector<std::int32_t> out_, valence_;     // per vertex
  std::vector<std::int32_t> side_, tag_;  // per face: one of its half-edges (-1: gone), its tag
};

}  // namespace ecorche::domain
