#pragma once

#include <ecorche/core/result.h>
#include <ecorche/model/commands.h>

#include <cstdint>
#include <vector>

namespace ecorche::model {

/// A project with its past and its undone future. Because apply is pure, the past is a list of
/// commands and a snapshot every so many of them; undo goes to the snapshot and applies what lies
/// between again.
class History {
 public:
  explicit History(Project start);

  [[nodiscard]] const Project& project() const { return now_; }
  /// Goes up with every change, undo and redo included: two projects of one history with the same
  /// revision are equal.
  [[nodiscard]] std::uint64_t revision() const { return revision_; }

  /// Applies a command and forgets what was undone. On an error nothing changes. @errors those of
  /// apply
  [[nodiscard]] Result<void> perform(const Command& command);

  [[nodiscard]] bool canUndo() const { return done_ > 0; }
  [[nodiscard]] bool canRedo() const { return done_ < commands_.size(); }
  void undo();  ///< @pre canUndo()
  void redo();  ///< @pre canRedo()

  /// What was done since the start, in order: a script that leads here.
  [[nodiscard]] std::vector<Command> performed() const;

 private:
  static constexpr std::size_t kBetweenSnapshots = 16;

  Project now_;
  std::vector<Command> commands_;
  std::size_t done_ = 0;            // how many of commands_ are in now_
  std::vector<Project> snapshots_;  // before commands 0, 16, 32 …
  std::uint64_t revision_ = 0;
};

}  // namespace ecorche::model
