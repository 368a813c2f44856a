#pragma once

#include <ecorche/authoring/curve_leaving.h>
#include <ecorche/authoring/stroke_depth.h>
#include <ecorche/mesh/types.h>

#include <optional>
#include <vector>

namespace ecorche::authoring {

/// Control points of the stroke alone, whatever lies in its way: four by least squares [ABLSJ21
/// §3.2].
/// @param path  at least two distinct points; its ends are kept
[[nodiscard]] std::vector<mesh::Vector3> fittedStroke(const std::vector<mesh::Vector3>& path);

struct StrokeCurve {
  std::vector<mesh::Vector3> points;  ///< control points
  std::optional<Leaving> leaving;     ///< no way was found that stays in the domain
};

/// A first curve along a stroke: four control points by least squares, or as many up to eight as it
/// takes, where that curve stays in the domain and keeps some room; else it is bent like a thin
/// beam, just as far as it takes, and gets up to twenty points, or some more where it would still
/// leave the domain (clearedCurve). Whether it stays there is tested at last.
///
/// @param path  the stroke in space, at least two distinct points; its ends are kept
[[nodiscard]] StrokeCurve strokeCurve(const std::vector<mesh::Vector3>& path,
                                      const StrokeRoom& room);

}  // namespace ecorche::authoring
