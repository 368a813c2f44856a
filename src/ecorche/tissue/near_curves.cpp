#include <ecorche/core/contract.h>
#include <ecorche/core/parallel.h>
#include <ecorche/tissue/near_curves.h>

#include <algorithm>
#include <vector>

namespace ecorche::tissue {

double correctedNearCurve(double f, double off, bool own, double target) {
  const double c = std::max(f - off, std::min(f, 0.0));
  return own ? std::min(c, std::max(f, target)) : c;
}

UncorrectedRows correctNearCurves(const domain::Domain& domain, const CoreSamples& cores,
                                  std::span<const double> targets, FieldMatrix& values) {
  EC_REQUIRE_EQ(targets.size(), cores.samples.size());
  UncorrectedRows before;
  for (const NearCurve& near : cores.nearCurves) before.vertex.push_back(near.vertex);
  std::ranges::sort(before.vertex);
  before.vertex.erase(std::ranges::unique(before.vertex).begin(), before.vertex.end());
  before.values.resize(std::ssize(before.vertex), values.cols());
  parallelFor(before.values.rows(), [&](std::int64_t i) {
    before.values.row(i) = values.row(before.vertex[static_cast<std::size_t>(i)]);
  });

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
  // A vertex may be near several curves, in their order: threads share the fields
  constexpr Eigen::Index kFields = 32;
  parallelFor((values.cols() + kFields - 1) / kFields,
              [&](std::int64_t block) {
                const Eigen::Index end = std::min((block + 1) * kFields, values.cols());
                for (const NearCurve& near : cores.nearCurves) {
                  const auto s = static_cast<std::size_t>(near.sample);
                  const Eigen::Index own = cores.samples[s].tissue.value - kFat.value;
                  auto f = values.row(near.vertex);
                  for (Eigen::Index j = block * kFields; j < end; ++j)
                    f[j] = correctedNearCurve(f[j], near.error * q(near.sample, j), j == own,
                                              targets[s]);
                }
              },
              1);
  return before;
}

void correctNearCurves(const domain::Domain& domain, const CoreSamples& cores,
                       Eigen::Ref<const Eigen::VectorXd> targets, TissueId field,
                       Eigen::Ref<Eigen::VectorXd> f) {
  EC_REQUIRE_EQ(static_cast<std::size_t>(targets.size()), cores.samples.size());
  if (cores.nearCurves.empty()) return;
  std::vector<double> q(cores.samples.size());
  for (std::size_t s = 0; s < q.size(); ++s) {
    const CoreSample& sample = cores.samples[s];
    double flux = sample.tissue == field ? targets[static_cast<Eigen::Index>(s)] : 0.0;
    for (int k = 0; k < 4; ++k) flux -= sample.barycentric[k] * f[domain.mesh.T(sample.tet, k)];
    q[s] = flux * sample.weight / sample.length;
  }
  for (const NearCurve& near : cores.nearCurves) {
    const auto s = static_cast<std::size_t>(near.sample);
    f[near.vertex] = correctedNearCurve(f[near.vertex], near.error * q[s],
                                        cores.samples[s].tissue == field, targets[near.sample]);
  }
}

}  // namespace ecorche::tissue
