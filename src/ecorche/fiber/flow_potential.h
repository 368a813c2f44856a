#pragma once

#include <ecorche/domain/domain.h>
#include <ecorche/fiber/curve_guide.h>
#include <ecorche/fiber/fiber_ends.h>
#include <ecorche/fiber/muscle_mesh.h>

namespace ecorche::fiber {

/// The potential u of the flow through one muscle, and its gradient.
struct FlowPotential {
  Eigen::VectorXd u;         ///< #V of the muscle, in [0, 1] up to rounding and poor tets
  mesh::Positions gradient;  ///< #T×3 of the muscle [1/m]; zero in specks
};

/// @param nearestOfTet  per tet of the muscle, at its centroid
/// @errors SystemSingular
[[nodiscard]] Result<FlowPotential> solveFlow(const MuscleMesh& muscle,
                                              const envelope::Anatomy& anatomy,
                                              const domain::Domain& domain,
                                              const SelectedEnds& ends, const CurveGuide& guide,
                                              const std::vector<CurveGuide::Nearest>& nearestOfTet,
                                              const FiberOptions& options, const std::string& name);

}  // namespace ecorche::fiber
