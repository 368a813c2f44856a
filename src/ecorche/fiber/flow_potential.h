#pragma once

#include <ecorche/domain/domain.h>
#include <ecorche/fiber/curve_guide.h>
#include <ecorche/fiber/fiber_ends.h>
#include <ecorche/fiber/muscle_mesh.h>

namespace ecorche::fiber {

/// The potential u of the flow through one muscle, and its gradient.
struct FlowPotential {
  /// #V of the muscle: in every piece 0 is the mean over the origins and 1 over the insertions, by
  /// what flows there; a shorter head begins (ends) between.
  Eigen::VectorXd u;
  mesh::Positions gradient;  ///< #T×3 of the muscle [1/m]; zero in unended pieces
};

/// Minimises ½ ∫ ∇uᵀ A ∇u less what flows in times u, A = I + γ φ (I − t tᵀ).
///
/// @param nearestOfTet  per tet of the muscle, at its centroid
/// @errors SystemSingular
[[nodiscard]] Result<FlowPotential> solveFlow(const MuscleMesh& muscle,
                                              const envelope::Anatomy& anatomy,
                                              const domain::Domain& domain,
                                              const SelectedEnds& ends, const CurveGuide& guide,
                                              const std::vector<CurveGuide::Nearest>& nearestOfTet,
                                              const FiberOptions& options, const std::string& name);

/// How far along its own head each vertex is: 0 at its origin, 1 at its insertion. Heads' shares
/// pass into one another with the distance to their curves.
/// @return  #V; u itself where the muscle has one curve
[[nodiscard]] Eigen::VectorXd progressAlongHeads(const MuscleMesh& muscle, const SelectedEnds& ends,
                                                 const CurveGuide& guide, const Eigen::VectorXd& u);

}  // namespace ecorche::fiber
