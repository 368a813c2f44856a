#pragma once

#include <ecorche/envelope/tissue_in_tet.h>
#include <ecorche/mesh/types.h>

#include <array>
#include <map>
#include <span>
#include <vector>

namespace ecorche::envelope {

/// Which fields compete at a vertex, on an edge, on a face and in a tet.
///
/// Tissues are struck tet by tet (islands.h), but what several tets share must look the same from
/// all of them: a field is out on a shared simplex if it is struck in every tet around it. (If it
/// is struck in some and shows there nonetheless, the diagram reports a conflict; islands.h
/// resolves it.)
class Candidates {
 public:
  using Columns = std::span<const std::int32_t>;  ///< ascending

  /// @param fieldCount  columns of the field matrix; tissue id j + 1 is column j
  /// @param fatCompetes false takes column 0 out everywhere
  /// @param struck      tissues that may own nothing in one tet; in every tet some field must be
  /// left
  Candidates(const mesh::Tets& T, std::int32_t fieldCount, bool fatCompetes,
             std::span<const TissueInTet> struck);

  [[nodiscard]] std::int32_t first() const { return first_; }
  [[nodiscard]] std::int32_t end() const { return end_; }

  [[nodiscard]] Columns outAtVertex(std::int32_t v) const;
  [[nodiscard]] Columns outOnEdge(std::int32_t a, std::int32_t b) const;  ///< a < b
  [[nodiscard]] Columns outOnFace(std::int32_t a, std::int32_t b,
                                  std::int32_t c) const;  ///< a < b < c
  [[nodiscard]] Columns outInTet(std::int32_t t) const;
  [[nodiscard]] const std::map<std::int32_t, std::vector<std::int32_t>>& struckTets() const {
    return tets_;
  }

 private:
  std::int32_t first_;
  std::int32_t end_;
  std::map<std::int32_t, std::vector<std::int32_t>> tets_;
  std::map<std::array<std::int32_t, 1>, std::vector<std::int32_t>> vertices_;
  std::map<std::array<std::int32_t, 2>, std::vector<std::int32_t>> edges_;
  std::map<std::array<std::int32_t, 3>, std::vector<std::int32_t>> faces_;
};

}  // namespace ecorche::envelope
