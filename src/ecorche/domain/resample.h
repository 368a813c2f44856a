#pragma once

#include <ecorche/core/run_context.h>
#include <ecorche/domain/tagged_surface.h>

#include <functional>

namespace ecorche::domain {

/// A length for every point of space [m].
using LengthField = std::function<double(const mesh::Vector3&)>;

struct ResampleOptions {
  LengthField edgeLength;  ///< wanted length of edges
  LengthField tolerance;   ///< how far new triangles may lie from the old surface
  LengthField loss;        ///< how far points of the old surface may lie from the new triangles
  double spacing = 0.0;    ///< of those points [m, > 0]
  /// Where no step may make faces cross; nowhere if empty, since that takes its time.
  std::function<bool(const mesh::Vector3&)> watched;
  int rounds = 4;  ///< of split, collapse, flip and relax
};

/// The same surface with edges of wanted length, after [Botsch & Kobbelt 2004].
///
/// Curves between different tags, and ridges sharper than 60°, stay curves; their ends and corners
/// stay vertices. Vertices slide on the old surface of their own tag, so vertices on a cut plane
/// stay on it exactly. A step that would take the middle of an edge or of a triangle further than
/// the tolerance from the old surface, or the new surface further than the loss from a point of the
/// old one, is not taken, nor, where watched, one after which more faces meet: where the surface
/// bends much, and at tips, edges stay shorter than wanted.
///
/// @param surface  closed and manifold
/// @errors  MeshNotRepairable where it is not, Cancelled
[[nodiscard]] Result<TaggedSurface> resample(const TaggedSurface& surface,
                                             const std::vector<CutPlane>& cutPlanes,
                                             const ResampleOptions& options, RunContext& run);

}  // namespace ecorche::domain
