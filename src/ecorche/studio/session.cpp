#include <ecorche/model/command_text.h>
#include <ecorche/model/project_file.h>
#include <ecorche/studio/session.h>

#include <QPointer>
#include <algorithm>

namespace ecorche::studio {

namespace {

constexpr int kRestForSolvingMs = 150;  // without movement, before moved curves are solved for

}  // namespace

Session::Session(engine::LiveOptions options, QObject* parent)
    : QObject(parent), history_(std::make_unique<model::History>(model::Project{})) {
  restForMeasuring_.setSingleShot(true);
  connect(&restForMeasuring_, &QTimer::timeout, this, &Session::measure);
  restForSolving_.setSingleShot(true);
  connect(&restForSolving_, &QTimer::timeout, this, [this] { requestSolve(false); });
  engine_ = std::make_unique<engine::LiveEngine>(
      [this](engine::LiveUpdate update) {
        auto shared = std::make_shared<engine::LiveUpdate>(std::move(update));
        post_.post([this, shared] { take(*shared); });
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
  coming_.reset();
  prepared_.reset();
  flow_.reset();
  flowIsNew_ = false;
  keptVolumes_.clear();
  fieldsNew_ = true;
  lastFault_.clear();
  findingsTold_.clear();
  selection_ = {};
  const bool fine = display_.fine;
  display_ = {};
  display_.fine = fine;
  firstRequest_ = request_ + 1;
  Q_EMIT selectionChanged();
  Q_EMIT displayChanged();
  Q_EMIT liveChanged();
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
  Q_EMIT projectChanged();
  return {};
}

namespace {

// The project after the commands.
Result<model::Project> carriedOut(model::Project project,
                                  const std::vector<model::Command>& commands) {
  for (const model::Command& command : commands) {
    auto next = model::apply(project, command);
    if (!next) return passOn(next);
    project = std::move(*next);
  }
  return project;
}

}  // namespace

// The commands, and what else has to be done so that twins that are kept in step stay so.
Result<std::vector<model::Command>> Session::withFollowers(
    const std::vector<model::Command>& commands) {
  const model::Project& before = history_->project();
  std::vector<model::Command> out;
  Result<model::Project> after = before;
  for (const model::Command& command : commands) {
    std::vector<model::Command> step{command};
    if (const auto* rename = std::get_if<model::RenameTissue>(&command.act))
      if (const auto other = twinsRename(*after, *rename)) step.emplace_back(*other);
    after = carriedOut(*after, step);
    if (!after) return passOn(after);
    out.insert(out.end(), step.begin(), step.end());
  }
  if (std::ranges::any_of(after->tissues, &model::Tissue::keepsTwin)) {
    if (const auto plane = mirrorPlane()) {
      const auto follow = twinsFollow(before, *after, meshes_.get(), *plane);
      out.insert(out.end(), follow.begin(), follow.end());
    }
  }
  return out;
}

bool Session::perform(const std::vector<model::Command>& commands, const QString& label) {
  draft_.reset();
  const auto refuse = [&](const Error& error) {
    tell(Severity::Error, QString::fromStdString(error.message), error.place.point);
    Q_EMIT projectChanged();
    return false;
  };
  auto all = withFollowers(commands);
  if (!all) return refuse(all.error());
  if (auto done = history_->perform(*all, label.toStdString()); !done) return refuse(done.error());
  changed();
  keepVolumes();
  return true;
}

bool Session::draft(const std::vector<model::Command>& commands) {
  const auto all = withFollowers(commands);
  auto after = all ? carriedOut(history_->project(), *all)
                   : Result<model::Project>(tl::unexpected(all.error()));
  if (!after) {
    tell(Severity::Warning, QString::fromStdString(after.error().message));
    return false;
  }
  draft_ = Draft{commands, std::move(*after)};
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
  Q_EMIT selectionChanged();
}

const model::Tissue* Session::selectedTissue() const {
  const auto place = model::findTissue(project(), selection_.tissue);
  return place ? &project().tissues[*place] : nullptr;
}

void Session::setDisplay(const Display& display) {
  display_ = display;
  Q_EMIT displayChanged();
  direct();
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

void Session::setRefining(bool on) {
  engine_->setRefining(on);
  if (!open_ || !on) return;
  setSettled(false);
  requestSolve(false);
}

std::optional<MirrorPlane> Session::mirrorPlane() const {
  if (const auto plane = symmetryPlane(project())) return plane;
  if (mirrorOf_ != meshes_) {
    mirror_ = meshes_ ? studio::mirrorPlane(meshes_->meshes.skin) : std::nullopt;
    mirrorOf_ = meshes_;
  }
  return mirror_;
}

void Session::tell(Severity severity, const QString& text, std::optional<mesh::Vector3> place) {
  Q_EMIT told(severity, text, place);
}

void Session::changed(bool anew) {
  forgetWhatIsGone();
  followEdits();
  Q_EMIT projectChanged();
  if (!open_) return;
  setSettled(false);
  // Under the hand fields follow; what would be solved for would be old before it is there, and
  // takes time from the view
  if (draft_ && !anew && tissues_ && tissues_->fields->isAdrift()) {
    restForSolving_.start(kRestForSolvingMs);
  } else {
    requestSolve(anew);
  }
}

void Session::requestSolve(bool anew) {
  restForSolving_.stop();
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
    Q_EMIT displayChanged();
  }
  select(s);
}

void Session::setSettled(bool settled) {
  if (settled == settled_) return;
  settled_ = settled;
  Q_EMIT settledChanged();
}

}  // namespace ecorche::studio
