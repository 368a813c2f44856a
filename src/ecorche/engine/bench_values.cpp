#include <ecorche/engine/bench_values.h>
#include <ecorche/engine/build.h>
#include <ecorche/engine/clock.h>
#include <ecorche/model/project_check.h>
#include <ecorche/tissue/curve_trace.h>
#include <ecorche/tissue/segmentation.h>
#include <ecorche/tissue/value_fields.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace ecorche::engine {

namespace {

constexpr std::size_t kMuscles = 12;
constexpr int kBaselines = 3;

}  // namespace

double Times::quantile(double q) const {
  if (seconds.empty()) return 0.0;
  std::vector<double> sorted = seconds;
  std::ranges::sort(sorted);
  const auto last = static_cast<double>(sorted.size() - 1);
  return sorted[static_cast<std::size_t>(std::ceil(q * last))];
}

Result<ValuesBench> benchValues(const model::Project& project, std::optional<std::int64_t> tets,
                                int edits, RunContext& run) {
  if (auto sound = model::checkProject(project); !sound) return passOn(sound);
  auto prepared = prepareDomain(project, {.tets = tets}, run);
  if (!prepared) return passOn(prepared);
  const auto domain = std::make_shared<const domain::Domain>(std::move(prepared->build.domain));
  std::vector<tissue::CurveTissue> tissues = curveTissues(project);
  tissue::TissueOptions how = tissueOptions(project);
  auto made = tissue::TissueSolver::create(*domain, run);
  if (!made) return passOn(made);
  const auto solver = std::make_shared<const tissue::TissueSolver>(std::move(*made));
  auto cores = tissue::traceCurves(*domain, tissues, how, run);
  if (!cores) return passOn(cores);
  auto live = tissue::ValueFields::create(domain, solver, *cores, tissues, how, run);
  if (!live) return passOn(live);

  ValuesBench out;
  out.tets = domain->mesh.T.rows();
  out.freeVertices = domain->freeVertexCount();
  out.tissues = tissues.size();
  std::mt19937_64 random(1);
  const auto between = [&](double lo, double hi) {
    return std::uniform_real_distribution<double>(lo, hi)(random);
  };

  // An artist goes from muscle to muscle and drags sliders at each
  const std::size_t muscles = std::min(kMuscles, tissues.size());
  const int each = std::max(1, edits / static_cast<int>(muscles));
  for (std::size_t m = 0; m < muscles; ++m) {
    const std::size_t t = m * tissues.size() / muscles;
    std::vector<std::vector<double>> values;
    for (const tissue::TissueCurve& curve : tissues[t].curves) values.push_back(curve.values);
    const auto edit = [&](Times& times) -> Result<void> {
      const Clock clock;
      if (auto changed = live->setValues(t, values, run); !changed) return passOn(changed);
      times.seconds.push_back(clock.seconds());
      return {};
    };
    Result<void> done;
    for (std::size_t c = 0; c < values.size() && done; ++c) {
      for (std::size_t p = 0; p < values[c].size() && done; ++p) {
        values[c][p] *= between(0.8, 1.25);
        done = edit(c == 0 && p == 0 ? out.touch : out.point);
      }
    }
    for (int k = 0; k < each && done; ++k) {
      auto& curve = values[random() % values.size()];
      curve[random() % curve.size()] *= between(0.8, 1.25);
      done = edit(out.value);
    }
    const double factor = between(0.8, 1.25);
    for (auto& curve : values) {
      for (double& value : curve) value *= factor;
    }
    if (done) done = edit(out.whole);
    if (!done) return passOn(done);
    for (std::size_t c = 0; c < values.size(); ++c) tissues[t].curves[c].values = values[c];
    if (run.cancelled()) return fail(ErrorCode::Cancelled, "bench values");
    run.progress("edits", (m + 1.0) / static_cast<double>(muscles));
  }
  (void)live->setFat(how.fat);  // its first touch
  for (int k = 0; k < std::max(1, edits / 4); ++k) {
    how.fat = between(0.1, 0.5);
    const Clock clock;
    (void)live->setFat(how.fat);
    out.fat.seconds.push_back(clock.seconds());
  }

  for (int k = 0; k < kBaselines; ++k) {
    const Clock clock;
    auto fields = solver->solve(*cores, tissues, how, run);
    if (!fields) return passOn(fields);
    const auto owners = tissue::vertexOwners(*fields);
    out.again.seconds.push_back(clock.seconds());
    out.fieldError =
        (fields->values - live->fields().values).cwiseAbs().maxCoeff() / fields->maxValue;
    std::int64_t other = 0;
    for (std::size_t v = 0; v < owners.size(); ++v) other += owners[v] != live->owners()[v];
    out.ownerShare = static_cast<double>(other) / static_cast<double>(owners.size());
  }
  return out;
}

}  // namespace ecorche::engine
