#pragma once

#include <ecorche/model/project.h>

#include <vector>

namespace ecorche::engine {

// What each stage of a live session depends on, as a project in which all else is left blank: two
// projects with equal parts have equal results. A renamed muscle computes nothing, a moved cut
// plane everything.

/// Skin, bones, obstacles and cavities, and where their files lie.
[[nodiscard]] model::Project meshPart(const model::Project& project);
/// Those, cut planes and what sizes tets: what a preview's domain is made of.
[[nodiscard]] model::Project domainPart(const model::Project& project);
/// Those, curves, cores, anisotropy: what fields are solved for. Tissues are those of
/// liveTissuePlaces, in order and nameless. Values and fat are not in it: fields follow them
/// without solving (tissue::ValueFields).
[[nodiscard]] model::Project curvePart(const model::Project& project);

/// Place in Project::tissues of everything that has a curve to grow from; muscles that are just
/// being begun are not among them.
[[nodiscard]] std::vector<std::size_t> liveTissuePlaces(const model::Project& project);

}  // namespace ecorche::engine
