#pragma once

#include <ecorche/model/commands.h>

#include <rapidcheck.h>

#include <cmath>

namespace ecorche::test {

// Random acts for property tests. Names are any bytes, numbers any finite doubles: what a project
// may not hold has to be refused by apply, not by the text form.

using namespace model;  // NOLINT: for the generators below only

inline double anyDouble() {
  const double common = *rc::gen::element(0.0, 1.0, 0.3, -2.5, 1e-3, 1e5, 1e-300, 1e300, 5e-324);
  const double spread = *rc::gen::inRange(-1000000, 1000000) * 1e-3 / 7.0;
  return *rc::gen::element(common, spread);
}
inline Vector3 anyVector() { return {anyDouble(), anyDouble(), anyDouble()}; }
inline std::string anyName() {
  const std::string wild = *rc::gen::arbitrary<std::string>();
  const std::string tame =
      *rc::gen::element<std::string>("biceps", "humerus", "long head", "a=b", "say \"ah\"",
                                     "back\\slash", "Écorché", "none", "#1", "", "belly", "median");
  return *rc::gen::element(wild, tame);
}
template <class T, class Make>
std::optional<T> maybe(const Make& make) {
  return *rc::gen::arbitrary<bool>() ? std::optional<T>(make()) : std::nullopt;
}
inline std::size_t anyIndex() { return *rc::gen::inRange<std::size_t>(0, 5); }
inline Unit anyUnit() {
  return *rc::gen::element(Unit::Metre, Unit::Decimetre, Unit::Centimetre, Unit::Millimetre,
                           Unit::Inch);
}
inline MeshRef anyPatch() { return {anyName(), anyName(), maybe<Unit>(anyUnit)}; }
inline MeshRef anyMesh() {
  MeshRef out = anyPatch();
  out.repair = *rc::gen::element(mesh::Mending::None, mesh::Mending::FillHoles,
                                 mesh::Mending::OuterHull, mesh::Mending::Wrap);
  return out;
}
inline Colour anyColour() {
  return {*rc::gen::arbitrary<std::uint8_t>(), *rc::gen::arbitrary<std::uint8_t>(),
          *rc::gen::arbitrary<std::uint8_t>()};
}
inline Support anySupport() {
  const auto on = *rc::gen::element(Support::On::Free, Support::On::Bone, Support::On::Plane,
                                    Support::On::Tissue);
  return {on, on == Support::On::Free ? std::string() : anyName()};
}
inline std::vector<ControlPoint> anyPoints() {
  std::vector<ControlPoint> points;
  const bool same = *rc::gen::arbitrary<bool>();
  const double value = anyDouble();
  for (int k = *rc::gen::inRange(1, 6); k > 0; --k)
    points.push_back({anyVector(), same ? value : anyDouble()});
  return points;
}

/// Fills whatever fields a command has.
template <class C>
C anyAct();
#define EC_ANY(type, ...)      \
  template <>                  \
  inline type anyAct<type>() { \
    return type{__VA_ARGS__};  \
  }
EC_ANY(SetProjectName, anyName())
EC_ANY(SetProjectUnit, anyUnit())
EC_ANY(SetSkin, anyMesh())
EC_ANY(AddBone, {anyName(), anyMesh()})
EC_ANY(SetBoneMesh, anyName(), anyMesh())
EC_ANY(RemoveBone, anyName())
EC_ANY(RenameBone, anyName(), anyName())
EC_ANY(AddPlane, {anyName(), *rc::gen::element(CutPlane::Kind::Symmetry, CutPlane::Kind::Region),
                  anyVector(), anyVector()})
EC_ANY(RemovePlane, anyName())
EC_ANY(RenamePlane, anyName(), anyName())
EC_ANY(SetFat, anyDouble())
EC_ANY(SetFatColour, maybe<Colour>(anyColour))
EC_ANY(SetCoreRadius, maybe<double>(anyDouble))
EC_ANY(SetAlpha, maybe<double>(anyDouble))
EC_ANY(SetTets, maybe<std::int64_t>([] { return *rc::gen::arbitrary<std::int64_t>(); }))
EC_ANY(SetEdgeLength, maybe<double>(anyDouble))
EC_ANY(SetSurfaceTolerance, anyDouble())
EC_ANY(AddMuscle, anyName())
EC_ANY(AddFiller, anyName())
EC_ANY(AddObstacle, anyName(), anyMesh())
EC_ANY(AddCavity, anyName(), anyMesh())
EC_ANY(SetTissueMesh, anyName(), anyMesh())
EC_ANY(RemoveTissue, anyName())
EC_ANY(RenameTissue, anyName(), anyName())
EC_ANY(SetColour, anyName(), maybe<Colour>(anyColour))
EC_ANY(SetSide, anyName(), *rc::gen::element(Side::Unknown, Side::Left, Side::Right, Side::Median))
EC_ANY(SetGroup, anyName(), anyName())
EC_ANY(SetLayer, anyName(),
       maybe<std::int64_t>([] { return *rc::gen::inRange<std::int64_t>(-2, 1002); }))
EC_ANY(SetProtected, anyName(), *rc::gen::arbitrary<bool>())
EC_ANY(SetKeepsTwin, anyName(), *rc::gen::arbitrary<bool>())
EC_ANY(SetTissueCore, anyName(), maybe<double>(anyDouble))
EC_ANY(SetAnisotropy, anyName(), {anyDouble(), anyDouble(), anyDouble()})
EC_ANY(AddCurve, anyName(), {anyName(), anyPoints(), anySupport(), anySupport()})
EC_ANY(RemoveCurve, anyName(), anyIndex())
EC_ANY(RenameCurve, anyName(), anyIndex(), anyName())
EC_ANY(MoveCurve, anyName(), anyIndex(), anyVector())
EC_ANY(SetCurvePoints, anyName(), anyIndex(), anyPoints())
EC_ANY(SetCurveStart, anyName(), anyIndex(), anySupport())
EC_ANY(SetCurveEnd, anyName(), anyIndex(), anySupport())
EC_ANY(MovePoint, anyName(), anyIndex(), anyIndex(), anyVector())
EC_ANY(InsertPoint, anyName(), anyIndex(), anyIndex(), {anyVector(), anyDouble()})
EC_ANY(RemovePoint, anyName(), anyIndex(), anyIndex())
EC_ANY(SetPointValue, anyName(), anyIndex(), anyIndex(), anyDouble())
EC_ANY(AddAttachment, anyName(),
       {*rc::gen::element(Attachment::Role::Unknown, Attachment::Role::Origin,
                          Attachment::Role::Insertion),
        anySupport(), maybe<Vector3>(anyVector), maybe<MeshRef>(anyPatch)})
EC_ANY(RemoveAttachment, anyName(), anyIndex())
#undef EC_ANY

template <class... C>
Command anyOf(const std::variant<C...>&) {
  static const std::vector<Command (*)()> kMakers = {[] { return Command(anyAct<C>()); }...};
  return kMakers[*rc::gen::inRange<std::size_t>(0, kMakers.size())]();
}
/// Inside rc::prop or rc::check only.
inline Command anyCommand() { return anyOf(Command::Act()); }

}  // namespace ecorche::test
