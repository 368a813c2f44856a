#include <ecorche/core/contract.h>
#include <ecorche/model/command_text.h>
#include <ecorche/model/history.h>

#include <algorithm>

namespace ecorche::model {

namespace {

// Meshes that a command names
void moveMeshes(Command& command, const std::filesystem::path& from,
                const std::filesystem::path& to) {
  const auto move = [&](MeshRef& mesh) { mesh = movedTo(mesh, from, to); };
  std::visit(
      [&](auto& act) {
        if constexpr (requires { act.mesh; }) move(act.mesh);
        if constexpr (requires { act.bone.mesh; }) move(act.bone.mesh);
        if constexpr (requires { act.attachment.patch; }) {
          if (act.attachment.patch) move(*act.attachment.patch);
        }
      },
      command.act);
}

}  // namespace

History::History(Project start) : now_(std::move(start)) {}

Result<void> History::perform(const Command& command) {
  const std::string text = formatCommand(command);
  return perform(std::span(&command, 1), text.substr(0, text.find(' ')));
}

// The project after each of the commands.
Result<std::vector<Project>> History::outcomes(std::span<const Command> commands) const {
  std::vector<Project> after;
  after.reserve(commands.size());
  for (const Command& command : commands) {
    auto next = apply(after.empty() ? now_ : after.back(), command);
    if (!next) return passOn(next);
    after.push_back(std::move(*next));
  }
  return after;
}

Result<void> History::extend(std::span<const Command> commands) {
  EC_REQUIRE(canUndo() && !canRedo());
  auto after = outcomes(commands);
  if (!after) return passOn(after);
  for (std::size_t i = 0; i < commands.size(); ++i) append(commands[i], std::move((*after)[i]));
  steps_.back().end = done_;
  ++revision_;
  return {};
}

Result<void> History::perform(std::span<const Command> commands, std::string label) {
  if (commands.empty()) return {};
  auto after = outcomes(commands);
  if (!after) return passOn(after);
  commands_.resize(done_);
  steps_.resize(stepsDone_);
  snapshots_.resize(
      std::min(snapshots_.size(), (done_ + kBetweenSnapshots - 1) / kBetweenSnapshots));
  steps_.push_back({std::move(label), done_, done_ + commands.size()});
  for (std::size_t i = 0; i < commands.size(); ++i) append(commands[i], std::move((*after)[i]));
  ++stepsDone_;
  ++revision_;
  return {};
}

void History::append(const Command& command, Project after) {
  if (done_ % kBetweenSnapshots == 0) snapshots_.push_back(std::move(now_));
  now_ = std::move(after);
  commands_.push_back(command);
  ++done_;
}

void History::goTo(std::size_t done) {
  std::size_t from = done_;
  if (done < done_) {
    const std::size_t snapshot = done / kBetweenSnapshots;
    now_ = snapshots_[snapshot];
    from = snapshot * kBetweenSnapshots;
  }
  for (; from < done; ++from) now_ = *apply(now_, commands_[from]);
  done_ = done;
  ++revision_;
}

void History::undo() {
  EC_REQUIRE(canUndo());
  goTo(steps_[--stepsDone_].first);
}

void History::redo() {
  EC_REQUIRE(canRedo());
  goTo(steps_[stepsDone_++].end);
}

void History::moveTo(const std::filesystem::path& folder) {
  for (Command& command : commands_) moveMeshes(command, now_.folder, folder);
  for (Project& snapshot : snapshots_) snapshot = movedTo(std::move(snapshot), folder);
  now_ = movedTo(std::move(now_), folder);
}

std::vector<Command> History::performed() const {
  return {commands_.begin(), commands_.begin() + static_cast<std::ptrdiff_t>(done_)};
}

}  // namespace ecorche::model
