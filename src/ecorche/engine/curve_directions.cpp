#include <ecorche/core/parallel.h>
#include <ecorche/engine/curve_directions.h>

#include <limits>

namespace ecorche::engine {

std::shared_ptr<const mesh::Directions> curveDirections(
    const mesh::Positions& V, const std::vector<TissueId>& owner,
    const std::vector<std::vector<std::vector<mesh::Vector3>>>& lines) {
  auto out = std::make_shared<mesh::Directions>(mesh::Directions::Zero(V.rows(), 3));
  parallelFor(V.rows(), [&](std::int64_t v) {
    const TissueId id = owner[static_cast<std::size_t>(v)];
    const mesh::Vector3 p = V.row(v).transpose();
    double nearest = std::numeric_limits<double>::infinity();
    for (const auto& line : lines[static_cast<std::size_t>(id.value - 1)]) {
      for (std::size_t k = 1; k < line.size(); ++k) {
        const double away = (0.5 * (line[k - 1] + line[k]) - p).squaredNorm();
        if (away >= nearest) continue;
        nearest = away;
        out->row(v) = (line[k] - line[k - 1]).normalized().transpose();
      }
    }
  });
  return out;
}

}  // namespace ecorche::engine
