#pragma once

#include <ecorche/domain/domain.h>
#include <ecorche/mesh/spline.h>
#include <ecorche/mesh/tet_locator.h>
#include <ecorche/tissue/well_radius.h>

#include <optional>
#include <vector>

namespace ecorche::tissue {

/// A maximal run of a curve inside one tet, in spline parameters.
struct CurvePiece {
  std::int32_t tet = -1;
  double u0 = 0.0;
  double u1 = 0.0;
};

/// A run of a curve outside the domain: before it enters (no exit), after it left (no entry), or
/// between.
struct CurveGap {
  double u0 = 0.0;
  double u1 = 0.0;
  std::optional<domain::BoundaryTag> exit;   ///< boundary face through which the curve left at u0
  std::optional<domain::BoundaryTag> entry;  ///< boundary face through which it came back at u1
};

/// What a curve passes through; pieces and gaps cover [0, last parameter] in order, each list by
/// itself.
struct CurveWalk {
  std::vector<CurvePiece> pieces;
  std::vector<CurveGap> gaps;
};

/// Walks curves from tet to tet through shared faces [ABLSJ21 §3.4]; looks a tet up in the grid
/// only at the start, behind a gap, and where the walk loses its way. Chords of a quarter of the
/// local tet stand for the curve between tets.
///
/// Safe to use from several threads. Keeps a reference to the domain.
class CurveWalker {
 public:
  explicit CurveWalker(const domain::Domain& domain);

  [[nodiscard]] CurveWalk walk(const mesh::Spline& spline) const;

  /// The tet that holds p, looked for from a tet nearby; -1 outside.
  [[nodiscard]] std::int32_t find(std::int32_t from, const mesh::Vector3& p) const;
  /// Mean edge of every tet, #T [m].
  [[nodiscard]] const Eigen::VectorXd& meanEdges() const { return meanEdges_; }
  /// What its tets make of a line.
  [[nodiscard]] const WellSolver& wells() const { return wells_; }

 private:
  struct Leg;
  const domain::Domain& domain_;
  mesh::TetLocator locator_;
  Eigen::VectorXd meanEdges_;
  WellSolver wells_;
  std::vector<std::int32_t> tagSlot_;  // sorted 4·tet + corner of boundary faces …
  std::vector<std::int32_t> tagFace_;  // … and their place in the domain's boundary
  double outsideStep_ = 0.0;

  [[nodiscard]] Leg leg(std::int32_t tet, const mesh::Vector3& p, const mesh::Vector3& q) const;
  [[nodiscard]] domain::BoundaryTag tagOf(std::int32_t tet, int corner) const;
};

}  // namespace ecorche::tissue
