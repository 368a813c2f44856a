#include <ecorche/core/contract.h>
#include <ecorche/core/parallel.h>
#include <ecorche/tissue/near_curves.h>

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
  for (const NearCurve& near : cores.nearCurves)
    values.row(near.vertex) -= near.error * q.row(near.sample);
}

}  // namespace ecorche::tissue
