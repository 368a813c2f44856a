#pragma once

#include "support/shapes.h"

namespace ecorche::test {

/// A ball of 20·4^n triangles whose points are then moved by `shape`.
template <class Shape>
mesh::SurfaceMesh ball(int subdivisions, const Shape& shape) {
  mesh::SurfaceMesh out = sphere(mesh::Vector3::Zero(), 1.0, subdivisions);
  out.name = "ball";
  for (Eigen::Index v = 0; v < out.V.rows(); ++v)
    out.V.row(v) = shape(mesh::Vector3(out.V.row(v).transpose())).transpose();
  return out;
}

}  // namespace ecorche::test
