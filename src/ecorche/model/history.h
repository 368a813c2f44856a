#pragma once

#include <ecorche/core/result.h>
#include <ecorche/model/commands.h>

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace ecorche::model {

/// A project with its past and its undone future. The past is a list of steps, each what a hand did
/// at once: one command or several. Because apply is pure, undo needs no more than the commands and
/// a snapshot every so many of them: it goes to the snapshot and applies what lies between again.
class History {
 public:
  explicit History(Project start);

  [[nodiscard]] const Project& project() const { return now_; }
  /// Goes up with every change, undo and redo included: two projects of one history with the same
  /// revision are equal.
  [[nodiscard]] std::uint64_t revision() const { return revision_; }

  /// Applies a command as a step of its own, named by its verb, and forgets what was undone. On an
  /// error nothing changes. @errors those of apply
  [[nodiscard]] Result<void> perform(const Command& command);
  /// Several as one step: all of them, or none. No command is no step.
  /// @param label  what people read in a list: "Draw biceps"
  [[nodiscard]] Result<void> perform(std::span<const Command> commands, std::string label);

  /// Several more as part of the last step: undone and redone with it. All of them, or none.
  /// @pre canUndo() and not canRedo()
  [[nodiscard]] Result<void> extend(std::span<const Command> commands);

  [[nodiscard]] bool canUndo() const { return stepsDone_ > 0; }
  [[nodiscard]] bool canRedo() const { return stepsDone_ < steps_.size(); }
  void undo();  ///< @pre canUndo()
  void redo();  ///< @pre canRedo()

  /// The project and its whole past for a file in another folder: relative paths lead to the same
  /// meshes as before. No step of its own, and nothing that could be undone.
  void moveTo(const std::filesystem::path& folder);

  struct Step {
    std::string label;
    std::size_t first = 0;  ///< of its commands
    std::size_t end = 0;    ///< one past its last
  };
  /// Done ones first, then those that redo would bring back.
  [[nodiscard]] const std::vector<Step>& steps() const { return steps_; }
  [[nodiscard]] std::size_t stepsDone() const { return stepsDone_; }

  /// What was done since the start, in order: a script that leads here.
  [[nodiscard]] std::vector<Command> performed() const;

 private:
  static constexpr std::size_t kBetweenSnapshots = 16;

  Project now_;
  std::vector<Command> commands_;
  std::size_t done_ = 0;  // how many of commands_ are in now_
  std::vector<Step> steps_;
  std::size_t stepsDone_ = 0;
  std::vector<Project> snapshots_;  // before commands 0, 16, 32 …
  std::uint64_t revision_ = 0;

  [[nodiscard]] Result<std::vector<Project>> outcomes(std::span<const Command> commands) const;
  void append(const Command& command, Project after);
  void goTo(std::size_t done);
};

}  // namespace ecorche::model
