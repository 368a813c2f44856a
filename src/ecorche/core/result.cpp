#include <ecorche/core/result.h>

#include <fmt/format.h>

namespace ecorche {

std::string_view name(ErrorCode code) {
  switch (code) {
#define EC_NAME(x)   \
  case ErrorCode::x: \
    return #x;
    EC_NAME(FileMissing)
    EC_NAME(FileEmpty)
    EC_NAME(FileTruncated)
    EC_NAME(FileUnknownFormat)
    EC_NAME(FileSyntax)
    EC_NAME(FileNotWritable)
    EC_NAME(FileNotReadable)
    EC_NAME(UnknownKey)
    EC_NAME(MissingKey)
    EC_NAME(WrongType)
    EC_NAME(ValueOutOfRange)
    EC_NAME(SchemaTooNew)
    EC_NAME(DuplicateName)
    EC_NAME(TissueProtected)
    EC_NAME(UnknownName)
    EC_NAME(CommandSyntax)
    EC_NAME(NonFiniteVertex)
    EC_NAME(MeshWithoutFaces)
    EC_NAME(SkinNotClosed)
    EC_NAME(MeshNotRepairable)
    EC_NAME(BonesOutsideSkin)
    EC_NAME(UnitsDiffer)
    EC_NAME(EmptyDomain)
    EC_NAME(ComponentWithoutSkin)
    EC_NAME(MeshingFailed)
    EC_NAME(WorkerCrashed)
    EC_NAME(WorkerTimedOut)
    EC_NAME(WorkerMissing)
    EC_NAME(OutOfMemory)
    EC_NAME(MuscleWithoutCurve)
    EC_NAME(ZeroLengthCurve)
    EC_NAME(CurveOutsideSkin)
    EC_NAME(CurveOutsideDomain)
    EC_NAME(SystemSingular)
    EC_NAME(NonFiniteField)
    EC_NAME(FiberWithoutEnds)
    EC_NAME(CheckFailed)
    EC_NAME(NoGraphics)
    EC_NAME(Cancelled)
    EC_NAME(Internal)
#undef EC_NAME
  }
  return "Internal";
}

std::optional<ErrorCode> errorCodeNamed(std::string_view word) {
  for (int i = 0; i <= static_cast<int>(ErrorCode::Internal); ++i) {  // Internal is the last
    const auto code = static_cast<ErrorCode>(i);
    if (name(code) == word) return code;
  }
  return std::nullopt;
}

std::string Error::text() const {
  std::string where;
  if (!place.file.empty()) {
    where = place.file;
    if (place.line > 0) where += fmt::format(":{}", place.line);
    if (place.line > 0 && place.column > 0) where += fmt::format(":{}", place.column);
    where += ": ";
  }
  std::string spot;
  if (place.point) {
    spot = fmt::format(" (at {:.4g}, {:.4g}, {:.4g} m)", place.point->x(), place.point->y(),
                       place.point->z());
  }
  return where + message + spot;
}

tl::unexpected<Error> fail(ErrorCode code, std::string message, Place place) {
  return tl::unexpected<Error>(Error{code, std::move(message), std::move(place)});
}

}  // namespace ecorche
