#pragma once

#include <ecorche/core/result.h>
#include <ecorche/core/run_context.h>
#include <ecorche/domain/domain.h>
#include <ecorche/fiber/fiber_field.h>
#include <ecorche/mesh/surface_mesh.h>
#include <ecorche/model/project.h>
#include <ecorche/tissue/tissue.h>

#include <vector>

namespace ecorche::engine {

/// The meshes that a project names, in metres: as they stand in their files, or mended where the
/// project asks for it.
struct ProjectMeshes {
  mesh::SurfaceMesh skin;
  std::vector<mesh::SurfaceMesh> bones;      ///< in project order, named as in the project
  std::vector<mesh::SurfaceMesh> obstacles;  ///< in project order
  std::vector<mesh::SurfaceMesh> cavities;   ///< in project order
  Findings findings;                         ///< what mending did, and how far it moved surfaces
};

/// Reads every file once, in parallel, however many parts of it are used.
/// @errors those of mesh::readMesh and mesh::mendSurface; UnknownName (a part that the file does
/// not hold, with those it does)
[[nodiscard]] Result<ProjectMeshes> loadMeshes(const model::Project& project, RunContext& run);

/// Muscles and fillers as the tissue room wants them: entry i has tissue id i + 2.
/// @pre model::findFault has nothing to say about the project
[[nodiscard]] std::vector<tissue::CurveTissue> curveTissues(const model::Project& project);

/// Place in Project::tissues of every entry of curveTissues.
[[nodiscard]] std::vector<std::size_t> curveTissuePlaces(const model::Project& project);

/// What every curve's ends sit on, for the fibres; entries as curveTissues, fillers empty.
[[nodiscard]] std::vector<fiber::MuscleEnds> muscleEnds(const model::Project& project);

[[nodiscard]] std::vector<domain::CutPlane> cutPlanes(const model::Project& project);

[[nodiscard]] tissue::TissueOptions tissueOptions(const model::Project& project);

/// Fat's and theirs, in the order of fields: entry i is that of tissue id i + 1.
[[nodiscard]] std::vector<std::string> fieldNames(const std::vector<tissue::CurveTissue>& tissues);

}  // namespace ecorche::engine
