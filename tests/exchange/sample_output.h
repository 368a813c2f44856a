#pragma once

#include <ecorche/exchange/output_folder.h>

#include <filesystem>
#include <string>
#include <vector>

#include "fiber/shapes.h"

namespace ecorche::test {

/// A whole small model: a round limb of fat between two bone plates, with two muscles side by side.
struct SampleOutput {
  Shape shape;
  std::vector<tissue::CurveTissue> tissues;
  fiber::FiberField fibers;
  std::vector<mesh::SurfaceMesh> surfaces;
  mesh::SurfaceMesh skin;
  std::vector<mesh::SurfaceMesh> bones;
  std::vector<exchange::OriginalSurface> originals;
  std::vector<domain::CutPlane> planes;

  [[nodiscard]] exchange::OutputContents contents() const {
    return {shape.anatomy, shape.domain, tissues, fibers, surfaces, originals, planes, 0.001};
  }
};

/// @param firstName  of the first muscle
[[nodiscard]] SampleOutput makeSample(const std::string& firstName = "biceps brachii",
                                      std::array<int, 3> cells = {10, 10, 16});

/// Made once for all tests of a program.
inline const SampleOutput& sample() {
  static const SampleOutput made = makeSample();
  return made;
}

/// Writes the sample whole; fails the test where that fails.
exchange::WrittenOutput writeSample(const SampleOutput& sample, const std::filesystem::path& folder,
                                    const exchange::OutputFormats& formats = {});

/// Faces between tets of one label and the rest, as a surface of its own.
[[nodiscard]] mesh::SurfaceMesh surfaceOfLabel(const envelope::Anatomy& anatomy, TissueId id,
                                               std::string name);

}  // namespace ecorche::test
