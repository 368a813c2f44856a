#pragma once

#include <ecorche/core/result.h>
#include <ecorche/model/project.h>

#include <string>
#include <string_view>
#include <type_traits>
#include <variant>
#include <vector>

namespace ecorche::model {

// Every act on a project is a value with a text form: the window, scripts, tests and the journal
// use the same ones. Lengths are in metres, whatever the project's unit. Curves, points and
// attachments count from 0 here and from 1 in text. Names refer; numbers that a project may not
// hold are refused by apply.

struct SetProjectName {
  std::string name;
  bool operator==(const SetProjectName&) const = default;
};
struct SetProjectUnit {
  Unit unit = Unit::Metre;
  bool operator==(const SetProjectUnit&) const = default;
};
struct SetSkin {
  MeshRef mesh;
  bool operator==(const SetSkin&) const = default;
};

struct AddBone {
  Bone bone;
  bool operator==(const AddBone&) const = default;
};
/// Another mesh for it, or the same one otherwise read: unit, part, repair. What sits on it stays.
struct SetBoneMesh {
  std::string bone;
  MeshRef mesh;
  bool operator==(const SetBoneMesh&) const = default;
};
/// What sat on it becomes free.
struct RemoveBone {
  std::string bone;
  bool operator==(const RemoveBone&) const = default;
};
/// What sits on it follows. Also for planes and tissues.
struct RenameBone {
  std::string bone, name;
  bool operator==(const RenameBone&) const = default;
};

/// The normal need not be of unit length here.
struct AddPlane {
  CutPlane plane;
  bool operator==(const AddPlane&) const = default;
};
struct RemovePlane {
  std::string plane;
  bool operator==(const RemovePlane&) const = default;
};
struct RenamePlane {
  std::string plane, name;
  bool operator==(const RenamePlane&) const = default;
};

struct SetFat {
  double value = 0.3;
  bool operator==(const SetFat&) const = default;
};
struct SetFatColour {
  std::optional<Colour> colour;
  bool operator==(const SetFatColour&) const = default;
};
/// Core radius and alpha exclude each other, tets and edge length too: the new one takes the
/// other's place.
struct SetCoreRadius {
  std::optional<double> radius;
  bool operator==(const SetCoreRadius&) const = default;
};
struct SetAlpha {
  std::optional<double> alpha;
  bool operator==(const SetAlpha&) const = default;
};
struct SetTets {
  std::optional<std::int64_t> count;
  bool operator==(const SetTets&) const = default;
};
struct SetEdgeLength {
  std::optional<double> length;
  bool operator==(const SetEdgeLength&) const = default;
};
struct SetSurfaceTolerance {
  double share = 0.001;
  bool operator==(const SetSurfaceTolerance&) const = default;
};

/// A muscle or filler begins without curves; it can be saved once it has one.
struct AddMuscle {
  std::string name;
  bool operator==(const AddMuscle&) const = default;
};
struct AddFiller {
  std::string name;
  bool operator==(const AddFiller&) const = default;
};
struct AddObstacle {
  std::string name;
  MeshRef mesh;
  bool operator==(const AddObstacle&) const = default;
};
struct AddCavity {
  std::string name;
  MeshRef mesh;
  bool operator==(const AddCavity&) const = default;
};
/// Of an obstacle or a cavity.
struct SetTissueMesh {
  std::string tissue;
  MeshRef mesh;
  bool operator==(const SetTissueMesh&) const = default;
};
struct RemoveTissue {
  std::string tissue;
  bool operator==(const RemoveTissue&) const = default;
};
struct RenameTissue {
  std::string tissue, name;
  bool operator==(const RenameTissue&) const = default;
};
struct SetColour {
  std::string tissue;
  std::optional<Colour> colour;
  bool operator==(const SetColour&) const = default;
};
struct SetSide {
  std::string tissue;
  Side side = Side::Unknown;
  bool operator==(const SetSide&) const = default;
};
struct SetGroup {
  std::string tissue, group;
  bool operator==(const SetGroup&) const = default;
};
struct SetLayer {
  std::string tissue;
  std::optional<std::int64_t> layer;
  bool operator==(const SetLayer&) const = default;
};
/// A protected tissue keeps its body: curves, values and mesh, and its name and place. What it
/// looks like may change.
struct SetProtected {
  std::string tissue;
  bool on = false;
  bool operator==(const SetProtected&) const = default;
};
/// Its mirror image follows edits of it: windows see to that; apply only remembers it.
struct SetKeepsTwin {
  std::string tissue;
  bool on = false;
  bool operator==(const SetKeepsTwin&) const = default;
};
struct SetTissueCore {
  std::string tissue;
  std::optional<double> radius;
  bool operator==(const SetTissueCore&) const = default;
};
struct SetAnisotropy {
  std::string tissue;
  Anisotropy anisotropy;
  bool operator==(const SetAnisotropy&) const = default;
};

struct AddCurve {
  std::string tissue;
  Curve curve;
  bool operator==(const AddCurve&) const = default;
};
struct RemoveCurve {
  std::string tissue;
  std::size_t curve = 0;
  bool operator==(const RemoveCurve&) const = default;
};
struct RenameCurve {
  std::string tissue;
  std::size_t curve = 0;
  std::string name;
  bool operator==(const RenameCurve&) const = default;
};
struct MoveCurve {
  std::string tissue;
  std::size_t curve = 0;
  Vector3 by = Vector3::Zero();
  bool operator==(const MoveCurve&) const = default;
};
/// All control points anew, as a fit gives them.
struct SetCurvePoints {
  std::string tissue;
  std::size_t curve = 0;
  std::vector<ControlPoint> points;
  bool operator==(const SetCurvePoints&) const = default;
};
struct SetCurveStart {
  std::string tissue;
  std::size_t curve = 0;
  Support support;
  bool operator==(const SetCurveStart&) const = default;
};
struct SetCurveEnd {
  std::string tissue;
  std::size_t curve = 0;
  Support support;
  bool operator==(const SetCurveEnd&) const = default;
};

struct MovePoint {
  std::string tissue;
  std::size_t curve = 0, point = 0;
  Vector3 at = Vector3::Zero();
  bool operator==(const MovePoint&) const = default;
};
/// The new point gets this place in the list; one past the last appends.
struct InsertPoint {
  std::string tissue;
  std::size_t curve = 0, point = 0;
  ControlPoint value;
  bool operator==(const InsertPoint&) const = default;
};
struct RemovePoint {
  std::string tissue;
  std::size_t curve = 0, point = 0;
  bool operator==(const RemovePoint&) const = default;
};
struct SetPointValue {
  std::string tissue;
  std::size_t curve = 0, point = 0;
  double value = 1.0;
  bool operator==(const SetPointValue&) const = default;
};

struct AddAttachment {
  std::string tissue;
  Attachment attachment;
  bool operator==(const AddAttachment&) const = default;
};
struct RemoveAttachment {
  std::string tissue;
  std::size_t attachment = 0;
  bool operator==(const RemoveAttachment&) const = default;
};

/// Any of the above. Not the variant itself: calls of apply would find std::apply, too.
struct Command {
  using Act =
      std::variant<SetProjectName, SetProjectUnit, SetSkin, AddBone, SetBoneMesh, RemoveBone,
                   RenameBone, AddPlane, RemovePlane, RenamePlane, SetFat, SetFatColour,
                   SetCoreRadius, SetAlpha, SetTets, SetEdgeLength, SetSurfaceTolerance, AddMuscle,
                   AddFiller, AddObstacle, AddCavity, SetTissueMesh, RemoveTissue, RenameTissue,
                   SetColour, SetSide, SetGroup, SetLayer, SetProtected, SetKeepsTwin,
                   SetTissueCore, SetAnisotropy, AddCurve, RemoveCurve, RenameCurve, MoveCurve,
                   SetCurvePoints, SetCurveStart, SetCurveEnd, MovePoint, InsertPoint, RemovePoint,
                   SetPointValue, AddAttachment, RemoveAttachment>;
  Act act;

  Command() = default;
  template <class C>
  requires(std::is_constructible_v<Act, C> && !std::is_same_v<std::remove_cvref_t<C>, Command>)
      Command(C&& c)
      : act(std::forward<C>(c)) {}  // NOLINT: every act is a command
  bool operator==(const Command&) const = default;
};

/// The project after the act; pure, so undo only has to keep `before`.
/// @errors UnknownName, TissueProtected, ValueOutOfRange, DuplicateName, ZeroLengthCurve …
/// (findFault while editing); `before` stays.
[[nodiscard]] Result<Project> apply(const Project& before, const Command& command);

}  // namespace ecorche::model
