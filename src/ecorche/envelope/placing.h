#pragma once

#include <ecorche/envelope/anatomy.h>
#include <ecorche/envelope/diagram.h>

#include <cstdint>
#include <vector>

namespace ecorche::envelope {

/// How a new vertex came to its place.
enum class Placed : std::uint8_t {
  Exact,    ///< where the fields tie
  Clamped,  ///< moved away from the boundary of its simplex, or from its neighbour on an edge
  Repaired  ///< moved further, so that tets around it have volume
};

/// Where the diagram's names lie, as weights of the domain's vertices. Index k is vertex #V + k.
struct Placement {
  std::vector<Anatomy::Origin> origin;
  std::vector<Placed> placed;
};

/// @param clamp  points of edges stay in [clamp, 1 − clamp] and that far apart, points of faces and
/// tets keep weights
///               of at least clamp (smaller where an edge is too crowded for that). Unset: places
///               as they are, zeros included
[[nodiscard]] Placement placeNames(const mesh::Tets& T, const tissue::FieldMatrix& fields,
                                   const Diagram& diagram, std::optional<double> clamp);

/// Places that are good whatever the fields are: points of an edge evenly spaced, points of a face
/// and of a tet in the middle of their neighbours in the diagram. On a face that is a drawing
/// without folds [Tutte 1963].
class SafePlaces {
 public:
  SafePlaces(const mesh::Tets& T, const Diagram& diagram) : T_(T), d_(diagram) {}

  [[nodiscard]] Anatomy::Origin ofCrossing(std::int32_t edge, std::int32_t crossing) const;
  /// All points of a face, in their order.
  [[nodiscard]] std::vector<Anatomy::Origin> ofFace(std::int32_t face) const;
  /// All points inside a tet with three or more owners, in their order.
  [[nodiscard]] std::vector<Anatomy::Origin> ofTet(std::int32_t complex) const;

 private:
  [[nodiscard]] std::int32_t edgeIndex(std::int32_t a, std::int32_t b) const;

  const mesh::Tets& T_;
  const Diagram& d_;
};

/// Weights (1 − share)·a + share·b; both over the same corners.
[[nodiscard]] Anatomy::Origin blend(const Anatomy::Origin& a, const Anatomy::Origin& b,
                                    double share);

}  // namespace ecorche::envelope
