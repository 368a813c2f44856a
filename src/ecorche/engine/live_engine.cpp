#include <ecorche/authoring/solid_bone.h>
#include <ecorche/core/give_way.h>
#include <ecorche/core/parallel.h>
#include <ecorche/engine/build.h>
#include <ecorche/engine/draft.h>
#include <ecorche/engine/live_engine.h>
#include <ecorche/engine/live_parts.h>
#include <ecorche/envelope/envelope.h>
#include <ecorche/mesh/surface_topology.h>
#include <ecorche/tissue/curve_trace.h>
#include <ecorche/tissue/segmentation.h>
#include <ecorche/tissue/settled_store.h>

#include <algorithm>
#include <condition_variable>
#include <mutex>
#include <set>
#include <thread>

namespace ecorche::engine {

namespace {

/// How far a control point may go before tets are made anew around it [share of the diagonal].
constexpr double kStay = 0.02;

struct Request {
  model::Project project;
  std::uint64_t revision = 0;
  bool anew = false;
};

/// What one kind of work depends on and what came of it. `of` is what it was made of, also where it
/// failed.
template <class T>
struct Made {
  std::optional<model::Project> of;
  Result<std::shared_ptr<T>> made = std::shared_ptr<T>();
};

/// Without muscles that have no curve yet.
model::Project withoutUnbegun(model::Project project) {
  std::erase_if(project.tissues,
                [](const model::Tissue& t) { return t.hasCurves() && t.curves.empty(); });
  return project;
}

std::vector<mesh::Vector3> controlPoints(const model::Project& project) {
  std::vector<mesh::Vector3> out;
  for (const std::size_t place : liveTissuePlaces(project)) {
    for (const model::Curve& curve : project.tissues[place].curves) {
      for (const auto& point : curve.points) out.push_back(point.at);
    }
  }
  return out;
}

/// A solver with the domain that it refers to.
struct Analysed {
  std::shared_ptr<const domain::DomainBuild> domain;
  std::shared_ptr<const tissue::CurveWalker> walker;
  tissue::KeptTraces traces;
  std::optional<tissue::Settling> settling;
  tissue::SettledStore kept{0};
  std::shared_ptr<const render::VolumeGeometry> geometry;
};

/// What the tissues at hand were made of, for tets to be made small around them: all of it or what
/// was there before, whatever has been given up meanwhile.
struct AtHand {
  std::shared_ptr<const domain::DomainBuild> domain;
  std::vector<tissue::CurveTissue> tissues;
  tissue::CoreSamples cores;
  tissue::SettledStore::Result settled;
};

struct Held {
  std::shared_ptr<const domain::DomainBuild> domain;
  tissue::TissueSolver solver;
};

/// Entries whose tissues own neighbouring vertices.
render::NeighbourPairs touching(const mesh::TetMesh& mesh, const std::vector<TissueId>& owner) {
  std::set<std::pair<std::int32_t, std::int32_t>> pairs;
  for (Eigen::Index t = 0; t < mesh.T.rows(); ++t) {
    for (int a = 0; a < 4; ++a) {
      for (int b = a + 1; b < 4; ++b) {
        const std::int32_t i = owner[static_cast<std::size_t>(mesh.T(t, a))].value;
        const std::int32_t j = owner[static_cast<std::size_t>(mesh.T(t, b))].value;
        if (i == j || std::min(i, j) < kFirstMuscle.value) continue;
        pairs.insert(std::minmax(i - kFirstMuscle.value, j - kFirstMuscle.value));
      }
    }
  }
  return {pairs.begin(), pairs.end()};
}

}  // namespace

struct LiveEngine::Impl {
  Sink sink;
  LiveOptions options;

  std::mutex mutex;
  std::condition_variable wake;
  std::optional<Request> next;
  std::shared_ptr<RunContext> running;  // of the stage at hand
  std::optional<model::Project> runningFor;
  model::Project (*runningPart)(const model::Project&) = nullptr;
  bool refining = false;
  bool gaveUp = false;
  bool quit = false;

  // The worker thread's own
  Made<const LiveMeshes> meshes;
  Made<const domain::DomainBuild> domain;
  Made<LiveTissues> tissues;
  Analysed analysed;
  AtHand atHand;
  std::vector<mesh::Vector3> sizedFor;  // control points when the domain was made
  bool isRefined = false;               // the domain knows of more than curves

  std::thread thread;

  Impl(Sink s, LiveOptions o) : sink(std::move(s)), options(o), refining(o.refine) {
    thread = std::thread([this] { loop(); });
  }
  ~Impl() {
    {
      const std::lock_guard lock(mutex);
      quit = true;
      if (running) running->cancel();
    }
    wake.notify_all();
    thread.join();
  }

  void loop();
  void answer(const Request& request);
  template <class T, class Make>
  bool bring(Made<T>& stage, const Request& request, model::Project (*part)(const model::Project&),
             const Make& make);
  static Result<std::shared_ptr<const LiveMeshes>> makeMeshes(const model::Project& project,
                                                              RunContext& run);
  Result<std::shared_ptr<const domain::DomainBuild>> makeDomain(
      const model::Project& project, std::vector<domain::WantedLength> lengths, RunContext& run);
  Result<std::shared_ptr<const domain::DomainBuild>> refineDomain(const model::Project& project,
                                                                  RunContext& run);
  Result<std::shared_ptr<LiveTissues>> makeTissues(const model::Project& project, RunContext& run);
  Result<void> analyse(RunContext& run);
  Result<tissue::SettledStore::Result> settle(const AtHand& next, const tissue::TissueOptions& how,
                                              bool& isKept, RunContext& run);
  [[nodiscard]] bool outgrown(const model::Project& project) const;
  [[nodiscard]] bool wantsRefining();
};

void LiveEngine::Impl::loop() {
  const GiveWay giveWay;  // to the view
  while (true) {
    Request request;
    {
      std::unique_lock lock(mutex);
      wake.wait(lock, [&] { return quit || next; });
      if (quit) return;
      request = std::move(*next);
      next.reset();
      gaveUp = false;
    }
    answer(request);
  }
}

void LiveEngine::Impl::answer(const Request& request) {
  if (request.anew) {
    meshes = {};
    domain = {};
    tissues = {};
  }
  const auto stop = [&] {
    const std::lock_guard lock(mutex);
    return quit || gaveUp || next.has_value();
  };
  const bool meshesThere = bring(meshes, request, meshPart,
                                 [&](RunContext& run) { return makeMeshes(request.project, run); });
  if (meshesThere && !stop()) {
    const auto before = domain.made ? *domain.made : nullptr;
    const bool domainThere = bring(domain, request, domainPart, [&](RunContext& run) {
      return makeDomain(request.project, {}, run);
    });
    if (domainThere && *domain.made != before) {
      sizedFor = controlPoints(request.project);
      isRefined = false;
    }
    if (domainThere && !stop()) {
      const auto make = [&](RunContext& run) { return makeTissues(request.project, run); };
      const bool there = bring(tissues, request, curvePart, make);
      const bool refine = there && wantsRefining();
      if (there && !stop() && ((refine && !isRefined) || outgrown(request.project))) {
        // The hand rests: tets go where muscles are now. What is there stays until it is done
        Made<const domain::DomainBuild> finer;
        if (bring(finer, request, domainPart, [&](RunContext& run) {
              return refine ? refineDomain(request.project, run)
                            : makeDomain(request.project, {}, run);
            })) {
          domain = std::move(finer);
          sizedFor = controlPoints(request.project);
          isRefined = refine;
          tissues.of.reset();
          bring(tissues, request, curvePart, make);
        } else if (finer.of) {
          isRefined = refine;  // it cannot be; what is there is good enough until curves move
        }
      }
    }
  }
  if (!stop()) sink({request.revision, LiveIdle{}});
}

// Makes a stage's result if what it depends on has changed, and tells of it. False where there is
// none: it failed, or nobody wants it any more.
template <class T, class Make>
bool LiveEngine::Impl::bring(Made<T>& stage, const Request& request,
                             model::Project (*part)(const model::Project&), const Make& make) {
  const model::Project wanted = part(request.project);
  const bool known = stage.of == wanted;
  if (!known) {
    auto run = std::make_shared<RunContext>([&](std::string_view name, double fraction) {
      sink({request.revision, LiveProgress{std::string(name), fraction}});
    });
    {
      const std::lock_guard lock(mutex);
      if (quit || gaveUp) return false;
      if (next && part(next->project) != wanted) return false;
      running = run;
      runningFor = wanted;
      runningPart = part;
    }
    auto made = make(*run);
    {
      const std::lock_guard lock(mutex);
      running.reset();
      runningFor.reset();
      runningPart = nullptr;
    }
    if (run->cancelled()) return false;
    stage.of = wanted;
    stage.made = std::move(made);
  }
  if (!stage.made) {
    sink({request.revision, LiveFault{stage.made.error()}});
    return false;
  }
  if (!known) sink({request.revision, *stage.made});
  return true;
}

Result<std::shared_ptr<const LiveMeshes>> LiveEngine::Impl::makeMeshes(
    const model::Project& project, RunContext& run) {
  auto loaded = loadMeshes(project, run);
  if (!loaded) return passOn(loaded);
  auto out = std::make_shared<LiveMeshes>();
  out->meshes = std::move(*loaded);
  const mesh::SurfaceMesh& skin = out->meshes.skin;
  out->diagonal = mesh::boundingBox(skin).diagonal();
  if (skin.F.rows() > 0 && mesh::isClosed(skin.F))
    out->skin = std::make_shared<const mesh::SurfaceQuery>(skin);
  // Solid, so that strokes keep out of open bones too; what that took is no news to whoever draws
  std::vector<std::optional<authoring::BoneSurface>> bones(out->meshes.bones.size());
  parallelFor(
      std::ssize(bones),
      [&](std::int64_t i) {
        const mesh::SurfaceMesh& bone = out->meshes.bones[static_cast<std::size_t>(i)];
        if (bone.F.rows() == 0 || run.cancelled()) return;
        Findings ignored;
        auto solid = authoring::solidBone(bone.name, bone, authoring::kSolidRel * out->diagonal,
                                          ignored, run);
        if (solid) bones[static_cast<std::size_t>(i)] = std::move(*solid);
      },
      1);
  if (run.cancelled()) return fail(ErrorCode::Cancelled, "cancelled while reading meshes");
  for (auto& bone : bones) {
    if (bone) out->bones.push_back(std::move(*bone));
  }
  return std::shared_ptr<const LiveMeshes>(std::move(out));
}

Result<std::shared_ptr<const domain::DomainBuild>> LiveEngine::Impl::makeDomain(
    const model::Project& project, std::vector<domain::WantedLength> lengths, RunContext& run) {
  // A view wants no more tets than it can show soon; the project's own number is for the build
  BuildOptions how;
  how.tets = std::min(project.settings.tets.value_or(options.tets), options.tets);
  // Those that are there now; see outgrown
  how.sizing = lengths.empty() ? Sizing::Curves : Sizing::Draft;
  how.lengths = std::move(lengths);
  how.useCache = options.useCache;
  auto built = buildDomainOf(withoutUnbegun(project), (*meshes.made)->meshes, how, run);
  if (!built) return passOn(built);
  return std::make_shared<const domain::DomainBuild>(std::move(*built));
}

// Small tets where muscles meet, as those at hand tell; as many in all.
Result<std::shared_ptr<const domain::DomainBuild>> LiveEngine::Impl::refineDomain(
    const model::Project& project, RunContext& run) {
  const domain::Domain& there = atHand.domain->domain;
  auto anatomy = envelope::buildAnatomy(there, atHand.settled->fields, atHand.cores, {}, run);
  if (!anatomy) return passOn(anatomy);
  return makeDomain(
      project, lengthsWhereTissuesMeet(anatomy->anatomy, atHand.tissues, there.skinDiagonal), run);
}

bool LiveEngine::Impl::wantsRefining() {
  const std::lock_guard lock(mutex);
  return refining && !atHand.tissues.empty();
}

// Whether curves have left the places that the domain's tets were made small for.
bool LiveEngine::Impl::outgrown(const model::Project& project) const {
  const double near = kStay * (*domain.made)->domain.skinDiagonal;
  for (const mesh::Vector3& p : controlPoints(project)) {
    if (std::ranges::none_of(sizedFor,
                             [&](const mesh::Vector3& q) { return (p - q).norm() < near; }))
      return true;
  }
  return false;
}

Result<void> LiveEngine::Impl::analyse(RunContext& run) {
  if (analysed.domain == *domain.made) return {};
  analysed = {};
  const auto& there = (*domain.made)->domain;
  auto solver = tissue::TissueSolver::create(there, run);
  if (!solver) return passOn(solver);
  analysed.walker = std::make_shared<const tissue::CurveWalker>(there);
  // Shared with those who edit values, and no longer there than its domain
  const auto held = std::make_shared<Held>(Held{*domain.made, std::move(*solver)});
  analysed.settling.emplace(std::shared_ptr<const tissue::TissueSolver>(held, &held->solver));
  analysed.kept = tissue::SettledStore(options.undoBytes);
  analysed.geometry = std::make_shared<const render::VolumeGeometry>(
      std::shared_ptr<const mesh::TetMesh>(*domain.made, &there.mesh), there.neighbours);
  analysed.domain = *domain.made;
  return {};
}

// As it was before, where somebody has come back to it.
Result<tissue::SettledStore::Result> LiveEngine::Impl::settle(const AtHand& next,
                                                              const tissue::TissueOptions& how,
                                                              bool& isKept, RunContext& run) {
  tissue::SettledStore::Result kept = analysed.kept.find(next.tissues, how);
  isKept = kept != nullptr;
  if (isKept) return kept;
  auto settled = analysed.settling->solve(next.cores, next.tissues, how, run);
  if (!settled) return passOn(settled);
  kept = std::make_shared<const tissue::Settling::Settled>(std::move(*settled));
  analysed.kept.keep(next.tissues, how, kept);
  return kept;
}

Result<std::shared_ptr<LiveTissues>> LiveEngine::Impl::makeTissues(const model::Project& project,
                                                                   RunContext& run) {
  if (auto ready = analyse(run); !ready) return passOn(ready);
  const auto begin = run.seconds();
  const domain::Domain& there = analysed.domain->domain;
  auto out = std::make_shared<LiveTissues>();
  out->domain = analysed.domain;

  // A muscle that cannot be traced, say because its curve has just been drawn out of the skin, is
  // told and left out; the others stay
  std::vector<tissue::CurveTissue> all;
  std::vector<std::size_t> slots;
  {
    all = curveTissues(withoutUnbegun(project));
    for (std::size_t slot = 0; slot < all.size(); ++slot) slots.push_back(slot);
  }
  const tissue::TissueOptions how = tissueOptions(project);
  Result<tissue::CoreSamples> cores;
  while (true) {
    cores = tissue::traceCurves(*analysed.walker, there, all, how, run, analysed.traces);
    if (cores) break;
    const Error& error = cores.error();
    const auto culprit = std::ranges::find_if(
        all, [&](const tissue::CurveTissue& t) { return t.name == error.place.object; });
    if (error.code == ErrorCode::Cancelled || culprit == all.end()) return passOn(cores);
    out->findings.push_back({.severity = Severity::Error,
                             .kind = "left-out",
                             .object = culprit->name,
                             .message = error.message,
                             .point = error.place.point});
    slots.erase(slots.begin() + (culprit - all.begin()));
    all.erase(culprit);
  }

  out->findings.insert(out->findings.end(), cores->findings.begin(), cores->findings.end());
  AtHand next{analysed.domain, std::move(all), std::move(*cores), nullptr};
  auto settled = settle(next, how, out->isKept, run);
  if (!settled) return passOn(settled);
  next.settled = std::move(*settled);
  out->fields = std::make_shared<tissue::ValueFields>(
      tissue::ValueFields::create({analysed.domain, &there}, analysed.settling->solver(),
                                  *next.settled, next.cores, next.tissues, how, analysed.walker));
  out->geometry = analysed.geometry;
  out->slotOf = std::move(slots);
  out->touching = touching(there.mesh, out->fields->owners());
  {
    const Stage stage(run, "volumes");
    out->volumes = tissue::tissueVolumes(there.mesh, out->fields->fields());
  }
  out->fields->prepareMove({});  // so that whoever drags first need not wait
  out->seconds = run.seconds() - begin;
  if (run.cancelled()) return fail(ErrorCode::Cancelled, "cancelled while measuring volumes");
  atHand = std::move(next);
  return out;
}

LiveEngine::LiveEngine(Sink sink, LiveOptions options)
    : impl_(std::make_unique<Impl>(std::move(sink), options)) {}
LiveEngine::~LiveEngine() = default;

void LiveEngine::request(model::Project project, std::uint64_t revision, bool anew) {
  {
    const std::lock_guard lock(impl_->mutex);
    // What is at hand goes on if the new project needs the same
    if (impl_->running && (anew || impl_->runningPart(project) != *impl_->runningFor))
      impl_->running->cancel();
    // One that nobody got to is not to be forgotten by the next
    anew = anew || (impl_->next && impl_->next->anew);
    impl_->next = Request{std::move(project), revision, anew};
  }
  impl_->wake.notify_all();
}

void LiveEngine::setRefining(bool on) {
  const std::lock_guard lock(impl_->mutex);
  impl_->refining = on;
}

void LiveEngine::cancel() {
  const std::lock_guard lock(impl_->mutex);
  impl_->gaveUp = true;
  impl_->next.reset();
  if (impl_->running) impl_->running->cancel();
}

}  // namespace ecorche::engine
