#include <ecorche/core/contract.h>
#include <ecorche/core/parallel.h>
#include <ecorche/tissue/near_curves.h>

#include <algorithm>

namespace ecorche::tissue {

void correctNearCurves(const domain::Domain& domain, const CoreSamples& cores,
                       std::span<const double> targets, FieldMatrix& values) {
  EC_REQUIRE_EQ(targets.size(), cores.samples.size());
  if (cores.nearCurves.empty()) return;

  // Flux per length of every sample in every field, before anything is changed
  FieldMatrix q(static_cast<Eigen::Index>(cores.samples.size()), values.cols());
  parallelFor(q.rows(), [&](std::int64_t s) {
    const CoreSample& sample = cores.samples[static_cast<std::size_t>(s)];
    auto flux = q.row(s);
    flux.setZero();
    for (int k = 0; k < 4; ++k)
      flux -= sample.barycentric[k] * values.row(domain.mesh.T(sample.tet, k));
    flux[sample.tissue.value - kFat.value] += targets[static_cast<std::size_t>(s)];
    flux *= sample.weight / sample.length;
  });
  for (const NearCurve& near : cores.nearCurves) {
    const auto s = static_cast<std::size_t>(near.sample);
    const Eigen::Index own = cores.samples[s].tissue.value - kFat.value;
    auto f = values.row(near.vertex);
    for (Eigen::Index j = 0; j < values.cols(); ++j) {
      const double corrected = std::max(f[j] - near.error * q(near.sample, j), std::min(f[j], 0.0));
      f[j] = j == own ? std::min(corrected, std::max(f[j], targets[s])) : corrected;
    }
  }
}

}  // namespace ecorche::tissue
