#include <ecorche/model/project_check.h>

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <unordered_map>

namespace ecorche::model {

namespace {

using Fault = std::optional<ProjectFault>;

// Walks the project in file order and keeps the first fault.
class Checker {
 public:
  Checker(const Project& project, Completeness completeness)
      : project_(project), complete_(completeness == Completeness::Complete) {}

  Fault run() {
    checkText(project_.name, "/name", "the project's name");
    checkMesh(project_.skin, "/skin", "the skin");
    checkBones();
    checkCutPlanes();
    checkSettings();
    checkTissues();
    return std::move(fault_);
  }

 private:
  void give(ErrorCode code, std::string pointer, std::string message) {
    if (!fault_) fault_ = ProjectFault{code, std::move(message), std::move(pointer), object_};
  }

  // Names become file names, lines of scripts and JSON: no control characters, valid UTF-8
  void checkText(const std::string& text, const std::string& pointer, const std::string& what) {
    for (char c : text) {
      if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F) {
        return give(ErrorCode::ValueOutOfRange, pointer,
                    what + " holds a control character; use plain text");
      }
    }
    try {
      (void)nlohmann::json(text).dump();
    } catch (const nlohmann::json::type_error&) {
      give(ErrorCode::ValueOutOfRange, pointer, what + " is not UTF-8; use plain text");
    }
  }

  template <class List>
  void checkNames(const List& list, const std::string& pointer, const char* what) {
    std::unordered_map<std::string, std::size_t> first;
    for (std::size_t k = 0; k < list.size(); ++k) {
      const std::string here = fmt::format("{}/{}/name", pointer, k);
      const std::string& name = list[k].name;
      if (name.empty())
        give(ErrorCode::MissingKey, here,
             fmt::format("{} {} has no name; give it one", what, k + 1));
      checkText(name, here, fmt::format("the name of {} {}", what, k + 1));
      if (const auto [known, fresh] = first.emplace(name, k); !fresh) {
        give(ErrorCode::DuplicateName, here,
             fmt::format("two {}s are called \"{}\" (numbers {} and {}); rename one", what, name,
                         known->second + 1, k + 1));
      }
    }
  }

  void checkMesh(const MeshRef& mesh, const std::string& pointer, const std::string& what) {
    if (mesh.file.empty()) {
      return give(ErrorCode::MissingKey, pointer + "/file",
                  what + " names no mesh file; add \"file\"");
    }
    checkText(mesh.file, pointer + "/file", "the file name of " + what);
    checkText(mesh.part, pointer + "/part", "the part of " + what);
  }

  void checkRange(double value, double low, double high, const std::string& pointer,
                  const std::string& what, bool lowAllowed = false) {
    if (value > low && value <= high) return;
    if (lowAllowed && value == low) return;
    give(ErrorCode::ValueOutOfRange, pointer,
         fmt::format("{} is {}; it must be {} {} and at most {}", what, value,
                     lowAllowed ? "at least" : "more than", low, high));
  }

  void checkPoint(const Vector3& p, const std::string& pointer, const std::string& what) {
    if (p.allFinite() && p.cwiseAbs().maxCoeff() <= kLargestCoordinate) return;
    give(ErrorCode::ValueOutOfRange, pointer,
         fmt::format("{} lies at {}, {}, {} m, farther out than {} m; check the unit", what, p.x(),
                     p.y(), p.z(), kLargestCoordinate));
  }

  void checkBones() {
    checkNames(project_.bones, "/bones", "bone");
    for (std::size_t k = 0; k < project_.bones.size(); ++k) {
      object_ = project_.bones[k].name;
      checkMesh(project_.bones[k].mesh, fmt::format("/bones/{}", k),
                fmt::format("bone \"{}\"", object_));
    }
    object_.clear();
  }

  void checkCutPlanes() {
    checkNames(project_.cutPlanes, "/cut_planes", "cut plane");
    for (std::size_t k = 0; k < project_.cutPlanes.size(); ++k) {
      const CutPlane& plane = project_.cutPlanes[k];
      object_ = plane.name;
      const std::string here = fmt::format("/cut_planes/{}", k);
      checkPoint(plane.point, here + "/point",
                 fmt::format("the point of cut plane \"{}\"", plane.name));
      if (!(std::abs(plane.normal.norm() - 1.0) < 1e-9)) {
        give(ErrorCode::ValueOutOfRange, here + "/normal",
             fmt::format("the normal of cut plane \"{}\" has no direction", plane.name));
      }
    }
    object_.clear();
  }

  void checkSettings() {
    const Settings& s = project_.settings;
    const std::string here = "/settings";
    checkRange(s.fat, 0.0, 1e6, here + "/fat", "fat", true);
    if (s.coreRadius) checkRange(*s.coreRadius, 0.0, 1e3, here + "/core_radius", "core_radius");
    if (s.alpha) checkRange(*s.alpha, 0.0, 1e9, here + "/alpha", "alpha");
    if (s.coreRadius && s.alpha) {
      give(ErrorCode::ValueOutOfRange, here + "/alpha",
           "core_radius and alpha exclude each other; keep one");
    }
    if (s.tets) checkRange(static_cast<double>(*s.tets), 100, 1e8, here + "/tets", "tets", true);
    if (s.edgeLength) checkRange(*s.edgeLength, 0.0, 1e4, here + "/edge_length", "edge_length");
    if (s.tets && s.edgeLength) {
      give(ErrorCode::ValueOutOfRange, here + "/edge_length",
           "tets and edge_length exclude each other; keep one");
    }
    checkRange(s.surfaceTolerance, 0.0, 0.1, here + "/surface_tolerance", "surface_tolerance");
  }

  void checkTissues() {
    checkNames(project_.tissues, "/tissues", "tissue");
    bool fatSeen = false;
    for (std::size_t k = 0; k < project_.tissues.size() && !fault_; ++k) {
      const Tissue& tissue = project_.tissues[k];
      object_ = tissue.name;
      const std::string here = fmt::format("/tissues/{}", k);
      checkText(tissue.group, here + "/group", "the group");
      if (tissue.layer && (*tissue.layer < 0 || *tissue.layer > 1000)) {
        give(ErrorCode::ValueOutOfRange, here + "/layer",
             fmt::format("the layer of \"{}\" is {}; 0 is deepest, 1000 the most", tissue.name,
                         *tissue.layer));
      }
      const bool isFat = tissue.kind == Tissue::Kind::Fat;
      if (isFat && fatSeen)
        give(ErrorCode::DuplicateName, here, "the fat has two entries; keep one");
      fatSeen = fatSeen || isFat;
      if (!isFat && tissue.name == "fat") {
        give(ErrorCode::DuplicateName, here + "/name",
             "the name \"fat\" belongs to the fat; rename this tissue");
      }
      if (tissue.hasCurves()) {
        checkCurveTissue(tissue, here);
      } else if (!isFat) {
        checkMesh(tissue.mesh.value_or(MeshRef{}), here,
                  fmt::format("{} \"{}\"", word(tissue.kind), tissue.name));
      }
    }
  }

  void checkCurveTissue(const Tissue& tissue, const std::string& here) {
    const std::string label = fmt::format("{} \"{}\"", word(tissue.kind), tissue.name);
    if (tissue.coreRadius) {
      checkRange(*tissue.coreRadius, 0.0, 1e3, here + "/core_radius", "core_radius of " + label);
    }
    const std::string frame = here + "/anisotropy";
    checkRange(tissue.anisotropy.lambda2, 0.0, 1e6, frame + "/lambda2", "lambda2 of " + label);
    checkRange(tissue.anisotropy.lambda3, 0.0, 1e6, frame + "/lambda3", "lambda3 of " + label);
    checkRange(tissue.anisotropy.rotation, -100.0, 100.0, frame + "/rotation",
               "rotation [rad] of " + label);

    if (complete_ && tissue.curves.empty()) {
      give(ErrorCode::MuscleWithoutCurve, here,
           fmt::format("{} has no curve; draw one or delete the {}", label, word(tissue.kind)));
    }
    std::unordered_map<std::string, std::size_t> names;
    for (std::size_t c = 0; c < tissue.curves.size(); ++c) {
      const std::string spot = fmt::format("{}/curves/{}", here, c);
      const std::string& name = tissue.curves[c].name;
      checkText(name, spot + "/name", "the name of a curve of " + label);
      if (!name.empty() && !names.emplace(name, c).second) {
        give(ErrorCode::DuplicateName, spot + "/name",
             fmt::format("{} has two curves called \"{}\"; rename one", label, name));
      }
      checkCurve(tissue, c, spot);
    }
    for (std::size_t a = 0; a < tissue.attachments.size(); ++a) {
      const Attachment& attachment = tissue.attachments[a];
      const std::string spot = fmt::format("{}/attachments/{}", here, a);
      const std::string what = fmt::format("attachment {} of {}", a + 1, label);
      checkSupport(attachment.support, tissue, spot, what);
      if (attachment.at) checkPoint(*attachment.at, spot + "/at", what);
      if (attachment.patch) checkMesh(*attachment.patch, spot + "/patch", what);
      if (!attachment.at && !attachment.patch) {
        give(ErrorCode::MissingKey, spot, what + " has no place; give \"at\" or \"patch\"");
      }
    }
  }

  void checkCurve(const Tissue& tissue, std::size_t c, const std::string& here) {
    const Curve& curve = tissue.curves[c];
    const std::string label = curveLabel(tissue, c);
    if (curve.points.size() < 2) {
      return give(ErrorCode::ZeroLengthCurve, here,
                  fmt::format("{} has {}; it needs two control points at different places", label,
                              curve.points.empty() ? "no control point" : "one control point"));
    }
    for (std::size_t p = 0; p < curve.points.size(); ++p) {
      const std::string spot = fmt::format("{}/points/{}", here, p);
      const std::string what = fmt::format("control point {} of {}", p + 1, label);
      checkPoint(curve.points[p].at, spot + "/at", what);
      checkRange(curve.points[p].tissue, 0.0, 1e6, spot + "/tissue", "the tissue value of " + what);
    }
    if (fault_) return;
    double longest = 0.0;
    std::size_t stuck = 0;
    for (std::size_t p = 1; p < curve.points.size(); ++p) {
      const double step = (curve.points[p].at - curve.points[p - 1].at).norm();
      longest = std::max(longest, step);
      if (step < kSmallestStep && stuck == 0) stuck = p;
    }
    if (longest < kSmallestStep) {
      give(ErrorCode::ZeroLengthCurve, here,
           fmt::format("{} has no length; move its ends apart or delete it", label));
    } else if (stuck > 0) {
      give(ErrorCode::ZeroLengthCurve, fmt::format("{}/points/{}", here, stuck),
           fmt::format("control points {} and {} of {} lie on the same spot; delete one", stuck,
                       stuck + 1, label));
    }
    checkSupport(curve.start, tissue, here + "/start", "the start of " + label);
    checkSupport(curve.end, tissue, here + "/end", "the end of " + label);
  }

  void checkSupport(const Support& support, const Tissue& owner, const std::string& here,
                    const std::string& what) {
    const std::string spot = here + "/name";
    if (support.on == Support::On::Free) {
      if (!support.name.empty()) {
        give(ErrorCode::UnknownName, spot,
             fmt::format("{} is free, yet names \"{}\"; say what that is", what, support.name));
      }
      return;
    }
    if (support.name.empty()) {
      return give(ErrorCode::MissingKey, here,
                  fmt::format("{} is on a {} without a name", what, word(support.on)));
    }
    bool known = false;
    if (support.on == Support::On::Bone) known = findBone(project_, support.name).has_value();
    if (support.on == Support::On::Plane) known = findCutPlane(project_, support.name).has_value();
    if (support.on == Support::On::Tissue) {
      const auto found = findTissue(project_, support.name);
      known = found && project_.tissues[*found].kind != Tissue::Kind::Fat;
      if (support.name == owner.name) {
        return give(ErrorCode::UnknownName, spot,
                    fmt::format("{} is on its own tissue; name another", what));
      }
    }
    if (!known) {
      give(ErrorCode::UnknownName, spot,
           fmt::format("{} is on {} \"{}\", which the project does not have", what,
                       word(support.on), support.name));
    }
  }

  const Project& project_;
  bool complete_;
  std::string object_;
  Fault fault_;
};

}  // namespace

std::optional<ProjectFault> findFault(const Project& project, Completeness completeness) {
  return Checker(project, completeness).run();
}

Result<void> checkProject(const Project& project) {
  const auto fault = findFault(project);
  if (!fault) return {};
  return fail(fault->code, fault->message, {.object = fault->object});
}

}  // namespace ecorche::model
