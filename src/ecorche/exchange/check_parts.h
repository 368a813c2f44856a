#pragma once

#include <ecorche/core/run_context.h>
#include <ecorche/exchange/anatomy_file.h>
#include <ecorche/exchange/check_anatomy.h>
#include <ecorche/exchange/model_record.h>

#include <filesystem>
#include <optional>
#include <vector>

namespace ecorche::exchange {

/// What the parts of checkOutput share: files as they were read, and what follows from them alone.
struct CheckedFiles {
  std::filesystem::path folder;
  ModelRecord record;
  std::optional<AnatomyFile> vtu;
  std::optional<AnatomyFile> medit;
  const AnatomyFile* anatomy = nullptr;  ///< the VTU where there is one

  mesh::TetAdjacency adjacency;
  Eigen::VectorXd volume;                         ///< #T
  std::vector<std::vector<std::int32_t>> tetsOf;  ///< by tissue id; ids out of range are left out
  mesh::TetBoundary boundary;

  [[nodiscard]] Eigen::Vector3d centroid(std::int64_t tet) const;
  [[nodiscard]] const TissueRecord* tissue(std::int32_t id) const;
};

using Checks = std::vector<Check>;

/// formats-agree, labels-known, tets-positive, faces-shared, faces-marked, boundary-closed,
/// volumes-add-up
void checkTets(const CheckedFiles& files, Checks& checks);

/// muscles-closed, -manifold-edges, -manifold-vertices, -connected, curves-inside, surfaces-agree;
/// fills the figures.
/// @errors of reading the surfaces
[[nodiscard]] Result<void> checkMuscles(const CheckedFiles& files, CheckReport& report,
                                        RunContext& run);

/// fibers-unit, fibers-follow-curves, fibers-origin-to-insertion, fibers-no-extrema
void checkFibers(const CheckedFiles& files, Checks& checks);

/// skin-deviation, bone-deviation
/// @errors of reading the originals; Cancelled
[[nodiscard]] Result<void> checkDeviation(const CheckedFiles& files, Checks& checks,
                                          RunContext& run);

}  // namespace ecorche::exchange
