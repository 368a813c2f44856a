#pragma once

#include <ecorche/core/result.h>
#include <ecorche/core/run_context.h>
#include <ecorche/domain/build_domain.h>
#include <ecorche/engine/estimate.h>
#include <ecorche/engine/inputs.h>
#include <ecorche/envelope/envelope.h>
#include <ecorche/envelope/tissue_surface.h>
#include <ecorche/fiber/fiber_field.h>
#include <ecorche/model/project.h>
#include <ecorche/tissue/tissue_fields.h>

#include <functional>
#include <optional>
#include <vector>

namespace ecorche::engine {

/// What tets go by, beside walls.
enum class Sizing {
  Draft,   ///< muscles as a coarse domain has them
  Curves,  ///< curves alone, nothing solved: for previews
  None     ///< as before any curve was drawn
};

struct BuildOptions {
  std::optional<std::int64_t> tets;  ///< instead of the project's
  std::optional<double> edgeLength;  ///< instead of the project's [m]
  std::optional<double> alpha;       ///< the paper's row weight, for comparison [unitless]
  double mesherTimeout = 300.0;      ///< of each attempt to fill the domain with tets [s]
  bool useCache = true;              ///< look for the domain in the cache and leave it there
  Sizing sizing = Sizing::Draft;
  /// What a draft would tell, where somebody knows it already (draft.h); asked for with
  /// Sizing::Draft.
  std::vector<domain::WantedLength> lengths;
  bool exact = false;  ///< envelope with raw places, see EnvelopeOptions::exact
  /// Told what the build will take, once meshes are read and before anything is made of them.
  std::function<void(const Estimate&)> onEstimate;
};

/// Everything that comes of a project, in the order in which it was made.
struct Build {
  ProjectMeshes meshes;
  std::vector<tissue::CurveTissue> tissues;  ///< entry i has tissue id i + 2
  domain::DomainBuild domain;
  tissue::CoreSamples cores;
  tissue::TissueFields fields;
  envelope::Anatomy anatomy;
  envelope::EnvelopeStats envelopeStats;
  std::vector<envelope::TissueSurface> surfaces;  ///< entry i of tissue id i + 1: fat first
  std::vector<envelope::TissueMeasure> measures;  ///< as surfaces
  fiber::FiberField fibers;
};

/// The domain of a project whose meshes are read: curves turned into sizing, cache asked.
/// @errors those of domain::buildDomain; OutOfMemory (more than the machine has, before it is
/// tried)
[[nodiscard]] Result<domain::DomainBuild> buildDomainOf(const model::Project& project,
                                                        const ProjectMeshes& meshes,
                                                        const BuildOptions& options,
                                                        RunContext& run);

/// The same, meshes read first.
/// @errors those of loadMeshes and domain::buildDomain
struct PreparedDomain {
  ProjectMeshes meshes;
  domain::DomainBuild build;
};
[[nodiscard]] Result<PreparedDomain> prepareDomain(const model::Project& project,
                                                   const BuildOptions& options, RunContext& run);

/// Skin, bones and curves in; labelled tets, surfaces and fibres out. Touches no file but the
/// project's meshes and the cache.
///
/// @errors what findFault says about the project, and those of every room on the way
[[nodiscard]] Result<Build> build(const model::Project& project, const BuildOptions& options,
                                  RunContext& run);

/// Volume of every muscle and filler after the fields alone, entry i of tissue id i + 2 [m³]: what
/// the resolution bench and target volumes look at.
[[nodiscard]] std::vector<double> tissueVolumes(const Build& build);

}  // namespace ecorche::engine
