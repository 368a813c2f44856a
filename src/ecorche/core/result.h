#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <string_view>
#include <tl/expected.hpp>

namespace ecorche {

/// What went wrong, one word for programs. The sentence for people stands in Error::message.
enum class ErrorCode {
  // Files
  FileMissing,
  FileEmpty,
  FileTruncated,
  FileUnknownFormat,
  FileSyntax,
  FileNotWritable,
  FileNotReadable,
  // Project
  UnknownKey,
  MissingKey,
  WrongType,
  ValueOutOfRange,
  SchemaTooNew,
  DuplicateName,
  TissueProtected,
  UnknownName,
  CommandSyntax,
  // Meshes
  NonFiniteVertex,
  MeshWithoutFaces,
  SkinNotClosed,
  MeshNotRepairable,
  // Domain
  BonesOutsideSkin,
  UnitsDiffer,
  EmptyDomain,
  ComponentWithoutSkin,
  MeshingFailed,
  WorkerCrashed,
  WorkerTimedOut,
  WorkerMissing,
  OutOfMemory,
  // Tissues
  MuscleWithoutCurve,
  ZeroLengthCurve,
  CurveOutsideSkin,
  CurveOutsideDomain,
  SystemSingular,
  // Envelope and fibres
  NonFiniteField,
  FiberWithoutEnds,
  CheckFailed,
  // Pictures
  NoGraphics,
  // Running
  Cancelled,
  Internal,
};

/// The enumerator's own name, as it stands in JSON and in the manual: "CurveOutsideSkin".
[[nodiscard]] std::string_view name(ErrorCode code);
/// The other way round; nothing for a word that is no code.
[[nodiscard]] std::optional<ErrorCode> errorCodeNamed(std::string_view word);

/// Where it went wrong: a spot in a file, or a thing of the model and a point to fly to.
struct Place {
  std::string file;                      ///< path as the user gave it; empty if no file is at fault
  int line = 0;                          ///< from 1; 0: unknown
  int column = 0;                        ///< from 1; 0: unknown
  std::string object;                    ///< mesh, muscle or bone by name
  std::optional<Eigen::Vector3d> point;  ///< world [m]
};

/// One failure: a code for programs, a sentence for people that names the thing, the value and the
/// way out.
struct Error {
  ErrorCode code = ErrorCode::Internal;
  std::string message;
  Place place;

  /// The one text that window and command line show: "forearm.ecorche:41:17: muscle "biceps" has no
  /// curve; ..."
  [[nodiscard]] std::string text() const;
};

template <class T>
using Result = tl::expected<T, Error>;

/// `return fail(ErrorCode::FileMissing, "…", {.file = path});`
[[nodiscard]] tl::unexpected<Error> fail(ErrorCode code, std::string message, Place place = {});

/// Hands the error of a failed result on to a caller with another value type.
template <class T>
[[nodiscard]] tl::unexpected<Error> passOn(const Result<T>& failed) {
  return tl::unexpected<Error>(failed.error());
}

}  // namespace ecorche
