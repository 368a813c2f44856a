#include <ecorche/engine/live_parts.h>
#include <ecorche/model/command_text.h>
#include <ecorche/model/project_file.h>
#include <ecorche/studio/session.h>
#include <ecorche/tissue/segmentation.h>
#include <ecorche/tissue/target_volume.h>

#include <QMetaObject>
#include <QPointer>
#include <algorithm>

namespace ecorche::studio {

Session::Session(engine::LiveOptions options, QObject* parent)
    : QObject(parent), history_(std::make_unique<model::History>(model::Project{})) {
  engine_ = std::make_unique<engine::LiveEngine>(
      [this](engine::LiveUpdate update) {
        auto shared = std::make_shared<engine::LiveUpdate>(std::move(update));
        // Queued: it runs on the window's thread, and never once this object is gone
        QMetaObject::invokeMethod(
            this, [this, shared] { take(*shared); }, Qt::QueuedConnection);
      },
      options);
}

Session::~Session() { engine_.reset(); }

const model::Project& Session::project() const {
  return draft_ ? draft_->project : history_->project();
}

void Session::start(model::Project project, std::filesystem::path file, bool saved) {
  history_ = std::make_unique<model::History>(std::move(project));
  draft_.reset();
  open_ = true;
  file_ = std::move(file);
  saved_.reset();
  if (saved) saved_ = history_->project();
  meshes_.reset();
  domain_.reset();
  tissues_.reset();
  volumes_.clear();
  fieldsNew_ = true;
  lastFault_.clear();
  findingsTold_.clear();
  selection_ = {};
  const bool fine = display_.fine;
  display_ = {};
  display_.fine = fine;
  firstRequest_ = request_ + 1;
  emit selectionChanged();
  emit displayChanged();
  emit liveChanged();
  changed(true);
}

Result<void> Session::save(const std::filesystem::path& file) {
  const std::filesystem::path folder = file.parent_path();
  const bool moved = folder != history_->project().folder;
  const model::Project project =
      moved ? model::movedTo(history_->project(), folder) : history_->project();
  if (auto saved = model::saveProject(project, file); !saved) return saved;
  dropDraft();
  if (moved) history_->moveTo(folder);
  file_ = file;
  saved_ = history_->project();
  emit projectChanged();
  return {};
}

bool Session::perform(const std::vector<model::Command>& commands, const QString& label) {
  draft_.reset();
  if (auto done = history_->perform(commands, label.toStdString()); !done) {
    tell(Severity::Error, QString::fromStdString(done.error().message), done.error().place.point);
    emit projectChanged();
    return false;
  }
  changed();
  return true;
}

bool Session::draft(const std::vector<model::Command>& commands) {
  model::Project after = history_->project();
  for (const model::Command& command : commands) {
    auto next = model::apply(after, command);
    if (!next) {
      tell(Severity::Warning, QString::fromStdString(next.error().message));
      return false;
    }
    after = std::move(*next);
  }
  draft_ = Draft{commands, std::move(after)};
  changed();
  return true;
}

bool Session::keepDraft(const QString& label) {
  if (!draft_) return false;
  const std::vector<model::Command> commands = std::move(draft_->commands);
  return perform(commands, label);
}

void Session::dropDraft() {
  if (!draft_) return;
  draft_.reset();
  changed();
}

void Session::undo() {
  if (draft_) return dropDraft();
  if (!history_->canUndo()) return;
  history_->undo();
  changed();
}

void Session::redo() {
  if (draft_ || !history_->canRedo()) return;
  history_->redo();
  changed();
}

void Session::goToStep(std::size_t done) {
  draft_.reset();
  while (history_->stepsDone() > done) history_->undo();
  while (history_->stepsDone() < done && history_->canRedo()) history_->redo();
  changed();
}

std::string Session::script() const {
  std::string out;
  for (const model::Command& command : history_->performed())
    out += model::formatCommand(command) + "\n";
  return out;
}

void Session::select(const Selection& selection) {
  if (selection == selection_) return;
  selection_ = selection;
  emit selectionChanged();
}

const model::Tissue* Session::selectedTissue() const {
  const auto place = model::findTissue(project(), selection_.tissue);
  return place ? &project().tissues[*place] : nullptr;
}

void Session::setDisplay(const Display& display) {
  display_ = display;
  emit displayChanged();
}

void Session::setHidden(const std::string& name, bool hidden) {
  Display display = display_;
  if (hidden) {
    display.hidden.insert(name);
  } else {
    display.hidden.erase(name);
  }
  setDisplay(display);
}

void Session::reloadMeshes() {
  if (!open_) return;
  lastFault_.clear();
  changed(true);
}

void Session::stopComputing() {
  engine_->cancel();
  setSettled(true);
}

std::optional<double> Session::volumeOf(const std::string& tissue) const {
  if (!tissues_) return std::nullopt;
  const auto places = engine::liveTissuePlaces(project());
  for (std::size_t i = 0; i < tissues_->slotOf.size() && i + 1 < volumes_.size(); ++i) {
    const std::size_t slot = tissues_->slotOf[i];
    if (slot < places.size() && project().tissues[places[slot]].name == tissue)
      return volumes_[i + 1];
  }
  return std::nullopt;
}

bool Session::setVolume(const std::string& tissue, double volume) {
  const auto place = model::findTissue(project(), tissue);
  if (!tissues_ || !place || !(volume > 0.0)) return false;
  const auto places = engine::liveTissuePlaces(project());
  for (std::size_t i = 0; i < tissues_->slotOf.size(); ++i) {
    if (tissues_->slotOf[i] >= places.size() || places[tissues_->slotOf[i]] != *place) continue;
    RunContext run;
    const auto values = tissue::valuesForVolume(*tissues_->fields, i, volume, run);
    if (!values) {
      tell(Severity::Warning, QString::fromStdString(values.error().message));
      return false;
    }
    std::vector<model::Command> commands;
    for (std::size_t c = 0; c < values->size(); ++c) {
      for (std::size_t p = 0; p < (*values)[c].size(); ++p)
        commands.push_back(model::SetPointValue{tissue, c, p, (*values)[c][p]});
    }
    return perform(commands, tr("Volume of %1").arg(QString::fromStdString(tissue)));
  }
  return false;
}

Session::FieldEdits Session::takeFieldEdits() {
  if (!fieldsNew_ && fieldsChanged_.empty()) return {fieldsRevision_, nullptr};
  ++fieldsRevision_;
  FieldEdits out{fieldsRevision_, nullptr};
  if (!fieldsNew_) {
    std::ranges::sort(fieldsChanged_);
    const auto rest = std::ranges::unique(fieldsChanged_);
    fieldsChanged_.erase(rest.begin(), rest.end());
    out.changed = std::make_shared<const std::vector<std::int32_t>>(std::move(fieldsChanged_));
  }
  fieldsNew_ = false;
  fieldsChanged_.clear();
  return out;
}

void Session::tell(Severity severity, const QString& text, std::optional<mesh::Vector3> place) {
  emit told(severity, text, place);
}

void Session::changed(bool anew) {
  forgetWhatIsGone();
  followValues();
  emit projectChanged();
  if (!open_) return;
  setSettled(false);
  engine_->request(project(), ++request_, anew);
}

// What is selected may have been undone or renamed
void Session::forgetWhatIsGone() {
  Selection s = selection_;
  const auto place = model::findTissue(project(), s.tissue);
  if (!place) {
    s.tissue.clear();
    s.curve = s.point = -1;
  } else {
    const auto& curves = project().tissues[*place].curves;
    if (s.curve >= std::ssize(curves)) s.curve = s.point = -1;
    if (s.curve >= 0 && s.point >= std::ssize(curves[static_cast<std::size_t>(s.curve)].points))
      s.point = -1;
  }
  if (!s.bone.empty() && !model::findBone(project(), s.bone)) s.bone.clear();
  if (display_.solo && !model::findTissue(project(), *display_.solo)) {
    display_.solo.reset();
    emit displayChanged();
  }
  select(s);
}

void Session::take(const engine::LiveUpdate& update) {
  if (update.revision < firstRequest_) return;
  if (const auto* progress = std::get_if<engine::LiveProgress>(&update.what)) {
    emit progressed(QString::fromStdString(progress->stage), progress->fraction);
  } else if (const auto* meshes =
                 std::get_if<std::shared_ptr<const engine::LiveMeshes>>(&update.what)) {
    meshes_ = *meshes;
    emit liveChanged();
  } else if (const auto* domain =
                 std::get_if<std::shared_ptr<const domain::DomainBuild>>(&update.what)) {
    domain_ = *domain;
    emit liveChanged();
  } else if (const auto* tissues =
                 std::get_if<std::shared_ptr<engine::LiveTissues>>(&update.what)) {
    takeTissues(*tissues);
  } else if (const auto* fault = std::get_if<engine::LiveFault>(&update.what)) {
    // The same fault is told once, however often it is met while something else is edited
    const QString text = QString::fromStdString(fault->error.text());
    if (text != lastFault_) tell(Severity::Error, text, fault->error.place.point);
    lastFault_ = text;
  } else if (std::holds_alternative<engine::LiveIdle>(update.what)) {
    if (update.revision == request_) setSettled(true);
  }
}

void Session::takeTissues(const std::shared_ptr<engine::LiveTissues>& tissues) {
  tissues_ = tissues;
  volumes_ = tissues->volumes;
  fieldsNew_ = true;
  lastFault_.clear();
  followValues();  // which may have gone on meanwhile
  // What has been said and is still so is not said again
  std::set<std::string> now;
  for (const Finding& finding : tissues_->findings) {
    if (finding.severity != Severity::Error && finding.severity != Severity::Warning) continue;
    now.insert(finding.message);
    if (!findingsTold_.contains(finding.message))
      tell(finding.severity, QString::fromStdString(finding.message), finding.point);
  }
  findingsTold_ = std::move(now);
  emit liveChanged();
}

// Fields are linear in values and fat: no solve, and no waiting.
void Session::followValues() {
  if (!tissues_) return;
  tissue::ValueFields& fields = *tissues_->fields;
  const auto places = engine::liveTissuePlaces(project());
  RunContext run;
  bool changed = false;
  for (std::size_t i = 0; i < tissues_->slotOf.size(); ++i) {
    if (tissues_->slotOf[i] >= places.size()) continue;
    const model::Tissue& wanted = project().tissues[places[tissues_->slotOf[i]]];
    const auto& curves = fields.tissues()[i].curves;
    if (wanted.curves.size() != curves.size()) continue;  // a head came or went: solved for soon
    std::vector<std::vector<double>> values;
    bool alike = true;
    bool same = true;
    for (std::size_t c = 0; c < curves.size(); ++c) {
      values.push_back(model::tissueValuesOf(wanted.curves[c]));
      alike = alike && values.back().size() == curves[c].values.size();
      same = same && values.back() == curves[c].values;
    }
    if (!alike || same) continue;
    if (const auto edit = fields.setValues(i, values, run)) {
      noteChanged(edit->vertices);
      changed = true;
    } else {
      tell(Severity::Error, QString::fromStdString(edit.error().message));
    }
  }
  if (project().settings.fat != fields.fat()) {
    noteChanged(fields.setFat(project().settings.fat).vertices);
    changed = true;
  }
  if (!changed) return;
  emit fieldsChanged();
  measure();
}

void Session::noteChanged(const std::vector<std::int32_t>& vertices) {
  if (!fieldsNew_) fieldsChanged_.insert(fieldsChanged_.end(), vertices.begin(), vertices.end());
}

// Volumes take longer than a frame; they follow when the hand gives them time.
void Session::measure() {
  if (measuring_.isBusy()) {
    measureAgain_ = true;
    return;
  }
  measureAgain_ = false;
  const auto domain = tissues_->domain;
  const auto copy = std::make_shared<const tissue::TissueFields>(tissues_->fields->fields());
  const auto volumes = std::make_shared<std::vector<double>>();
  measuring_.start(
      [=](RunContext&) { *volumes = tissue::tissueVolumes(domain->domain.mesh, *copy); },
      [this, volumes, of = tissues_] {
        if (of == tissues_) {
          volumes_ = *volumes;
          emit volumesChanged();
        }
        if (measureAgain_ && tissues_) measure();
        emit settledChanged();
      });
}

void Session::setSettled(bool settled) {
  if (settled == settled_) return;
  settled_ = settled;
  emit settledChanged();
}

}  // namespace ecorche::studio
