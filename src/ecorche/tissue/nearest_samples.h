#pragma once

#include <ecorche/tissue/tissue_fields.h>
#include <ecorche/tissue/well_radius.h>

#include <vector>

namespace ecorche::tissue {

/// Of all rows of a curve that know a vertex, the nearest speaks for it.
class NearestSamples {
 public:
  /// @param at      the row's place [m]
  /// @param sample  its index
  void add(const domain::Domain& domain, const Well& well, const mesh::Vector3& at,
           std::int32_t sample);
  [[nodiscard]] std::vector<NearCurve> byVertex();

 private:
  struct Entry {
    NearCurve what;
    double away2;  // [m²]
  };
  std::vector<Entry> entries_;
};

}  // namespace ecorche::tissue
