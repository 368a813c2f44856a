#pragma once

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Surface_mesh.h>
#include <ecorche/mesh/surface_mesh.h>

#include <optional>

namespace ecorche::mesh {

/// For translation units that speak CGAL: no public header includes this one.
using CgalKernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using CgalSurface = CGAL::Surface_mesh<CgalKernel::Point_3>;

/// Vertices in order, those that no face uses left out; nothing for a mesh that is not an oriented
/// manifold.
[[nodiscard]] std::optional<CgalSurface> toCgal(const SurfaceMesh& mesh);

/// Collects garbage first. Without parts.
[[nodiscard]] SurfaceMesh fromCgal(CgalSurface& surface, std::string name);

}  // namespace ecorche::mesh
