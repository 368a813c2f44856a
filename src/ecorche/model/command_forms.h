#pragma once

// How commands are written, for command_format.cpp and command_parse.cpp only.

#include <ecorche/model/commands.h>

#include <string_view>
#include <variant>

namespace ecorche::model {

// The verb of every alternative of Command::Act, and its words in order: one description that a
// Formatter writes from, a Parser reads into and a Usage names.
template <class C>
struct Form;
#define EC_FORM(type, text)                         \
  template <>                                       \
  struct Form<type> {                               \
    static constexpr std::string_view kVerb = text; \
    template <class V>                              \
    static void words(V& v, type& c);               \
  };                                                \
  template <class V>                                \
  void Form<type>::words(V& v, type& c)

EC_FORM(SetProjectName, "project.name") { v.name("NAME", c.name); }
EC_FORM(SetProjectUnit, "project.unit") { v.unit("m|dm|cm|mm|in", c.unit); }
EC_FORM(SetSkin, "skin.set") { v.mesh(c.mesh); }
EC_FORM(AddBone, "bone.add") {
  v.name("BONE", c.bone.name);
  v.mesh(c.bone.mesh);
}
EC_FORM(SetBoneMesh, "bone.set") {
  v.name("BONE", c.bone);
  v.mesh(c.mesh);
}
EC_FORM(RemoveBone, "bone.remove") { v.name("BONE", c.bone); }
EC_FORM(RenameBone, "bone.rename") {
  v.name("BONE", c.bone);
  v.name("NAME", c.name);
}
EC_FORM(AddPlane, "plane.add") {
  v.name("PLANE", c.plane.name);
  v.choice(c.plane.kind);
  v.vector("X,Y,Z", c.plane.point);
  v.vector("NX,NY,NZ", c.plane.normal);
}
EC_FORM(RemovePlane, "plane.remove") { v.name("PLANE", c.plane); }
EC_FORM(RenamePlane, "plane.rename") {
  v.name("PLANE", c.plane);
  v.name("NAME", c.name);
}
EC_FORM(SetFat, "fat.set") { v.number("VALUE", c.value); }
EC_FORM(SetFatColour, "fat.colour") { v.colour(c.colour); }
EC_FORM(SetCoreRadius, "settings.core_radius") { v.number("METRES|none", c.radius); }
EC_FORM(SetAlpha, "settings.alpha") { v.number("VALUE|none", c.alpha); }
EC_FORM(SetTets, "settings.tets") { v.count("COUNT|none", c.count); }
EC_FORM(SetEdgeLength, "settings.edge_length") { v.number("METRES|none", c.length); }
EC_FORM(SetSurfaceTolerance, "settings.surface_tolerance") { v.number("SHARE", c.share); }
EC_FORM(AddMuscle, "muscle.add") { v.name("MUSCLE", c.name); }
EC_FORM(AddFiller, "filler.add") { v.name("FILLER", c.name); }
EC_FORM(AddObstacle, "obstacle.add") {
  v.name("OBSTACLE", c.name);
  v.mesh(c.mesh);
}
EC_FORM(AddCavity, "cavity.add") {
  v.name("CAVITY", c.name);
  v.mesh(c.mesh);
}
EC_FORM(SetTissueMesh, "obstacle.set") {
  v.name("OBSTACLE", c.tissue);
  v.mesh(c.mesh);
}
EC_FORM(RemoveTissue, "muscle.remove") { v.name("TISSUE", c.tissue); }
EC_FORM(RenameTissue, "muscle.rename") {
  v.name("TISSUE", c.tissue);
  v.name("NAME", c.name);
}
EC_FORM(SetColour, "muscle.colour") {
  v.name("TISSUE", c.tissue);
  v.colour(c.colour);
}
EC_FORM(SetSide, "muscle.side") {
  v.name("TISSUE", c.tissue);
  v.choice(c.side);
}
EC_FORM(SetGroup, "muscle.group") {
  v.name("TISSUE", c.tissue);
  v.name("GROUP", c.group);
}
EC_FORM(SetLayer, "muscle.layer") {
  v.name("TISSUE", c.tissue);
  v.count("LAYER|none", c.layer);
}
EC_FORM(SetProtected, "muscle.protect") {
  v.name("TISSUE", c.tissue);
  v.onOff(c.on);
}
EC_FORM(SetKeepsTwin, "muscle.keep_twin") {
  v.name("MUSCLE", c.tissue);
  v.onOff(c.on);
}
EC_FORM(SetTissueCore, "muscle.core") {
  v.name("MUSCLE", c.tissue);
  v.number("METRES|none", c.radius);
}
EC_FORM(SetAnisotropy, "muscle.anisotropy") {
  v.name("MUSCLE", c.tissue);
  v.number("LAMBDA2", c.anisotropy.lambda2);
  v.number("LAMBDA3", c.anisotropy.lambda3);
  v.number("RADIANS", c.anisotropy.rotation);
}
EC_FORM(AddCurve, "curve.add") {
  v.name("MUSCLE", c.tissue);
  v.points(c.curve.points);
  v.key("name", c.curve.name);
  v.key("start", c.curve.start);
  v.key("end", c.curve.end);
}
template <class V, class C>
void curveWords(V& v, C& c) {
  v.name("MUSCLE", c.tissue);
  v.index("CURVE", c.curve);
}
EC_FORM(RemoveCurve, "curve.remove") { curveWords(v, c); }
EC_FORM(RenameCurve, "curve.rename") {
  curveWords(v, c);
  v.name("NAME", c.name);
}
EC_FORM(MoveCurve, "curve.move") {
  curveWords(v, c);
  v.vector("DX,DY,DZ", c.by);
}
EC_FORM(SetCurvePoints, "curve.points") {
  curveWords(v, c);
  v.points(c.points);
}
EC_FORM(SetCurveStart, "curve.start") {
  curveWords(v, c);
  v.support(c.support);
}
EC_FORM(SetCurveEnd, "curve.end") {
  curveWords(v, c);
  v.support(c.support);
}
template <class V, class C>
void pointWords(V& v, C& c) {
  curveWords(v, c);
  v.index("POINT", c.point);
}
EC_FORM(MovePoint, "point.move") {
  pointWords(v, c);
  v.vector("X,Y,Z", c.at);
}
EC_FORM(InsertPoint, "point.insert") {
  pointWords(v, c);
  v.vector("X,Y,Z", c.value.at);
  v.key("tissue", c.value.tissue);
}
EC_FORM(RemovePoint, "point.remove") { pointWords(v, c); }
EC_FORM(SetPointValue, "point.value") {
  pointWords(v, c);
  v.number("VALUE", c.value);
}
EC_FORM(AddAttachment, "attachment.add") {
  v.name("MUSCLE", c.tissue);
  v.choice(c.attachment.role);
  v.support(c.attachment.support);
  v.key("at", c.attachment.at);
  v.key("patch", c.attachment.patch);
}
EC_FORM(RemoveAttachment, "attachment.remove") {
  v.name("MUSCLE", c.tissue);
  v.index("ATTACHMENT", c.attachment);
}
#undef EC_FORM

/// Calls visit(C{}) for every alternative of Command::Act, in order.
template <class Visit, class... C>
void eachCommand(const Visit& visit, const std::variant<C...>&) {
  (visit(C{}), ...);
}

}  // namespace ecorche::model
