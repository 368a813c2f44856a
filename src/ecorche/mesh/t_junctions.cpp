#include <ecorche/core/index.h>
#include <ecorche/mesh/surface_topology.h>
#include <ecorche/mesh/t_junctions.h>

#include <algorithm>
#include <vector>

namespace ecorche::mesh {

namespace {

/// A vertex within an edge, how far along.
struct Stop {
  double along = 0.0;
  std::int32_t vertex = 0;
  double away = 0.0;
};

/// Border vertices in order of x, to be found near an edge.
class BorderVertices {
 public:
  BorderVertices(const Positions& V, const SurfaceEdges& edges) : V_(V) {
    for (std::size_t e = 0; e < edges.count(); ++e) {
      if (edges.faceCount(e) == 1) byX_.insert(byX_.end(), {edges.ends[e][0], edges.ends[e][1]});
    }
    const auto x = [&](std::int32_t v) { return V_(v, 0); };
    std::ranges::sort(byX_, [&](std::int32_t a, std::int32_t b) {
      return x(a) < x(b) || (x(a) == x(b) && a < b);
    });
    const auto repeated = std::ranges::unique(byX_);
    byX_.erase(repeated.begin(), repeated.end());
  }

  [[nodiscard]] std::vector<Stop> within(std::int32_t a, std::int32_t b, double tolerance) const {
    const Vector3 from = V_.row(a).transpose();
    const Vector3 along = V_.row(b).transpose() - from;
    const double length = along.norm();
    std::vector<Stop> out;
    if (!(length > 4.0 * tolerance)) return out;
    const double low = std::min(V_(a, 0), V_(b, 0)) - tolerance;
    const double high = std::max(V_(a, 0), V_(b, 0)) + tolerance;
    auto it = std::ranges::lower_bound(byX_, low, {}, [&](std::int32_t v) { return V_(v, 0); });
    for (; it != byX_.end() && V_(*it, 0) <= high; ++it) {
      const Vector3 p = V_.row(*it).transpose() - from;
      const double s = p.dot(along) / (length * length);
      const double away = (p - s * along).norm();
      // Near an end it is the end's twin, and for welding to see to
      if (*it == a || *it == b || away > tolerance ||
          std::min(s, 1.0 - s) * length < 2.0 * tolerance)
        continue;
      out.push_back({s, *it, away});
    }
    std::ranges::sort(out, {}, &Stop::along);
    return out;
  }

 private:
  const Positions& V_;
  std::vector<std::int32_t> byX_;
};

}  // namespace

StepReport splitAtTJunctions(LabelledFaces& faces, double tolerance) {
  StepReport report;
  const SurfaceEdges edges = surfaceEdges(faces.F);
  const BorderVertices vertices(faces.V, edges);
  struct Fan {
    std::int32_t slot;
    std::vector<Stop> stops;
  };
  std::vector<Fan> fans;
  std::vector<char> touched(toIndex(faces.F.rows()), 0);  // one side of a face at a time
  for (std::size_t e = 0; e < edges.count(); ++e) {
    if (edges.faceCount(e) != 1) continue;
    const std::int32_t slot = edges.slot[toIndex(edges.first[e])];
    const std::int32_t f = slot / 3;
    if (touched[toIndex(f)] != 0) continue;
    const std::int32_t a = faces.F(f, slot % 3);
    const std::int32_t b = faces.F(f, (slot % 3 + 1) % 3);
    auto stops = vertices.within(a, b, tolerance);
    std::erase_if(stops, [&](const Stop& s) { return s.vertex == faces.F(f, (slot % 3 + 2) % 3); });
    if (stops.empty()) continue;
    touched[toIndex(f)] = 1;
    fans.push_back({slot, std::move(stops)});
  }
  for (const Fan& fan : fans) {
    const std::int32_t f = fan.slot / 3;
    const std::int32_t k = fan.slot % 3;
    const std::int32_t b = faces.F(f, (k + 1) % 3);
    const std::int32_t apex = faces.F(f, (k + 2) % 3);
    // The face ends at the first stop; a new one goes on from each
    faces.F(f, (k + 1) % 3) = fan.stops.front().vertex;
    const Eigen::Index first = faces.F.rows();
    faces.F.conservativeResize(first + std::ssize(fan.stops), 3);
    for (std::size_t s = 0; s < fan.stops.size(); ++s) {
      const bool last = s + 1 == fan.stops.size();
      faces.F.row(first + static_cast<Eigen::Index>(s)) << fan.stops[s].vertex,
          (last ? b : fan.stops[s + 1].vertex), apex;
      faces.label.push_back(faces.label[toIndex(f)]);
      report.see(faces.V.row(fan.stops[s].vertex).transpose(), fan.stops[s].away);
    }
  }
  return report;
}

}  // namespace ecorche::mesh
