#pragma once

#include <compare>
#include <cstdint>
#include <functional>

namespace ecorche {

/// An index that knows what it counts: a VertexId cannot be handed over as a TetId. -1 is "none".
template <class Tag>
struct Id {
  std::int32_t value = -1;

  constexpr Id() = default;
  constexpr explicit Id(std::int64_t v) : value(static_cast<std::int32_t>(v)) {}
  [[nodiscard]] constexpr bool valid() const { return value >= 0; }
  constexpr auto operator<=>(const Id&) const = default;
};

using VertexId = Id<struct VertexTag>;
using FaceId = Id<struct FaceTag>;
using TetId = Id<struct TetTag>;
using BoneId = Id<struct BoneTag>;
using CurveId = Id<struct CurveTag>;

/// Tissue ids as they are written to files: 0 none, 1 fat, from 2 on muscles and fillers in project
/// order.
using TissueId = Id<struct TissueTag>;
inline constexpr TissueId kNoTissue{0};
inline constexpr TissueId kFat{1};
inline constexpr TissueId kFirstMuscle{2};

}  // namespace ecorche

template <class Tag>
struct std::hash<ecorche::Id<Tag>> {
  std::size_t operator()(ecorche::Id<Tag> id) const noexcept {
    return std::hash<std::int32_t>{}(id.value);
  }
};
