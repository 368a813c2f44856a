#pragma once

#include <ecorche/tissue/tissue.h>

namespace ecorche::test {

/// A muscle of one curve with the same value at all of its points.
inline tissue::CurveTissue muscle(std::string name, std::vector<mesh::Vector3> points,
                                  double value = 1.0) {
  tissue::CurveTissue out;
  out.name = std::move(name);
  const std::size_t count = points.size();
  out.curves.push_back({"", mesh::Spline(std::move(points)), std::vector<double>(count, value)});
  return out;
}

}  // namespace ecorche::test
