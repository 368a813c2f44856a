#pragma once

#include <ecorche/mesh/tet_mesh.h>

namespace ecorche::mesh {

/// Sign of the volume of tet abcd, decided exactly: 1 positively oriented, -1 negatively, 0 the
/// four points lie in a plane. Floating point where its error bound suffices, expansions elsewhere
/// [Shewchuk 1997]; exact while products of three coordinate differences neither overflow nor
/// underflow (coordinates from 1e-70 to 1e+70).
[[nodiscard]] int orientation(const Vector3& a, const Vector3& b, const Vector3& c,
                              const Vector3& d);
[[nodiscard]] int orientation(const TetMesh& mesh, Eigen::Index tet);

}  // namespace ecorche::mesh
