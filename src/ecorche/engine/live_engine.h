#pragma once

#include <ecorche/authoring/snap.h>
#include <ecorche/core/finding.h>
#include <ecorche/core/subprocess.h>
#include <ecorche/domain/build_domain.h>
#include <ecorche/engine/inputs.h>
#include <ecorche/model/project.h>
#include <ecorche/render/palette.h>
#include <ecorche/render/volume_geometry.h>
#include <ecorche/tissue/value_fields.h>

#include <algorithm>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace ecorche::engine {

/// The project's meshes, ready to be asked where a stroke meets bone.
struct LiveMeshes {
  ProjectMeshes meshes;
  double diagonal = 0.0;  ///< of the skin [m]
  /// The skin, closed; null where it is open or without faces: nothing can be said to be inside it.
  std::shared_ptr<const mesh::SurfaceQuery> skin;
  std::vector<authoring::BoneSurface> bones;  ///< those with a face, in project order
};

/// Muscles and fillers as they were solved for one request, ready to be drawn. Whoever gets them
/// may go on and edit their values; the engine keeps nothing of them.
struct LiveTissues {
  std::shared_ptr<const domain::DomainBuild> domain;
  std::shared_ptr<const render::VolumeGeometry> geometry;  ///< of the domain
  std::shared_ptr<tissue::ValueFields> fields;
  std::vector<std::size_t>
      slotOf;                   ///< entry i, tissue id i + 2: which of liveTissuePlaces(project)
  std::vector<double> volumes;  ///< by tissue id − 1, fat first [m³]
  render::NeighbourPairs touching;  ///< entries that share a wall
  Findings findings;                ///< muscles that were left out and why
  bool isKept = false;              ///< found as it was settled before, not solved again
  double seconds = 0.0;             ///< that all this took, domain apart
};

/// What a live session says, in order. `revision` is that of the request which it answers.
struct LiveProgress {
  std::string stage;
  double fraction = 0.0;  ///< in [0, 1]
};
struct LiveFault {
  Error error;
};
struct LiveIdle {};  ///< everything asked for is there, or failed
struct LiveUpdate {
  std::uint64_t revision = 0;
  std::variant<LiveProgress, std::shared_ptr<const LiveMeshes>,
               std::shared_ptr<const domain::DomainBuild>, std::shared_ptr<LiveTissues>, LiveFault,
               LiveIdle>
      what;
};

struct LiveOptions {
  /// Where neither the project nor the machine asks for fewer: enough for a view, soon there.
  std::int64_t tets = 120'000;
  bool useCache = true;
  /// Once tissues are there, tets are made anew: small where muscles meet, large elsewhere.
  bool refine = false;
  /// Of settled results that undo and redo find again [bytes]: an eighth of the machine's, 2 GiB at
  /// most.
  std::size_t undoBytes = std::min(workerMemoryLimit() / 6, std::size_t{2} << 30);
};

/// Keeps meshes, domain and tissues in step with a project that changes: each request is answered
/// in the background by as little work as it takes (live_parts.h), the newest first. Work that a
/// newer request has made stale is cancelled, and nothing of it is told. Once all is answered and
/// curves have moved to where tets are large, the domain is made anew with small tets around them;
/// what is there stays until the same tissues are there on the new one.
class LiveEngine {
 public:
  /// @param sink  called on the engine's own thread; must not wait for the engine
  using Sink = std::function<void(LiveUpdate)>;
  explicit LiveEngine(Sink sink, LiveOptions options = {});
  LiveEngine(const LiveEngine&) = delete;
  LiveEngine& operator=(const LiveEngine&) = delete;
  ~LiveEngine();  ///< cancels, and waits for the stage at hand to notice

  /// The project is a snapshot; it may be incomplete (model::Completeness::Editing).
  /// @param anew  another project, or files may have changed: everything is read and told again
  /// Values and fat of a project whose curves have not changed are no reason to answer.
  void request(model::Project project, std::uint64_t revision, bool anew = false);
  /// LiveOptions::refine, from the next request on.
  void setRefining(bool on);
  /// Gives up what is being computed; what is there stays. The next request goes on from there.
  void cancel();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace ecorche::engine
