#pragma once

#include <ecorche/domain/tagged_surface.h>

namespace ecorche::domain {

/// The same surface without edges of no length, which exact cuts leave where ridges cross and
/// rounding puts both ends of an edge to the same place. Edges stay whose faces would fall upon one
/// another, and surfaces that are not closed and manifold stay as they are.
[[nodiscard]] TaggedSurface withoutNullEdges(const TaggedSurface& surface);

}  // namespace ecorche::domain
