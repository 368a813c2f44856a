#pragma once

#include <ecorche/core/result.h>
#include <ecorche/model/project.h>

#include <optional>
#include <string>

namespace ecorche::model {

/// What is wrong with a project, and where: a JSON pointer ("/tissues/3/curves/0") into its file.
struct ProjectFault {
  ErrorCode code = ErrorCode::Internal;
  std::string message;  ///< names the thing, the value and the way out
  std::string pointer;
  std::string object;  ///< muscle, bone or plane by name
};

/// While a muscle is being made it may stand there without a curve; what is saved or built may not.
enum class Completeness { Editing, Complete };

/// The first rule that a project breaks; nothing if it keeps them all. One set of rules for files,
/// commands and `new`: names are given, unique, and known where they are used; numbers are finite
/// and in range; every curve has a length. Meshes are not looked at.
///
/// @return codes MissingKey, ValueOutOfRange, DuplicateName, UnknownName, MuscleWithoutCurve,
/// ZeroLengthCurve
[[nodiscard]] std::optional<ProjectFault> findFault(
    const Project& project, Completeness completeness = Completeness::Complete);

/// The same as a result, for a project that is to be built or measured.
/// @errors  the codes of findFault
[[nodiscard]] Result<void> checkProject(const Project& project);

/// Neighbouring control points have to be this far apart [m].
inline constexpr double kSmallestStep = 1e-9;
/// No coordinate lies farther out [m].
inline constexpr double kLargestCoordinate = 1e5;

}  // namespace ecorche::model
