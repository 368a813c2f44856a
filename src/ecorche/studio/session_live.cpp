// What a session has of its project's tissues: answers of the engine, values that follow at once,
// volumes, directions of fibres.
#include <ecorche/core/give_way.h>
#include <ecorche/engine/curve_directions.h>
#include <ecorche/engine/live_parts.h>
#include <ecorche/studio/session.h>
#include <ecorche/studio/volume_look.h>
#include <ecorche/tissue/segmentation.h>
#include <ecorche/tissue/target_volume.h>

#include <algorithm>
#include <utility>

namespace ecorche::studio {

namespace {

constexpr int kRestMs = 120;           // without an edit, before volumes are measured
constexpr double kVolumeSlack = 2e-3;  // of a volume that is kept, relative
constexpr double kLineSteps = 500.0;   // of curves that give fibres their direction, of a diagonal

}  // namespace

// Which of the tissues at hand it is; nothing while it has no body.
std::optional<std::size_t> Session::entryOf(const std::string& tissue) const {
  if (!tissues_) return std::nullopt;
  const auto places = engine::liveTissuePlaces(project());
  for (std::size_t i = 0; i < tissues_->slotOf.size(); ++i) {
    const std::size_t slot = tissues_->slotOf[i];
    if (slot < places.size() && project().tissues[places[slot]].name == tissue) return i;
  }
  return std::nullopt;
}

std::optional<double> Session::volumeOf(const std::string& tissue) const {
  const auto entry = entryOf(tissue);
  if (!entry || *entry + 1 >= volumes_.size()) return std::nullopt;
  return volumes_[*entry + 1];
}

Result<std::vector<model::Command>> Session::valuesFor(const std::string& tissue, double volume) {
  std::vector<model::Command> commands;
  const auto entry = entryOf(tissue);
  if (!entry || !(volume > 0.0)) return commands;
  RunContext run;
  const auto values = tissue::valuesForVolume(*tissues_->fields, *entry, volume, run);
  if (!values) return passOn(values);
  for (std::size_t c = 0; c < values->size(); ++c) {
    for (std::size_t p = 0; p < (*values)[c].size(); ++p)
      commands.push_back(model::SetPointValue{tissue, c, p, (*values)[c][p]});
  }
  return commands;
}

bool Session::setVolume(const std::string& tissue, double volume) {
  if (keepsVolume(tissue)) keptVolumes_[tissue] = volume;
  if (tissues_ && tissues_->fields->isAdrift()) {
    tell(Severity::Note, tr("%1 has just been moved; its volume can be set in a moment")
                             .arg(QString::fromStdString(tissue)));
    return false;
  }
  const auto commands = valuesFor(tissue, volume);
  if (!commands) tell(Severity::Warning, QString::fromStdString(commands.error().message));
  if (!commands || commands->empty()) return false;
  return perform(*commands, tr("Volume of %1").arg(QString::fromStdString(tissue)));
}

void Session::keepVolume(const std::string& tissue, bool on) {
  keptVolumes_.erase(tissue);
  const auto entry = entryOf(tissue);
  if (on && entry) keptVolumes_[tissue] = tissue::volumeOf(*tissues_->fields, *entry);
  Q_EMIT selectionChanged();
}

// Part of the step that changed them: undone with it.
void Session::keepVolumes() {
  // What was undone stays undone
  if (keptVolumes_.empty() || !tissues_ || draft_ || !history_->canUndo() || history_->canRedo())
    return;
  if (tissues_->fields->isAdrift()) return;  // once they are settled
  std::erase_if(keptVolumes_,
                [&](const auto& kept) { return !model::findTissue(project(), kept.first); });
  for (const auto& [name, volume] : keptVolumes_) {
    const auto entry = entryOf(name);
    if (!entry) continue;
    const double now = tissue::volumeOf(*tissues_->fields, *entry);
    if (std::abs(now - volume) <= kVolumeSlack * volume) continue;
    const auto values = valuesFor(name, volume);
    const auto commands = values ? withFollowers(*values) : values;
    Result<void> done;
    if (commands) done = history_->extend(*commands);
    if (!commands || !done) {
      const Error& error = commands ? done.error() : commands.error();
      tell(Severity::Warning, QString::fromStdString(error.message));
    } else {
      changed();
    }
  }
}

Session::FieldEdits Session::takeFieldEdits() {
  FieldEdits out{fieldsRevision_, nullptr, std::exchange(prepared_, nullptr)};
  if (!fieldsNew_ && fieldsChanged_.columns.empty()) return out;
  out.revision = ++fieldsRevision_;
  if (!fieldsNew_) {
    for (auto* list : {&fieldsChanged_.vertices, &fieldsChanged_.columns}) {
      std::ranges::sort(*list);
      const auto rest = std::ranges::unique(*list);
      list->erase(rest.begin(), rest.end());
    }
    out.changed = std::make_shared<const render::FieldChange>(std::move(fieldsChanged_));
  }
  fieldsNew_ = false;
  fieldsChanged_ = {};
  return out;
}

void Session::take(const engine::LiveUpdate& update) {
  if (update.revision < firstRequest_) return;
  if (const auto* progress = std::get_if<engine::LiveProgress>(&update.what)) {
    Q_EMIT progressed(QString::fromStdString(progress->stage), progress->fraction);
  } else if (const auto* meshes =
                 std::get_if<std::shared_ptr<const engine::LiveMeshes>>(&update.what)) {
    meshes_ = *meshes;
    Q_EMIT liveChanged();
  } else if (const auto* domain =
                 std::get_if<std::shared_ptr<const domain::DomainBuild>>(&update.what)) {
    domain_ = *domain;
    Q_EMIT liveChanged();
  } else if (const auto* tissues =
                 std::get_if<std::shared_ptr<engine::LiveTissues>>(&update.what)) {
    coming_ = *tissues;
    prepareTissues();
  } else if (const auto* fault = std::get_if<engine::LiveFault>(&update.what)) {
    // The same fault is told once, however often it is met while something else is edited
    const QString text = QString::fromStdString(fault->error.text());
    if (text != lastFault_) tell(Severity::Error, text, fault->error.place.point);
    lastFault_ = text;
  } else if (std::holds_alternative<engine::LiveIdle>(update.what)) {
    if (update.revision == request_) setSettled(true);
  }
}

// Other fields everywhere are much for a picture to take in: until that is ready the ones before
// are shown.
void Session::prepareTissues() {
  if (!coming_ || preparing_.isBusy()) return;
  // Revisions of different tissues are never neighbours
  const std::uint64_t revision = (fieldsRevision_ | 0xffffffffu) + 1;
  auto item =
      std::make_shared<render::VolumeItem>(studio::volumeOf(project(), *coming_, display_, {}));
  item->fieldsRevision = revision;
  const auto made = std::make_shared<std::shared_ptr<render::VolumeContent>>();
  preparing_.start(
      [made, item, clip = display_.clip](RunContext&) {
        const GiveWay giveWay;
        *made = render::prepareVolume(*item, clip);
      },
      [this, made, revision, tissues = coming_] {
        if (tissues == coming_) {
          coming_.reset();
          fieldsRevision_ = revision;
          fieldsNew_ = false;
          fieldsChanged_ = {};
          prepared_ = std::move(*made);
          showTissues(tissues);
        }
        prepareTissues();  // those that came meanwhile
        Q_EMIT settledChanged();
      });
}

void Session::showTissues(const std::shared_ptr<engine::LiveTissues>& tissues) {
  tissues_ = tissues;
  volumes_ = tissues->volumes;
  lastFault_.clear();
  followEdits();  // which may have gone on meanwhile
  // What has been said and is still so is not said again
  std::set<std::string> now;
  for (const Finding& finding : tissues_->findings) {
    if (finding.severity != Severity::Error && finding.severity != Severity::Warning) continue;
    now.insert(finding.message);
    if (!findingsTold_.contains(finding.message))
      tell(finding.severity, QString::fromStdString(finding.message), finding.point);
  }
  findingsTold_ = std::move(now);
  flow_.reset();
  flowIsNew_ = false;
  Q_EMIT liveChanged();
  direct();
  keepVolumes();
}

// Directions of fibres, for those who look at them.
void Session::direct() {
  if (!display_.fibers || flowIsNew_ || !tissues_ || directing_.isBusy()) return;
  flowIsNew_ = true;
  std::vector<std::vector<std::vector<mesh::Vector3>>> lines(1);
  for (const tissue::CurveTissue& tissue : tissues_->fields->tissues()) {
    lines.emplace_back();
    if (tissue.filler) continue;
    for (const auto& curve : tissue.curves)
      lines.back().push_back(
          curve.spline.sample((meshes_ ? meshes_->diagonal : 1.0) / kLineSteps).point);
  }
  const auto made = std::make_shared<std::shared_ptr<const mesh::Directions>>();
  directing_.start(
      [made, domain = tissues_->domain, owners = tissues_->fields->owners(),
       lines = std::move(lines)](RunContext&) {
        const GiveWay giveWay;
        *made = engine::curveDirections(domain->domain.mesh.V, owners, lines);
      },
      [this, made, of = tissues_] {
        if (of == tissues_) {
          flow_ = *made;
          Q_EMIT displayChanged();
        }
        direct();  // again, if something has changed meanwhile
        Q_EMIT settledChanged();
      });
}

// Fields follow curves, values and fat at once: no solve, and no waiting.
void Session::followEdits() {
  if (!tissues_) return;
  const bool moved = followCurves();
  // Until moved curves are solved for, values wait
  const bool edited = !tissues_->fields->isAdrift() && followValues();
  if (!moved && !edited) return;
  Q_EMIT fieldsChanged();
  // Volumes take longer than a frame, and a copy of the fields: they follow when the hand rests
  restForMeasuring_.start(kRestMs);
}

// The tissue that an entry of the fields is of; nothing while it has other curves than those.
const model::Tissue* Session::tissueOf(std::size_t entry,
                                       const std::vector<std::size_t>& places) const {
  const std::size_t slot = tissues_->slotOf[entry];
  if (slot >= places.size()) return nullptr;
  const model::Tissue& tissue = project().tissues[places[slot]];
  const auto& curves = tissues_->fields->tissues()[entry].curves;
  const bool alike = std::ranges::equal(
      tissue.curves, curves, {}, [](const model::Curve& c) { return c.points.size(); },
      [](const tissue::TissueCurve& c) { return c.values.size(); });
  return alike ? &tissue : nullptr;
}

bool Session::followCurves() {
  tissue::ValueFields& fields = *tissues_->fields;
  const auto places = engine::liveTissuePlaces(project());
  std::vector<tissue::ValueFields::CurveMove> moves;
  for (std::size_t i = 0; i < tissues_->slotOf.size(); ++i) {
    const model::Tissue* wanted = tissueOf(i, places);
    if (!wanted) continue;
    for (std::size_t c = 0; c < wanted->curves.size(); ++c) {
      mesh::Spline spline = model::splineOf(wanted->curves[c]);
      const mesh::Spline& now = fields.tissues()[i].curves[c].spline;
      if (spline.points() == now.points() || spline.points().size() != now.points().size())
        continue;
      moves.push_back({{i, static_cast<std::int32_t>(c)}, std::move(spline)});
    }
  }
  if (moves.empty()) return false;
  const auto change = fields.moveCurves(moves);
  for (const std::int32_t column : change.fields)
    noteChanged(static_cast<std::size_t>(column), change.vertices);
  return true;
}

bool Session::followValues() {
  tissue::ValueFields& fields = *tissues_->fields;
  const auto places = engine::liveTissuePlaces(project());
  RunContext run;
  bool changed = false;
  for (std::size_t i = 0; i < tissues_->slotOf.size(); ++i) {
    const model::Tissue* wanted = tissueOf(i, places);
    if (!wanted) continue;  // a head or a point came or went: solved for soon
    const auto& curves = fields.tissues()[i].curves;
    std::vector<std::vector<double>> values;
    bool same = true;
    for (std::size_t c = 0; c < curves.size(); ++c) {
      values.push_back(model::tissueValuesOf(wanted->curves[c]));
      same = same && values.back() == curves[c].values;
    }
    if (same) continue;
    if (const auto edit = fields.setValues(i, values, run)) {
      noteChanged(i + 1, edit->vertices);
      changed = true;
    } else {
      tell(Severity::Error, QString::fromStdString(edit.error().message));
    }
  }
  if (project().settings.fat != fields.fat()) {
    noteChanged(0, fields.setFat(project().settings.fat).vertices);
    changed = true;
  }
  return changed;
}

void Session::noteChanged(std::size_t column, const std::vector<std::int32_t>& vertices) {
  if (fieldsNew_) return;
  fieldsChanged_.columns.push_back(static_cast<std::int32_t>(column));
  fieldsChanged_.vertices.insert(fieldsChanged_.vertices.end(), vertices.begin(), vertices.end());
}

void Session::measure() {
  if (!tissues_) return;
  if (measuring_.isBusy()) {
    restForMeasuring_.start(kRestMs);
    return;
  }
  const auto domain = tissues_->domain;
  const auto copy = std::make_shared<const tissue::TissueFields>(tissues_->fields->fields());
  const auto volumes = std::make_shared<std::vector<double>>();
  measuring_.start(
      [=](RunContext&) {
        const GiveWay giveWay;
        *volumes = tissue::tissueVolumes(domain->domain.mesh, *copy);
      },
      [this, volumes, of = tissues_] {
        if (of == tissues_) {
          volumes_ = *volumes;
          Q_EMIT volumesChanged();
          // Owners are other ones, and so is whose curves a vertex follows; until that is known the
          // old directions are shown
          flowIsNew_ = false;
          direct();
        }
        Q_EMIT settledChanged();
      });
}

}  // namespace ecorche::studio
