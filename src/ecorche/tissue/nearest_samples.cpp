#include <ecorche/tissue/nearest_samples.h>

#include <algorithm>
#include <tuple>

namespace ecorche::tissue {

void NearestSamples::add(const domain::Domain& domain, const Well& well, const mesh::Vector3& at,
                         std::int32_t sample) {
  for (const LineError& e : well.errors) {
    const double away2 = (domain.mesh.V.row(e.vertex).transpose() - at).squaredNorm();
    entries_.push_back({{e.vertex, sample, e.error}, away2});
  }
}

std::vector<NearCurve> NearestSamples::byVertex() {
  std::ranges::sort(entries_, [](const Entry& a, const Entry& b) {
    return std::tie(a.what.vertex, a.away2, a.what.sample) <
           std::tie(b.what.vertex, b.away2, b.what.sample);
  });
  std::vector<NearCurve> out;
  for (const Entry& e : entries_) {
    if (out.empty() || out.back().vertex != e.what.vertex) out.push_back(e.what);
  }
  return out;
}

}  // namespace ecorche::tissue
