#include <ecorche/core/contract.h>
#include <ecorche/model/history.h>

namespace ecorche::model {

History::History(Project start) : now_(std::move(start)) {}

Result<void> History::perform(const Command& command) {
  auto after = apply(now_, command);
  if (!after) return passOn(after);
  commands_.resize(done_);
  snapshots_.resize(
      std::min(snapshots_.size(), (done_ + kBetweenSnapshots - 1) / kBetweenSnapshots));
  if (done_ % kBetweenSnapshots == 0) snapshots_.push_back(std::move(now_));
  now_ = std::move(*after);
  commands_.push_back(command);
  ++done_;
  ++revision_;
  return {};
}

void History::undo() {
  EC_REQUIRE(canUndo());
  --done_;
  const std::size_t snapshot = done_ / kBetweenSnapshots;
  now_ = snapshots_[snapshot];
  for (std::size_t k = snapshot * kBetweenSnapshots; k < done_; ++k)
    now_ = *apply(now_, commands_[k]);
  ++revision_;
}

void History::redo() {
  EC_REQUIRE(canRedo());
  now_ = *apply(now_, commands_[done_++]);
  ++revision_;
}

std::vector<Command> History::performed() const {
  return {commands_.begin(), commands_.begin() + static_cast<std::ptrdiff_t>(done_)};
}

}  // namespace ecorche::model
