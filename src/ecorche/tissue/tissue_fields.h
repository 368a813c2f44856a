#pragma once

#include <ecorche/core/finding.h>
#include <ecorche/core/result.h>
#include <ecorche/core/run_context.h>
#include <ecorche/domain/domain.h>
#include <ecorche/tissue/tissue.h>

#include <Eigen/Core>
#include <vector>

namespace ecorche::tissue {

/// Values of all fields at the vertices. Column 0 is fat (tissue id 1), column i the tissue of id i
/// + 1.
using FieldMatrix =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;  // #V×#fields

/// A point where a curve was tied to the domain: one row of B.
struct CoreSample {
  TissueId tissue;
  std::int32_t curve = 0;  ///< within its tissue
  std::int32_t tet = -1;
  Eigen::Vector4d barycentric = Eigen::Vector4d::Zero();
  double u = 0.0;       ///< spline parameter of the point
  double length = 0.0;  ///< of the piece of curve inside the tet [m]
  double weight = 0.0;  ///< W
  mesh::Vector3 tangent = mesh::Vector3::UnitX();
};

/// What the tets make of the line at a vertex near a curve: with flux q per length at the sample,
/// fields come out too large by q times the error.
struct NearCurve {
  std::int32_t vertex = -1;
  std::int32_t sample = -1;  ///< of the curve's, the one nearest to the vertex
  double error = 0.0;        // [unitless]
};

/// Where every curve touches the domain.
struct CoreSamples {
  std::vector<CoreSample> samples;    ///< by tissue, curve, parameter
  std::vector<NearCurve> nearCurves;  ///< by tissue, curve, vertex; none with the paper's rows
  Findings findings;                  ///< pieces of curve lost in bone, ends pulled onto bone …
  std::vector<double>
      coveredShare;  ///< per tissue: share of its curves' length that lies in the domain
};

/// Rows of fields as the equations gave them, where something was corrected afterwards.
struct UncorrectedRows {
  std::vector<std::int32_t> vertex;  ///< ascending
  FieldMatrix values;                ///< #vertex×(#tissues + 1)
};

struct TissueFields {
  FieldMatrix values;           ///< #V×(#tissues + 1)
  UncorrectedRows uncorrected;  ///< near curves
  bool fatIsCandidate = true;   ///< false where TissueOptions::fat is 0
  double maxValue = 0.0;        ///< largest tissue value and fat, the scale for tolerances
  double undershoot = 0.0;      ///< how far any field falls below 0, over maxValue
  double overshoot = 0.0;       ///< how far any field exceeds its own largest value, over maxValue
  Findings findings;            ///< slivers whose part in the energy was capped
};

}  // namespace ecorche::tissue
