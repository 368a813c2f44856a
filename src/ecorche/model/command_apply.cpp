#include <ecorche/model/command_text.h>
#include <ecorche/model/commands.h>
#include <ecorche/model/project_check.h>

#include <fmt/format.h>

#include <algorithm>

namespace ecorche::model {

namespace {

using Done = Result<void>;

// One `act` per command, on a copy of the project. They look things up and change them; whether the
// outcome is a project is findFault's question.
class Editor {
 public:
  explicit Editor(Project& project) : p_(project) {}

  Done act(const SetProjectName& c) { return set(p_.name, c.name); }
  Done act(const SetProjectUnit& c) { return set(p_.unit, c.unit); }
  Done act(const SetSkin& c) { return set(p_.skin, c.mesh); }

  Done act(const AddBone& c) { return append(p_.bones, c.bone); }
  Done act(const SetBoneMesh& c) {
    const auto place = findBone(p_, c.bone);
    if (!place) return unknown("bone", c.bone);
    return set(p_.bones[*place].mesh, c.mesh);
  }
  Done act(const RemoveBone& c) { return removeNamed(p_.bones, c.bone, Support::On::Bone, "bone"); }
  Done act(const RenameBone& c) {
    return renameNamed(p_.bones, c.bone, c.name, Support::On::Bone, "bone");
  }

  Done act(const AddPlane& c) {
    CutPlane plane = c.plane;
    const double size = plane.normal.stableNorm();
    if (size > 0.0 && std::abs(size - 1.0) > 1e-12) plane.normal /= size;
    return append(p_.cutPlanes, plane);
  }
  Done act(const RemovePlane& c) {
    return removeNamed(p_.cutPlanes, c.plane, Support::On::Plane, "cut plane");
  }
  Done act(const RenamePlane& c) {
    return renameNamed(p_.cutPlanes, c.plane, c.name, Support::On::Plane, "cut plane");
  }

  Done act(const SetFat& c) { return set(p_.settings.fat, c.value); }
  Done act(const SetFatColour& c) {
    auto fat = std::ranges::find(p_.tissues, Tissue::Kind::Fat, &Tissue::kind);
    if (fat == p_.tissues.end()) {
      if (!c.colour) return {};
      fat = p_.tissues.insert(fat, Tissue{.name = "fat", .kind = Tissue::Kind::Fat});
    }
    return set(fat->colour, c.colour);
  }
  Done act(const SetCoreRadius& c) {
    if (c.radius) p_.settings.alpha.reset();
    return set(p_.settings.coreRadius, c.radius);
  }
  Done act(const SetAlpha& c) {
    if (c.alpha) p_.settings.coreRadius.reset();
    return set(p_.settings.alpha, c.alpha);
  }
  Done act(const SetTets& c) {
    if (c.count) p_.settings.edgeLength.reset();
    return set(p_.settings.tets, c.count);
  }
  Done act(const SetEdgeLength& c) {
    if (c.length) p_.settings.tets.reset();
    return set(p_.settings.edgeLength, c.length);
  }
  Done act(const SetSurfaceTolerance& c) { return set(p_.settings.surfaceTolerance, c.share); }

  Done act(const AddMuscle& c) {
    return append(p_.tissues, {.name = c.name, .kind = Tissue::Kind::Muscle});
  }
  Done act(const AddFiller& c) {
    return append(p_.tissues, {.name = c.name, .kind = Tissue::Kind::Filler});
  }
  Done act(const AddObstacle& c) {
    return append(p_.tissues, {.name = c.name, .kind = Tissue::Kind::Obstacle, .mesh = c.mesh});
  }
  Done act(const AddCavity& c) {
    return append(p_.tissues, {.name = c.name, .kind = Tissue::Kind::Cavity, .mesh = c.mesh});
  }
  Done act(const SetTissueMesh& c) {
    return editable(c.tissue).and_then([&](Tissue* t) -> Done {
      if (t->mesh) return set(t->mesh, std::optional(c.mesh));
      return fail(ErrorCode::UnknownName,
                  fmt::format("\"{}\" is a {}; only obstacles and cavities are meshes", t->name,
                              word(t->kind)),
                  {.object = t->name});
    });
  }
  Done act(const RemoveTissue& c) {
    if (const auto open = editable(c.tissue); !open) return passOn(open);
    return removeNamed(p_.tissues, c.tissue, Support::On::Tissue, "tissue");
  }
  Done act(const RenameTissue& c) {
    if (const auto open = editable(c.tissue); !open) return passOn(open);
    return renameNamed(p_.tissues, c.tissue, c.name, Support::On::Tissue, "tissue");
  }

  Done act(const SetColour& c) {
    return tissue(c.tissue).and_then([&](Tissue* t) { return set(t->colour, c.colour); });
  }
  Done act(const SetSide& c) {
    return tissueNotFat(c.tissue).and_then([&](Tissue* t) { return set(t->side, c.side); });
  }
  Done act(const SetGroup& c) {
    return tissueNotFat(c.tissue).and_then([&](Tissue* t) { return set(t->group, c.group); });
  }
  Done act(const SetLayer& c) {
    return tissueNotFat(c.tissue).and_then([&](Tissue* t) -> Done {
      t->layer.reset();
      if (c.layer) t->layer = static_cast<int>(std::clamp<std::int64_t>(*c.layer, -1, 100000));
      return {};
    });
  }
  Done act(const SetProtected& c) {
    return tissueNotFat(c.tissue).and_then([&](Tissue* t) { return set(t->isProtected, c.on); });
  }
  Done act(const SetKeepsTwin& c) {
    return curveTissue(c.tissue).and_then([&](Tissue* t) { return set(t->keepsTwin, c.on); });
  }
  Done act(const SetTissueCore& c) {
    return curveTissue(c.tissue).and_then([&](Tissue* t) { return set(t->coreRadius, c.radius); });
  }
  Done act(const SetAnisotropy& c) {
    return curveTissue(c.tissue).and_then(
        [&](Tissue* t) { return set(t->anisotropy, c.anisotropy); });
  }

  Done act(const AddCurve& c) {
    return curveTissue(c.tissue).and_then([&](Tissue* t) { return append(t->curves, c.curve); });
  }
  Done act(const RemoveCurve& c) {
    return curve(c.tissue, c.curve).and_then([&](Found f) -> Done {
      f.tissue->curves.erase(f.tissue->curves.begin() + static_cast<std::ptrdiff_t>(c.curve));
      return {};
    });
  }
  Done act(const RenameCurve& c) {
    return curve(c.tissue, c.curve).and_then([&](Found f) { return set(f.curve->name, c.name); });
  }
  Done act(const MoveCurve& c) {
    return curve(c.tissue, c.curve).and_then([&](Found f) -> Done {
      for (ControlPoint& p : f.curve->points) p.at += c.by;
      return {};
    });
  }
  Done act(const SetCurvePoints& c) {
    return curve(c.tissue, c.curve).and_then([&](Found f) {
      return set(f.curve->points, c.points);
    });
  }
  Done act(const SetCurveStart& c) {
    return curve(c.tissue, c.curve).and_then([&](Found f) {
      return set(f.curve->start, c.support);
    });
  }
  Done act(const SetCurveEnd& c) {
    return curve(c.tissue, c.curve).and_then([&](Found f) { return set(f.curve->end, c.support); });
  }

  Done act(const MovePoint& c) {
    return point(c.tissue, c.curve, c.point).and_then([&](ControlPoint* p) {
      return set(p->at, c.at);
    });
  }
  Done act(const InsertPoint& c) {
    return curve(c.tissue, c.curve).and_then([&](Found f) -> Done {
      auto& points = f.curve->points;
      if (c.point > points.size())
        return noSuch("control point", c.point, points.size() + 1, *f.tissue, c.curve);
      points.insert(points.begin() + static_cast<std::ptrdiff_t>(c.point), c.value);
      return {};
    });
  }
  Done act(const RemovePoint& c) {
    return point(c.tissue, c.curve, c.point).and_then([&](ControlPoint*) -> Done {
      auto& points = curve(c.tissue, c.curve)->curve->points;
      points.erase(points.begin() + static_cast<std::ptrdiff_t>(c.point));
      return {};
    });
  }
  Done act(const SetPointValue& c) {
    return point(c.tissue, c.curve, c.point).and_then([&](ControlPoint* p) {
      return set(p->tissue, c.value);
    });
  }

  Done act(const AddAttachment& c) {
    return curveTissue(c.tissue).and_then(
        [&](Tissue* t) { return append(t->attachments, c.attachment); });
  }
  Done act(const RemoveAttachment& c) {
    return curveTissue(c.tissue).and_then([&](Tissue* t) -> Done {
      if (c.attachment >= t->attachments.size()) {
        return fail(ErrorCode::ValueOutOfRange,
                    fmt::format("\"{}\" has {} attachments, not {}", t->name, t->attachments.size(),
                                c.attachment + 1),
                    {.object = t->name});
      }
      t->attachments.erase(t->attachments.begin() + static_cast<std::ptrdiff_t>(c.attachment));
      return {};
    });
  }

 private:
  struct Found {
    Tissue* tissue;
    Curve* curve;
  };

  template <class T>
  static Done set(T& slot, const T& value) {
    slot = value;
    return {};
  }
  template <class T>
  static Done append(std::vector<T>& list, const T& item) {
    list.push_back(item);
    return {};
  }

  static tl::unexpected<Error> unknown(const char* what, const std::string& name) {
    return fail(ErrorCode::UnknownName, fmt::format("the project has no {} \"{}\"", what, name),
                {.object = name});
  }
  static tl::unexpected<Error> noSuch(const char* what, std::size_t index, std::size_t count,
                                      const Tissue& tissue, std::size_t curve) {
    return fail(ErrorCode::ValueOutOfRange,
                fmt::format("there is no {} {} in {}; the last is {}", what, index + 1,
                            curveLabel(tissue, curve), count),
                {.object = tissue.name});
  }

  // Everything that names what something sits on: ends of curves and attachments
  template <class Change>
  void eachSupport(Support::On on, const std::string& name, const Change& change) {
    for (Tissue& t : p_.tissues) {
      for (Curve& c : t.curves) {
        for (Support* s : {&c.start, &c.end}) {
          if (s->on == on && s->name == name) change(*s);
        }
      }
      for (Attachment& a : t.attachments) {
        if (a.support.on == on && a.support.name == name) change(a.support);
      }
    }
  }

  template <class Named>
  Done removeNamed(std::vector<Named>& list, const std::string& name, Support::On on,
                   const char* what) {
    const auto found = std::ranges::find(list, name, &Named::name);
    if (found == list.end()) return unknown(what, name);
    list.erase(found);
    eachSupport(on, name, [](Support& s) { s = {}; });
    return {};
  }
  template <class Named>
  Done renameNamed(std::vector<Named>& list, const std::string& from, const std::string& to,
                   Support::On on, const char* what) {
    const auto found = std::ranges::find(list, from, &Named::name);
    if (found == list.end()) return unknown(what, from);
    found->name = to;
    eachSupport(on, from, [&](Support& s) { s.name = to; });
    return {};
  }

  Result<Tissue*> tissue(const std::string& name) {
    const auto index = findTissue(p_, name);
    if (!index) return unknown("tissue", name);
    return &p_.tissues[*index];
  }
  Result<Tissue*> tissueNotFat(const std::string& name) {
    auto found = tissue(name);
    if (found && (*found)->kind == Tissue::Kind::Fat) {
      return fail(ErrorCode::WrongType, "fat has a colour and nothing else", {.object = name});
    }
    return found;
  }
  Result<Tissue*> editable(const std::string& name) {
    auto found = tissue(name);
    if (found && (*found)->isProtected) {
      return fail(ErrorCode::TissueProtected,
                  fmt::format("\"{}\" is protected; lift that first: {}", name,
                              formatCommand(SetProtected{name, false})),
                  {.object = name});
    }
    return found;
  }
  Result<Tissue*> curveTissue(const std::string& name) {
    auto found = editable(name);
    if (found && !(*found)->hasCurves()) {
      return fail(ErrorCode::WrongType,
                  fmt::format("\"{}\" is {}, only muscles and fillers have curves", name,
                              (*found)->kind == Tissue::Kind::Fat ? "fat" : "a mesh"),
                  {.object = name});
    }
    return found;
  }
  Result<Found> curve(const std::string& name, std::size_t index) {
    auto found = curveTissue(name);
    if (!found) return passOn(found);
    auto& curves = (*found)->curves;
    if (index >= curves.size()) {
      return fail(
          ErrorCode::ValueOutOfRange,
          fmt::format("there is no curve {} in \"{}\"; it has {}", index + 1, name, curves.size()),
          {.object = name});
    }
    return Found{*found, &curves[index]};
  }
  Result<ControlPoint*> point(const std::string& name, std::size_t curveIndex, std::size_t index) {
    auto found = curve(name, curveIndex);
    if (!found) return passOn(found);
    auto& points = found->curve->points;
    if (index >= points.size())
      return noSuch("control point", index, points.size(), *found->tissue, curveIndex);
    return &points[index];
  }

  Project& p_;
};

}  // namespace

Result<Project> apply(const Project& before, const Command& command) {
  Project after = before;
  Editor editor(after);
  const Done done = std::visit([&](const auto& c) { return editor.act(c); }, command.act);
  if (!done) return passOn(done);
  if (auto fault = findFault(after, Completeness::Editing)) {
    return fail(fault->code, std::move(fault->message), {.object = std::move(fault->object)});
  }
  return after;
}

}  // namespace ecorche::model
