#include <ecorche/tissue/nearest_samples.h>

#include <algorithm>

namespace ecorche::tissue {

void NearestSamples::add(const domain::Domain& domain, const Well& well, const mesh::Vector3& at,
                         std::int32_t sample) {
  for (const LineError& e : well.errors) {
    const double away2 = (domain.mesh.V.row(e.vertex).transpose() - at).squaredNorm();
    const auto [known, fresh] = nearest_.try_emplace(e.vertex, Entry{sample, e.error, away2});
    if (fresh || !(away2 < known->second.away2)) continue;
    known->second = {sample, e.error, away2};
  }
}

std::vector<NearCurve> NearestSamples::byVertex() const {
  std::vector<NearCurve> out;
  out.reserve(nearest_.size());
  for (const auto& [vertex, entry] : nearest_) out.push_back({vertex, entry.sample, entry.error});
  std::ranges::sort(out, {}, &NearCurve::vertex);
  return out;
}

}  // namespace ecorche::tissue
