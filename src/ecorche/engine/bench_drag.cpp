#include <ecorche/core/parallel.h>
#include <ecorche/engine/bench_drag.h>
#include <ecorche/engine/build.h>
#include <ecorche/engine/inputs.h>
#include <ecorche/model/project_check.h>
#include <ecorche/tissue/curve_trace.h>
#include <ecorche/tissue/drag_ground.h>
#include <ecorche/tissue/segmentation.h>
#include <ecorche/tissue/value_fields.h>

#include <fmt/format.h>

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <set>

namespace ecorche::engine {

namespace {

class Clock {
 public:
  [[nodiscard]] double seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
  }

 private:
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};

Result<tissue::CurveRef> find(const std::vector<tissue::CurveTissue>& tissues,
                              const DragScript& script) {
  const auto there = std::ranges::find(tissues, script.muscle, &tissue::CurveTissue::name);
  if (there == tissues.end() || script.curve >= there->curves.size() ||
      script.point >= there->curves[script.curve].values.size()) {
    return fail(
        ErrorCode::UnknownName,
        fmt::format("drag \"{}\": there is no muscle \"{}\" with a curve {} of {} points or "
                    "more; name one of the project's",
                    script.name, script.muscle, script.curve + 1, script.point + 1),
        {.object = script.name});
  }
  if (!there->anisotropy.isIsotropic()) {
    return fail(ErrorCode::ValueOutOfRange,
                fmt::format("drag \"{}\": \"{}\" is anisotropic, which drags do not follow yet",
                            script.name, script.muscle),
                {.object = script.name});
  }
  return tissue::CurveRef{static_cast<std::size_t>(there - tissues.begin()),
                          static_cast<std::int32_t>(script.curve)};
}

// What users of libigl get: the same matrix, ordered by AMD, factored column by column
double simplicialSeconds(const tissue::TissueSolver& solver, const tissue::CoreSamples& cores,
                         Eigen::Index fields) {
  const mesh::StiffnessPattern& pattern = solver.pattern();
  std::vector<double> K = solver.stiffness();
  tissue::addRows(solver.domain(), pattern, cores.samples, 1.0, K);
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

mesh::Vector3 DragScript::offset(int frame) const {
  if (path.size() < 2) return mesh::Vector3::Zero();
  const mesh::Spline way(path);
  return way.at(way.parameterAt(way.length() * frame / frames)) - path.front();
}

Result<DragBench> benchDrag(const model::Project& project, std::optional<std::int64_t> tets,
                            const std::vector<DragScript>& scripts, int checked, bool simplicial,
                            RunContext& run) {
  if (auto sound = model::checkProject(project); !sound) return passOn(sound);
  auto prepared = prepareDomain(project, {.tets = tets}, run);
  if (!prepared) return passOn(prepared);
  const auto domain = std::make_shared<const domain::Domain>(std::move(prepared->build.domain));
  const std::vector<tissue::CurveTissue> tissues = curveTissues(project);
  const tissue::TissueOptions how = tissueOptions(project);
  for (const DragScript& script : scripts) {
    if (const auto there = find(tissues, script); !there) return passOn(there);
  }
  auto made = tissue::TissueSolver::create(*domain, run);
  if (!made) return passOn(made);
  const auto solver = std::make_shared<const tissue::TissueSolver>(std::move(*made));
  const auto walker = std::make_shared<const tissue::CurveWalker>(*domain);
  tissue::KeptTraces kept;
  const auto cores = tissue::traceCurves(*walker, *domain, tissues, how, run, kept);
  if (!cores) return passOn(cores);

  DragBench out;
  out.tets = domain->mesh.T.rows();
  out.freeVertices = domain->freeVertexCount();
  out.tissues = tissues.size();
  if (simplicial) out.simplicial = simplicialSeconds(*solver, *cores, std::ssize(tissues) + 1);
  {
    const auto factor = solver->factorise(*cores, how, run);
    if (!factor) return passOn(factor);
    const Clock clock;
    const tissue::DragGround ground(solver, *factor, *cores);
    out.ground = clock.seconds();
  }
  for (const DragScript& script : scripts) {
    const tissue::CurveRef curve = *find(tissues, script);
    auto fields = tissue::ValueFields::create(domain, solver, *cores, tissues, how, run, walker);
    if (!fields) return passOn(fields);
    const std::vector<TissueId> before = fields->owners();
    const Eigen::MatrixXd settled = fields->fields().values;
    DragRun done;
    done.name = script.name;
    {
      const Clock clock;
      fields->prepareMove({curve});
      done.begin = clock.seconds() - out.ground;
    }
    const std::vector<mesh::Vector3> points =
        tissues[curve.tissue].curves[script.curve].spline.points();
    // Muscles involved: whose field changes somewhere by more than a hundredth during the drag
    std::set<TissueId> involved;
    std::vector<std::int64_t> other;
    std::vector<std::map<TissueId, std::int64_t>> owned;
    for (int frame = 1; frame <= script.frames; ++frame) {
      if (run.cancelled()) return fail(ErrorCode::Cancelled, "bench drag");
      auto moved = points;
      moved[script.point] += domain->skinDiagonal * script.offset(frame);
      const mesh::Spline spline(moved);
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
    for (std::size_t i = 0; i < other.size(); ++i) {
      std::int64_t vertices = 0;
      for (const TissueId id : involved) vertices += owned[i][id];
      done.ownerShare.push_back(static_cast<double>(other[i]) /
                                static_cast<double>(std::max<std::int64_t>(1, vertices)));
    }
    out.runs.push_back(std::move(done));
  }
  return out;
}

}  // namespace ecorche::engine
