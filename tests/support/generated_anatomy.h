#pragma once

#include <ecorche/domain/domain.h>
#include <ecorche/tissue/tissue_fields.h>

#include <cstdint>
#include <string>
#include <string_view>

namespace ecorche::test {

/// A domain and fields over it, made by rules from a seed: what the envelope has to cope with.
struct GeneratedAnatomy {
  std::string name;  ///< shape, fields and seed, for INFO
  domain::Domain domain;
  tissue::TissueFields fields;
  bool smooth = false;  ///< fields that a solver could have given: no exact ties
};

enum class Shape {
  Box,       ///< even grid: exact ties by symmetry
  Jittered,  ///< box with moved vertices
  Cylinder,  ///< side skin, ends cut planes
  Shell,     ///< between spheres: skin outside, bone 0 inside
  Torus,     ///< box with a hole right through
  Limb,      ///< tapered and bent, two bones side by side inside
  Slivers    ///< jittered box in which many tets are almost flat
};
inline constexpr int kShapeCount = 7;

enum class FieldKind {
  Bumps,         ///< Gaussian bumps about random segments, constant fat
  Noise,         ///< independent numbers at every vertex
  RoundedBumps,  ///< bumps rounded to 1/16: many ties
  RoundedNoise,  ///< noise rounded to 1/16
  TwoValues,     ///< 0 or 1 at random: ties nearly everywhere
  AllEqual,      ///< one value
  HalfConstant,  ///< bumps on one side, one value for all on the other
  NearTies,      ///< one smooth function plus differences near the last bit
  WildScales     ///< noise times 10^-150 … 10^150, a scale for each vertex
};
inline constexpr int kFieldKindCount = 9;

[[nodiscard]] std::string_view name(Shape shape);
[[nodiscard]] std::string_view name(FieldKind kind);

[[nodiscard]] domain::Domain generatedDomain(Shape shape, std::uint64_t seed);

/// @param fieldCount  with fat
[[nodiscard]] tissue::FieldMatrix generatedFields(const mesh::Positions& V, FieldKind kind,
                                                  int fieldCount, std::uint64_t seed);

/// Shape, kind and number of fields (2 … 9) follow from the seed; 63 seeds in a row meet every
/// pair.
[[nodiscard]] GeneratedAnatomy generatedAnatomy(std::uint64_t seed);

/// The benchmark's fields: exp(−d²/s²), d the distance to a random segment 0.25 … 0.6 long inside
/// the unit cube, s in 0.075 … 0.125, and constant fat of 0.35 in column 0.
[[nodiscard]] tissue::FieldMatrix benchFields(const mesh::Positions& V, int muscleCount,
                                              std::uint64_t seed);

}  // namespace ecorche::test
