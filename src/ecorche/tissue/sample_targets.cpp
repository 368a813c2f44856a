#include <ecorche/core/parallel.h>
#include <ecorche/tissue/sample_targets.h>

namespace ecorche::tissue {

std::vector<double> sampleTargets(const std::vector<CoreSample>& samples,
                                  const std::vector<CurveTissue>& tissues) {
  std::vector<double> out(samples.size());
  parallelFor(std::ssize(samples), [&](std::int64_t i) {
    const CoreSample& s = samples[static_cast<std::size_t>(i)];
    const auto tissue = static_cast<std::size_t>(s.tissue.value - kFirstMuscle.value);
    const TissueCurve& curve = tissues[tissue].curves[static_cast<std::size_t>(s.curve)];
    out[static_cast<std::size_t>(i)] = curve.spline.interpolate(curve.values, s.u);
  });
  return out;
}

}  // namespace ecorche::tissue
