#include <ecorche/core/parallel.h>
#include <ecorche/tissue/sample_targets.h>

namespace ecorche::tissue {

double sampleTarget(const CurveTissue& tissue, const CoreSample& sample) {
  const TissueCurve& curve = tissue.curves[static_cast<std::size_t>(sample.curve)];
  return curve.spline.interpolate(curve.values, sample.u);
}

std::vector<double> sampleTargets(const std::vector<CoreSample>& samples,
                                  const std::vector<CurveTissue>& tissues) {
  std::vector<double> out(samples.size());
  parallelFor(std::ssize(samples), [&](std::int64_t i) {
    const CoreSample& s = samples[static_cast<std::size_t>(i)];
    const auto tissue = static_cast<std::size_t>(s.tissue.value - kFirstMuscle.value);
    out[static_cast<std::size_t>(i)] = sampleTarget(tissues[tissue], s);
  });
  return out;
}

}  // namespace ecorche::tissue
