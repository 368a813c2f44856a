#pragma once

#include <ecorche/tissue/curve_trace.h>
#include <ecorche/tissue/tissue.h>
#include <ecorche/tissue/tissue_solver.h>

#include <catch2/catch.hpp>

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

/// Curves traced and fields solved, from nothing; fails the test where that fails.
inline tissue::TissueFields solved(const domain::Domain& domain,
                                   const std::vector<tissue::CurveTissue>& tissues,
                                   const tissue::TissueOptions& options = {}) {
  RunContext run;
  const auto cores = tissue::traceCurves(domain, tissues, options, run);
  REQUIRE(cores.has_value());
  auto fields = tissue::solveTissueFields(domain, *cores, tissues, options, run);
  REQUIRE(fields.has_value());
  return std::move(*fields);
}

}  // namespace ecorche::test
