#include <ecorche/core/contract.h>
#include <ecorche/tissue/segmentation.h>
#include <ecorche/tissue/target_volume.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace ecorche::tissue {

namespace {

constexpr double kNear = 5e-4;  // relative
constexpr double kMost = 1e4;   // factor either way
constexpr int kSteps = 40;

std::vector<std::vector<double>> timesFactor(std::vector<std::vector<double>> values,
                                             double factor) {
  for (auto& curve : values) {
    for (double& value : curve) value *= factor;
  }
  return values;
}

}  // namespace

double volumeOf(const ValueFields& fields, std::size_t tissue) {
  return tissueVolume(fields.domain().mesh, fields.fields(), fields.owners(),
                      TissueId(kFirstMuscle.value + static_cast<std::int64_t>(tissue)));
}

Result<std::vector<std::vector<double>>> valuesForVolume(ValueFields& fields, std::size_t tissue,
                                                         double volume, RunContext& run) {
  EC_REQUIRE(volume > 0.0);
  std::vector<std::vector<double>> start;
  for (const TissueCurve& curve : fields.tissues()[tissue].curves) start.push_back(curve.values);
  std::optional<Error> failed;
  const auto volumeAt = [&](double factor) {
    auto done = fields.setValues(tissue, timesFactor(start, factor), run);
    if (!done) failed = done.error();
    return done ? volumeOf(fields, tissue) : 0.0;
  };
  const auto putBack = [&] {
    RunContext always;  // what was ready is ready: nothing to wait for
    (void)fields.setValues(tissue, start, always);
  };

  // Volume grows with the factor: first a bracket, then halving and secants in logarithms
  double lo = 1.0;
  double hi = 1.0;
  double volumeLo = volumeAt(1.0);
  double volumeHi = volumeLo;
  while (!failed && volumeHi < volume && hi < kMost) {
    lo = hi;
    volumeLo = volumeHi;
    hi *= 2.0;
    volumeHi = volumeAt(hi);
  }
  while (!failed && volumeLo > volume && lo > 1.0 / kMost) {
    hi = lo;
    volumeHi = volumeLo;
    lo *= 0.5;
    volumeLo = volumeAt(lo);
  }
  double best = std::abs(volumeLo - volume) < std::abs(volumeHi - volume) ? lo : hi;
  double volumeBest = best == lo ? volumeLo : volumeHi;
  for (int k = 0; !failed && k < kSteps && std::abs(volumeBest - volume) > kNear * volume; ++k) {
    if (volumeHi < volume || volumeLo > volume) break;
    double share = volumeHi > volumeLo && volumeLo > 0.0
                       ? std::log(volume / volumeLo) / std::log(volumeHi / volumeLo)
                       : 0.5;
    if (k % 3 == 2) share = 0.5;  // a secant may creep
    best = lo * std::pow(hi / lo, std::clamp(share, 0.02, 0.98));
    volumeBest = volumeAt(best);
    if (volumeBest < volume) {
      lo = best;
      volumeLo = volumeBest;
    } else {
      hi = best;
      volumeHi = volumeBest;
    }
  }
  putBack();
  if (failed) return tl::unexpected<Error>(std::move(*failed));
  if (std::abs(volumeBest - volume) > 1e-3 * volume) {
    const std::string& name = fields.tissues()[tissue].name;
    return fail(
        ErrorCode::ValueOutOfRange,
        fmt::format("\"{}\" cannot have {:.4g} cm³: {:.4g} cm³ is what its neighbours, skin "
                    "and bones leave it; make those thinner, or move its curve",
                    name, 1e6 * volume, 1e6 * volumeBest),
        {.object = name});
  }
  return timesFactor(start, best);
}

}  // namespace ecorche::tissue
