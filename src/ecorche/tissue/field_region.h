#pragma once

#include <ecorche/tissue/tissue_solver.h>

#include <cstdint>
#include <memory>
#include <vector>

namespace ecorche::tissue {

/// Part of a domain as a mesh of its own, for a field that is nothing outside.
///
/// Its rows are those of the solver that lie in it, in their order; vertices of tets that reach out
/// of it are held at 0, as skin is.
struct FieldRegion {
  mesh::TetMesh mesh;
  std::vector<std::int32_t> vertex;  ///< of the domain, for each of the mesh's
  std::vector<std::int32_t> tet;     ///< #T of the domain, which of the mesh it is; −1: none
  std::vector<std::int32_t> row;     ///< of the solver, for each of the pattern's
  std::vector<std::int32_t> slot;    ///< entry of the solver's pattern, for each of the pattern's
  std::vector<std::int32_t> rim;     ///< rows beside rows that are outside
  std::shared_ptr<const mesh::StiffnessPattern> pattern;
  std::shared_ptr<const mesh::SymbolicCholesky> symbolic;  ///< by the solver's ordering
  std::shared_ptr<const mesh::NeighbourRows> neighbours;

  /// @param inside  #rows of the solver's pattern, one at least
  FieldRegion(const TissueSolver& solver, const std::vector<std::uint8_t>& inside);

  /// No row is outside: rows are the solver's.
  [[nodiscard]] bool isWhole() const { return whole_; }
  /// Samples that lie in tets of it, told by its own.
  [[nodiscard]] std::vector<CoreSample> within(const std::vector<CoreSample>& samples) const;
  /// Values on the solver's pattern that its pattern has, too.
  [[nodiscard]] std::vector<double> gather(const std::vector<double>& values) const;

 private:
  bool whole_ = false;
};

}  // namespace ecorche::tissue
