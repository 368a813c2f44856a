#pragma once

#include <ecorche/mesh/surface_mesh.h>

#include <cstdint>
#include <functional>

namespace ecorche::test {

// What happens to meshes on their way to us, done to good ones on purpose. Each takes a good mesh
// and gives a bad one of the same name; chance comes from a seed, so that every run sees the same.

using mesh::SurfaceMesh;
using mesh::Vector3;

using Place = std::function<bool(const Vector3&)>;

/// Half axes along x, y, z about a centre; `levels` as for sphere.
[[nodiscard]] SurfaceMesh egg(const Vector3& centre, const Vector3& axes, int levels,
                              const char* name);
[[nodiscard]] SurfaceMesh ball(const Vector3& centre, double radius, const char* name);

/// The same shape of rings about z; with an odd number of rings one lies at the centre's height.
[[nodiscard]] SurfaceMesh ringedEgg(const Vector3& centre, const Vector3& axes, int rings,
                                    int segments, const char* name);

/// All faces look the other way.
[[nodiscard]] SurfaceMesh insideOut(SurfaceMesh m);
/// This share of the faces, by chance, looks the other way.
[[nodiscard]] SurfaceMesh flipped(SurfaceMesh m, double share, std::uint64_t seed);
/// Without the faces whose middle is there.
[[nodiscard]] SurfaceMesh without(SurfaceMesh m, const Place& there);
/// Without this share of the faces, by chance.
[[nodiscard]] SurfaceMesh riddled(SurfaceMesh m, double share, std::uint64_t seed);
/// Every face with vertices of its own, each moved by up to `shake` [m].
[[nodiscard]] SurfaceMesh exploded(const SurfaceMesh& m, double shake, std::uint64_t seed);
/// Cut apart along z = `height`; the upper half lifted by `gap` [m].
[[nodiscard]] SurfaceMesh cracked(const SurfaceMesh& m, double height, double gap);
/// Every vertex moved by up to `reach` [m] along each axis.
[[nodiscard]] SurfaceMesh noisy(SurfaceMesh m, double reach, std::uint64_t seed);
/// This share of the faces once more; turned: facing the other way.
[[nodiscard]] SurfaceMesh doubled(SurfaceMesh m, double share, bool turned, std::uint64_t seed);
/// Both surfaces as one mesh without parts, vertices not merged.
[[nodiscard]] SurfaceMesh together(const std::vector<SurfaceMesh>& meshes, const char* name);
/// The same surface about its box's centre, larger or smaller.
[[nodiscard]] SurfaceMesh scaled(SurfaceMesh m, double factor);
/// The same about the origin, as a wrong unit does it.
[[nodiscard]] SurfaceMesh inUnits(SurfaceMesh m, double factor);
[[nodiscard]] SurfaceMesh moved(SurfaceMesh m, const Vector3& by);
/// Points there are pushed by a vector: a dent that comes out on the other side folds the surface.
[[nodiscard]] SurfaceMesh pushed(SurfaceMesh m, const Place& there, const Vector3& by);
/// A bag of this depth and mouth pushed in along −direction from `at` on the surface, as a mouth
/// is.
[[nodiscard]] SurfaceMesh pocketed(SurfaceMesh m, const Vector3& at, double mouth, double depth);
/// Every face cut into four, `times` times, vertices staying on the faces.
[[nodiscard]] SurfaceMesh subdivided(SurfaceMesh m, int times);
/// Every n-th face gets a vertex in the middle of one of its edges that its neighbour lacks.
[[nodiscard]] SurfaceMesh withTJunctions(SurfaceMesh m, int every);
/// Every n-th face is cut in three by a point so near an edge that two of them are needles.
[[nodiscard]] SurfaceMesh withNeedles(SurfaceMesh m, int every);
/// A disc across the inside at z = `height`, hung up at the surface: the middle wall of a model
/// mirrored and joined. `m` has vertices at that height all around.
[[nodiscard]] SurfaceMesh withInnerWall(SurfaceMesh m, double height);
/// This many tetrahedra of this size around a centre.
[[nodiscard]] SurfaceMesh withCrumbs(const SurfaceMesh& m, int count, double size,
                                     const Vector3& centre, double spread, std::uint64_t seed);

/// This many narrow open sheets of this length, each a part, standing about a centre.
[[nodiscard]] SurfaceMesh withSheets(const SurfaceMesh& m, int count, double length,
                                     const Vector3& centre, double spread, std::uint64_t seed);

[[nodiscard]] double volumeOf(const SurfaceMesh& m);

}  // namespace ecorche::test
