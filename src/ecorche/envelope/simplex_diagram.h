#pragma once

#include <ecorche/envelope/candidates.h>
#include <ecorche/envelope/diagram.h>

#include <vector>

namespace ecorche::envelope {

/// Owners met between the ends of edge ab, in order from a (a < b, owners i ≠ j at the ends): the
/// upper envelope of lines over an interval, walked from crossing to crossing. Empty for most
/// edges.
[[nodiscard]] std::vector<std::int32_t> ownersBetween(const tissue::FieldMatrix& fields,
                                                      const Candidates& candidates,
                                                      const Edge& edge, std::int32_t i,
                                                      std::int32_t j);

/// Points of a face where three fields tie on top, ascending.
///
/// @param seen  owners on the face's edges, ascending; gains those that show in the interior only
[[nodiscard]] std::vector<Triple> pointsOfFace(const tissue::FieldMatrix& fields,
                                               const Candidates& candidates, const Face& face,
                                               std::vector<std::int32_t>& seen);

/// Points of a tet where four fields tie on top, ascending.
///
/// @param corners  of the tet, ascending
/// @param seen     owners on the tet's boundary, ascending; gains those that show in the interior
/// only
[[nodiscard]] std::vector<Quad> pointsOfTet(const tissue::FieldMatrix& fields,
                                            const Candidates& candidates, std::int32_t tet,
                                            const std::array<std::int32_t, 4>& corners,
                                            std::vector<std::int32_t>& seen);

}  // namespace ecorche::envelope
