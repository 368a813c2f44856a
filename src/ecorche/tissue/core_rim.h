#pragma once

#include <ecorche/tissue/curve_walk.h>
#include <ecorche/tissue/tissue_fields.h>
#include <ecorche/tissue/well_radius.h>

#include <vector>

namespace ecorche::tissue {

/// Points on a core's rim with the tets that hold them: what stands for a piece of curve where tets
/// are finer than the core. Points in bone are left out; where all are, the middle stands for them.
///
/// @param middle  of the piece: tet and tangent
/// @param centre  its place [m]
/// @param rho     core radius [m]
[[nodiscard]] std::vector<WellPoint> rimPoints(const CurveWalker& walker,
                                               const domain::Domain& domain,
                                               const CoreSample& middle,
                                               const mesh::Vector3& centre, double rho);

/// The piece's row shared by its points.
/// @param resistance  1/w of the piece's line [unitless]
void addRimRows(const domain::Domain& domain, const CoreSample& middle,
                const std::vector<WellPoint>& points, double resistance,
                std::vector<CoreSample>& out);

}  // namespace ecorche::tissue
