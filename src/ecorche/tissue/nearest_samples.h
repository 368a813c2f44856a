#pragma once

#include <ecorche/tissue/tissue_fields.h>
#include <ecorche/tissue/well_radius.h>

#include <unordered_map>
#include <vector>

namespace ecorche::tissue {

/// Of all rows of a curve that know a vertex, the nearest speaks for it.
class NearestSamples {
 public:
  /// @param at      the row's place [m]
  /// @param sample  its index, larger than those before: of two as near the first counts
  void add(const domain::Domain& domain, const Well& well, const mesh::Vector3& at,
           std::int32_t sample);
  [[nodiscard]] std::vector<NearCurve> byVertex() const;

 private:
  struct Entry {
    std::int32_t sample;
    double error;
    double away2;  // [m²]
  };
  std::unordered_map<std::int32_t, Entry> nearest_;  // by vertex
};

}  // namespace ecorche::tissue
