#include <ecorche/core/parallel.h>
#include <ecorche/engine/bench_drag.h>
#include <ecorche/engine/drag_scene.h>
#include <ecorche/tissue/drag_ground.h>
#include <ecorche/tissue/segmentation.h>
#include <ecorche/tissue/settling.h>
#include <ecorche/tissue/value_fields.h>
#include <fmt/format.h>

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <map>
#include <set>

namespace ecorche::engine {

namespace {

// What users of libigl get: the same matrix, ordered by AMD, factored column by column
double simplicialSeconds(const tissue::TissueSolver& solver, const tissue::CoreSamples& cores,
                         Eigen::Index fields) {
  const mesh::StiffnessPattern& pattern = solver.pattern();
  std::vector<double> K = solver.stiffness();
  tissue::addRows(solver.domain().mesh, pattern, cores.samples, 1.0, K);
  const Eigen::Index n = pattern.rowCount();
  const Eigen::Map<const Eigen::SparseMatrix<double>> lower(
      n, n, static_cast<Eigen::Index>(K.size()), pattern.first.data(), pattern.index.data(),
      K.data());
  const Eigen::MatrixXd right = Eigen::MatrixXd::Ones(n, fields);
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor;
  factor.analyzePattern(lower);
  const Clock clock;
  factor.factorize(lower);
  const Eigen::MatrixXd X = factor.solve(right);
  return X.allFinite() ? clock.seconds() : 0.0;
}

}  // namespace

Result<DragBench> benchDrag(const model::Project& project, std::optional<std::int64_t> tets,
                            const std::vector<DragScript>& scripts, int checked, bool simplicial,
                            RunContext& run) {
  const auto scene = prepareDragScene(project, tets, scripts, run);
  if (!scene) return passOn(scene);
  const auto& [domain, tissues, how, solver, walker, curves] = *scene;
  tissue::KeptTraces kept;
  const auto cores = tissue::traceCurves(*walker, *domain, tissues, how, run, kept);
  if (!cores) return passOn(cores);

  DragBench out;
  out.tets = domain->mesh.T.rows();
  out.freeVertices = domain->freeVertexCount();
  out.tissues = tissues.size();
  if (simplicial) out.simplicial = simplicialSeconds(*solver, *cores, std::ssize(tissues) + 1);
  tissue::Settling settling(solver);
  for (std::size_t i = 0; i < scripts.size(); ++i) {
    const DragScript& script = scripts[i];
    const tissue::CurveRef curve = curves[i];
    auto fields = tissue::ValueFields::create(domain, settling, *cores, tissues, how, run, walker);
    if (!fields) return passOn(fields);
    const std::vector<TissueId> before = fields->owners();
    const Eigen::MatrixXd settled = fields->fields().values;
    DragRun done;
    done.name = script.name;
    {
      const Clock clock;
      fields->prepareMove({curve});
      done.begin = clock.seconds();
    }
    // Muscles involved: whose field changes somewhere by more than a hundredth during the drag
    std::set<TissueId> involved;
    std::vector<std::int64_t> other;
    std::vector<std::map<TissueId, std::int64_t>> owned;
    for (int frame = 1; frame <= script.frames; ++frame) {
      if (run.cancelled()) return fail(ErrorCode::Cancelled, "bench drag");
      const mesh::Spline spline = scene->splineAt(script, curve, frame);
      const Clock clock;
      const auto changed = fields->moveCurves({{curve, spline}});
      done.frame.seconds.push_back(clock.seconds());
      run.progress(script.name, static_cast<double>(frame) / script.frames);
      if (frame % checked != 0) continue;
      done.changedShare.push_back(static_cast<double>(changed.vertices.size()) /
                                  static_cast<double>(before.size()));
      auto now = tissues;
      now[curve.tissue].curves[script.curve].spline = spline;
      const Clock baseline;
      const auto traced = tissue::traceCurves(*walker, *domain, now, how, run, kept);
      if (!traced) {
        ++done.unchecked;
        continue;
      }
      const auto fresh = solver->solve(*traced, now, how, run);
      if (!fresh) return passOn(fresh);
      const auto owners = tissue::vertexOwners(*fresh);
      done.again.seconds.push_back(baseline.seconds());
      const Eigen::RowVectorXd change =
          (fresh->values - settled).cwiseAbs().colwise().maxCoeff() / fresh->maxValue;
      done.fieldError.push_back((fresh->values - fields->fields().values).cwiseAbs().maxCoeff() /
                                fresh->maxValue);
      for (Eigen::Index j = 1; j < change.size(); ++j) {
        if (change[j] > 0.01) involved.insert(TissueId(kFat.value + j));
      }
      std::int64_t& wrong = other.emplace_back(0);
      std::map<TissueId, std::int64_t>& count = owned.emplace_back();
      for (std::size_t v = 0; v < owners.size(); ++v) {
        ++count[owners[v]];
        wrong += owners[v] != fields->owners()[v];
      }
    }
    for (std::size_t k = 0; k < other.size(); ++k) {
      std::int64_t vertices = 0;
      for (const TissueId id : involved) vertices += owned[k][id];
      done.ownerShare.push_back(static_cast<double>(other[k]) /
                                static_cast<double>(std::max<std::int64_t>(1, vertices)));
    }
    out.runs.push_back(std::move(done));
  }
  return out;
}

}  // namespace ecorche::engine
