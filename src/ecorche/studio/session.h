#pragma once

#include <ecorche/core/finding.h>
#include <ecorche/engine/live_engine.h>
#include <ecorche/model/history.h>
#include <ecorche/render/volume_item.h>
#include <ecorche/studio/background.h>
#include <ecorche/studio/display.h>
#include <ecorche/studio/postbox.h>
#include <ecorche/studio/twins.h>

#include <QObject>
#include <QString>
#include <QTimer>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace ecorche::studio {

/// What a window works on: one project with its past, what was computed of it so far, and what is
/// selected and shown. Panels and tools read it and propose commands; nothing else changes a
/// project. Lives on the window's thread.
class Session : public QObject {
  Q_OBJECT

 public:
  explicit Session(engine::LiveOptions options = {}, QObject* parent = nullptr);
  ~Session() override;

  // The project as it is to be seen: with the draft of an act under way.
  [[nodiscard]] const model::Project& project() const;
  [[nodiscard]] const model::History& history() const { return *history_; }
  [[nodiscard]] bool isOpen() const { return open_; }
  [[nodiscard]] const std::filesystem::path& file() const { return file_; }
  [[nodiscard]] bool isSaved() const { return saved_ == history_->project(); }

  /// @param file  where it was read from or is to be saved; may be empty
  void start(model::Project project, std::filesystem::path file, bool saved);
  [[nodiscard]] Result<void> save(const std::filesystem::path& file);

  /// Several commands as one step; what is wrong with them is told. False: nothing was done.
  /// Twins that are kept in step and volumes that are kept follow within the step.
  bool perform(const std::vector<model::Command>& commands, const QString& label);
  bool perform(const model::Command& command, const QString& label) {
    return perform(std::vector<model::Command>{command}, label);
  }
  /// Shows what the commands would do while a hand still moves; replaces the draft before it. What
  /// cannot be done is told and leaves the last draft. A draft is no step until it is kept.
  bool draft(const std::vector<model::Command>& commands);
  bool keepDraft(const QString& label);
  void dropDraft();
  [[nodiscard]] bool hasDraft() const { return draft_.has_value(); }

  void undo();
  void redo();
  /// Undoes or redoes until so many steps are done.
  void goToStep(std::size_t done);
  /// Everything done since the start, a line each: `ecorche run` makes the same project of it.
  [[nodiscard]] std::string script() const;

  [[nodiscard]] const Selection& selection() const { return selection_; }
  void select(const Selection& selection);
  [[nodiscard]] const model::Tissue* selectedTissue() const;
  [[nodiscard]] const Display& display() const { return display_; }
  void setDisplay(const Display& display);
  void setHidden(const std::string& name, bool hidden);

  [[nodiscard]] const std::shared_ptr<const engine::LiveMeshes>& meshes() const { return meshes_; }
  [[nodiscard]] const std::shared_ptr<const domain::DomainBuild>& domain() const { return domain_; }
  /// Fields follow the project's values and fat; curves may have moved on since they were solved.
  [[nodiscard]] std::shared_ptr<const engine::LiveTissues> tissues() const { return tissues_; }
  /// What became of the fields since this was last asked: a number that goes up, where values
  /// differ from those of the number before (null: anywhere), and, once for tissues that have just
  /// come, what drawing them takes.
  struct FieldEdits {
    std::uint64_t revision = 0;
    std::shared_ptr<const render::FieldChange> changed;
    std::shared_ptr<render::VolumeContent> prepared;
  };
  [[nodiscard]] FieldEdits takeFieldEdits();
  /// Nothing is being computed, and everything shown is of the project as it stands, or failed.
  [[nodiscard]] bool isSettled() const {
    return settled_ && !preparing_.isBusy() && !restForMeasuring_.isActive() &&
           !measuring_.isBusy() && !directing_.isBusy();
  }
  void stopComputing();
  /// Whether tets are made anew, small around muscles, when the hand rests.
  void setRefining(bool on);
  void reloadMeshes();  ///< files may have changed
  /// [m³]; nothing while it has no body.
  [[nodiscard]] std::optional<double> volumeOf(const std::string& tissue) const;

  /// Scales the muscle's values so that it gets a volume [m³]; what cannot be is told.
  bool setVolume(const std::string& tissue, double volume);
  /// Keeps the volume that the muscle has now while its points and values change, until told
  /// otherwise.
  void keepVolume(const std::string& tissue, bool on);
  [[nodiscard]] bool keepsVolume(const std::string& tissue) const {
    return keptVolumes_.contains(tissue);
  }

  /// The plane that mirrors the body; nothing before the meshes are there.
  [[nodiscard]] std::optional<MirrorPlane> mirrorPlane() const;
  /// Directions of fibres at vertices, while the display wants them; null: not there yet.
  [[nodiscard]] const std::shared_ptr<const mesh::Directions>& flow() const { return flow_; }

  void tell(Severity severity, const QString& text, std::optional<mesh::Vector3> place = {});

 signals:
  void projectChanged();
  void selectionChanged();
  void displayChanged();
  void liveChanged();    ///< meshes, domain or tissues are other ones
  void fieldsChanged();  ///< values of the same tissues
  void volumesChanged();
  void progressed(const QString& stage, double fraction);
  void settledChanged();
  void told(ecorche::Severity severity, const QString& text,
            const std::optional<Eigen::Vector3d>& place);

 private:
  std::unique_ptr<model::History> history_;
  bool open_ = false;
  std::filesystem::path file_;
  std::optional<model::Project> saved_;  // as the file has it

  struct Draft {
    std::vector<model::Command> commands;
    model::Project project;
  };
  std::optional<Draft> draft_;

  Selection selection_;
  Display display_;

  std::shared_ptr<const engine::LiveMeshes> meshes_;
  std::shared_ptr<const domain::DomainBuild> domain_;
  std::shared_ptr<engine::LiveTissues> tissues_;
  std::vector<double> volumes_;                   // by tissue id − 1 [m³]
  std::map<std::string, double> keptVolumes_;     // [m³]
  std::shared_ptr<const mesh::Directions> flow_;  // of tissues_
  bool flowIsNew_ = false;                        // of the fields as they are, or being made
  mutable std::optional<MirrorPlane> mirror_;     // of these:
  mutable std::shared_ptr<const engine::LiveMeshes> mirrorOf_;
  std::uint64_t fieldsRevision_ = 0;
  bool fieldsNew_ = false;             // since takeFieldEdits: all of them
  render::FieldChange fieldsChanged_;  // or these; neither ascending nor each once
  // Tissues that are not shown yet: what drawing them takes is made beside the window
  std::shared_ptr<engine::LiveTissues> coming_;
  std::shared_ptr<render::VolumeContent> prepared_;
  Background preparing_;
  Background measuring_;
  Background directing_;
  QTimer restForMeasuring_;
  QTimer restForSolving_;
  std::uint64_t request_ = 0;
  std::uint64_t firstRequest_ = 0;  // of the project at hand: answers to older ones are dropped
  bool settled_ = true;
  QString lastFault_;
  std::set<std::string> findingsTold_;          // of the tissues at hand
  Postbox post_;                                // from the engine's thread
  std::unique_ptr<engine::LiveEngine> engine_;  // last: gone before what its answers touch

  void changed(bool anew = false);
  void forgetWhatIsGone();
  void take(const engine::LiveUpdate& update);
  void prepareTissues();
  void showTissues(const std::shared_ptr<engine::LiveTissues>& tissues);
  void requestSolve(bool anew);
  void followEdits();
  [[nodiscard]] const model::Tissue* tissueOf(std::size_t entry,
                                              const std::vector<std::size_t>& places) const;
  bool followCurves();
  bool followValues();
  void noteChanged(std::size_t column, const std::vector<std::int32_t>& vertices);
  void measure();
  void direct();
  [[nodiscard]] std::optional<std::size_t> entryOf(const std::string& tissue) const;
  [[nodiscard]] Result<std::vector<model::Command>> valuesFor(const std::string& tissue,
                                                              double volume);
  [[nodiscard]] Result<std::vector<model::Command>> withFollowers(
      const std::vector<model::Command>& commands);
  void keepVolumes();
  void setSettled(bool settled);
};

}  // namespace ecorche::studio
