#pragma once

#include <ecorche/model/project.h>

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace ecorche::authoring {

/// A bone's name from its file: the stem without a leading "bone", blanks and dashes as
/// underscores. "BONEFemoris_L.stl" gives "Femoris_L", "bones-left femur.obj" gives "left_femur".
[[nodiscard]] std::string boneNameFrom(const std::filesystem::path& file);

/// A muscle's name from what a table calls it: without folder, mesh suffix, leading "musc" and "m."
/// or "mm.". "MUSCm.biceps_femoris_L.stl" gives "biceps_femoris_L", "M. biceps brachii" gives
/// "biceps_brachii".
[[nodiscard]] std::string muscleNameFrom(std::string_view text);

/// Left or right by a last word l, left, r, right (digits after it aside): "sartorius_L2". Unknown
/// otherwise.
[[nodiscard]] model::Side sideFrom(std::string_view name);

/// The name of the same thing on the other side: "sartorius_L2" gives "sartorius_R2", "left femur"
/// is not understood. Nothing where sideFrom knows no side.
[[nodiscard]] std::optional<std::string> mirroredName(std::string_view name);

/// The name without its word for a side: "sartorius_L2" gives "sartorius_2"; others as they are.
[[nodiscard]] std::string withoutSide(std::string_view name);

/// Lower case letters and digits only, for names that differ in spelling: "C-1" and "c_1" are both
/// "c1".
[[nodiscard]] std::string bareName(std::string_view name);

/// The same names, later ones numbered where they repeat: a, b, a gives a, b, a_2.
[[nodiscard]] std::vector<std::string> madeUnique(std::vector<std::string> names);

}  // namespace ecorche::authoring
