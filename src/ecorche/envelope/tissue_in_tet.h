#pragma once

#include <ecorche/core/ids.h>

#include <compare>
#include <cstdint>

namespace ecorche::envelope {

/// A tissue in a tet of the domain.
struct TissueInTet {
  std::int32_t tet = -1;
  TissueId tissue;
  auto operator<=>(const TissueInTet&) const = default;
};

}  // namespace ecorche::envelope
