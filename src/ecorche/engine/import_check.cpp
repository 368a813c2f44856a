#include <ecorche/core/parallel.h>
#include <ecorche/domain/prepare_meshes.h>
#include <ecorche/engine/import_check.h>
#include <ecorche/mesh/surface_check.h>
#include <ecorche/mesh/surface_contact.h>
#include <ecorche/mesh/unit_check.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>
#include <string_view>

namespace ecorche::engine {

namespace {

constexpr double kMovedRel = 0.0005;  // how far build lets a repair move a surface

/// What `build` does about a finding by itself.
struct Remedy {
  std::string_view kind;
  std::string_view text;
};
constexpr std::array<Remedy, 17> kRemedies{{
    {"unused-vertices", "build leaves them out"},
    {"duplicate-vertices", "build merges them"},
    {"degenerate-faces", "build takes them out"},
    {"duplicate-faces", "build keeps one of each"},
    {"non-manifold-edges", "build splits them"},
    {"non-manifold-vertices", "build splits them"},
    {"inconsistent-orientation", "build makes neighbours agree"},
    {"inward", "build turns it outward, or takes it for the wall of a hollow in another piece"},
    {"components", "none needed"},
    {"lone-face", "build wraps the mesh with it; delete it where the mesh was made"},
    {"t-junctions", "build closes the seam"},
    {"non-manifold", "build takes the pieces apart there"},
    {"crack", "build closes it"},
    {"speck", "build drops them"},
    {"inner-wall", "build drops it"},
    {"inner-shell", "build keeps what is outermost"},
    {"cavity", "build fills it where it touches no skin"},
}};

std::string remedyOf(const Finding& finding, MeshRole role, bool closes) {
  if (finding.kind == "non-finite-vertex")
    return "build refuses the mesh; export it again from where it was made";
  if (finding.kind == "hole") {
    if (finding.severity == Severity::Repaired) return "build fills it";
    if (role == MeshRole::Unknown) {
      return closes ? "as a bone, build fills it; as a skin, if it is large, ask for \"repair\": "
                      "\"fill-holes\" (a flat cap) or \"wrap\""
                    : "as a bone, build wraps it; as a skin, ask for \"repair\": \"fill-holes\" or "
                      "\"wrap\"";
    }
    if (closes) return "build fills it";
    if (role == MeshRole::Skin) {
      return "build refuses the skin: close it, or ask for \"repair\": \"fill-holes\" or \"wrap\"";
    }
    return "build wraps the mesh; \"repair\": \"fill-holes\" keeps its shape and caps the hole";
  }
  if (finding.kind == "sheet") {
    if (role == MeshRole::Skin) return "build leaves them out";
    const std::string wrapped = "build wraps the mesh with them; delete them where it was made";
    return role == MeshRole::Unknown ? "as a skin, build leaves them out; as a bone, " + wrapped
                                     : wrapped;
  }
  if (finding.kind == "lone-face" && role == MeshRole::Skin) {
    return "build refuses the skin: delete the triangle where the mesh was made, or ask for "
           "\"repair\": \"wrap\"";
  }
  if (finding.kind == "self-intersections") {
    return "build takes what it encloses where that is certain; else \"repair\": \"wrap\" or "
           "\"outer-hull\"";
  }
  const auto known = std::ranges::find(kRemedies, finding.kind, &Remedy::kind);
  return known != kRemedies.end() ? std::string(known->text) : "none needed";
}

bool has(const Findings& findings, const std::string& kind) {
  return std::ranges::find(findings, kind, &Finding::kind) != findings.end();
}

/// Pairs of bodies whose boxes meet, and what stands between them.
struct Pair {
  std::size_t a = 0;
  std::size_t b = 0;
  std::optional<mesh::SurfaceContact> contact;
};

std::string cm3(double volume) { return fmt::format("{:.3g} cm³", volume * 1e6); }
std::string mm(double length) { return fmt::format("{:.3g} mm", length * 1e3); }

Finding contactFinding(const mesh::SurfaceContact& contact, const std::string& a,
                       const std::string& b) {
  using Kind = mesh::SurfaceContact::Kind;
  Finding out{.severity = Severity::Note, .object = a, .point = contact.place};
  switch (contact.kind) {
    case Kind::Touch:
      out.kind = "touch";
      out.message = fmt::format("\"{}\" and \"{}\" come as near as {}", a, b, mm(contact.depth));
      out.size = contact.depth;
      out.remedy = "none needed; a gap too narrow for tets is closed by a wrap";
      break;
    case Kind::Overlap:
      out.kind = "overlap";
      out.message = fmt::format("\"{}\" and \"{}\" overlap by {} up to {} deep", a, b,
                                cm3(contact.volume), mm(contact.depth));
      out.size = contact.volume;
      out.remedy = "build unites them; each keeps its name";
      break;
    case Kind::Within:
      out.kind = "within";
      out.message =
          fmt::format("\"{}\" lies inside \"{}\" with all its {}", a, b, cm3(contact.volume));
      out.size = contact.volume;
      out.remedy = "build takes the outer one for both; remove the inner one if it is spongy bone";
      break;
  }
  return out;
}

class Between {
 public:
  Between(const ProjectMeshes& meshes, const std::vector<domain::CutPlane>& cutPlanes,
          double tolerance, RunContext& run)
      : meshes_(meshes), cutPlanes_(cutPlanes), tolerance_(tolerance), run_(run) {}

  Findings operator()() {
    for (const mesh::UnitMismatch& mismatch : mesh::unitMismatches(meshes_.skin, meshes_.bones)) {
      const auto& bone = meshes_.bones[mismatch.bone.value_or(0)];
      out_.push_back({.severity = mismatch.certain ? Severity::Error : Severity::Warning,
                      .kind = "units",
                      .object = bone.name,
                      .message = mismatch.message,
                      .point = mesh::boundingBox(bone).centre(),
                      .size = mismatch.factor,
                      .remedy = mismatch.certain ? "build refuses it: set \"unit\" at the mesh"
                                                 : "build takes it as it is: set \"unit\" if it is "
                                                   "wrong"});
    }
    const mesh::ContactBody skin(meshes_.skin);
    std::vector<mesh::ContactBody> bodies;
    for (const auto* list : {&meshes_.bones, &meshes_.obstacles, &meshes_.cavities}) {
      for (const auto& m : *list) bodies.emplace_back(m);
    }
    againstSkin(skin, bodies);
    amongOneAnother(bodies, tolerance_ * skin.box.diagonal());
    return std::move(out_);
  }

 private:
  void againstSkin(const mesh::ContactBody& skin, const std::vector<mesh::ContactBody>& bodies) {
    const auto isKept = [&](const mesh::Vector3& p) {
      return std::ranges::all_of(cutPlanes_, [&](const domain::CutPlane& plane) {
        return plane.normal.dot(p - plane.point) > 0.0;
      });
    };
    std::vector<std::optional<mesh::PokingOut>> out(bodies.size());
    parallelFor(
        std::ssize(bodies),
        [&](std::int64_t i) {
          const auto k = static_cast<std::size_t>(i);
          if (!run_.cancelled()) out[k] = mesh::pokingOut(bodies[k], skin, isKept);
        },
        1);
    for (std::size_t k = 0; k < bodies.size(); ++k) {
      if (!out[k]) continue;
      const std::string& who = bodies[k].mesh.name;
      const double whole = std::abs(mesh::signedVolume(bodies[k].mesh.V, bodies[k].mesh.F));
      const bool outside = out[k]->volume > 0.98 * whole;
      out_.push_back(
          {.severity = outside ? Severity::Warning : Severity::Note,
           .kind = outside ? "outside-skin" : "pokes-out",
           .object = who,
           .message =
               outside ? fmt::format("\"{}\" lies outside the skin", who)
                       : fmt::format("\"{}\" reaches up to {} out of the skin, with {} of its {}",
                                     who, mm(out[k]->depth), cm3(out[k]->volume), cm3(whole)),
           .point = out[k]->place,
           .size = outside ? whole : out[k]->volume,
           .remedy = outside ? "build leaves it out" : "build cuts it off there"});
    }
  }

  void amongOneAnother(const std::vector<mesh::ContactBody>& bodies, double near) {
    std::vector<Pair> pairs;
    for (std::size_t a = 0; a < bodies.size(); ++a) {
      for (std::size_t b = a + 1; b < bodies.size(); ++b) {
        const bool apart = ((bodies[a].box.lo - bodies[b].box.hi).array() > near).any() ||
                           ((bodies[b].box.lo - bodies[a].box.hi).array() > near).any();
        if (!apart) pairs.push_back({a, b, {}});
      }
    }
    parallelFor(
        std::ssize(pairs),
        [&](std::int64_t i) {
          Pair& pair = pairs[static_cast<std::size_t>(i)];
          if (run_.cancelled()) return;
          // The smaller one first: it may lie within the larger
          if (bodies[pair.a].box.diagonal() > bodies[pair.b].box.diagonal())
            std::swap(pair.a, pair.b);
          pair.contact = mesh::contactOf(bodies[pair.a], bodies[pair.b], near);
        },
        1);
    for (const Pair& pair : pairs) {
      if (pair.contact)
        out_.push_back(
            contactFinding(*pair.contact, bodies[pair.a].mesh.name, bodies[pair.b].mesh.name));
    }
  }

  const ProjectMeshes& meshes_;
  const std::vector<domain::CutPlane>& cutPlanes_;
  double tolerance_;
  RunContext& run_;
  Findings out_;
};

}  // namespace

const char* name(MeshRole role) {
  switch (role) {
    case MeshRole::Skin:
      return "skin";
    case MeshRole::Bone:
      return "bone";
    case MeshRole::Obstacle:
      return "obstacle";
    case MeshRole::Cavity:
      return "cavity";
    case MeshRole::Unknown:
      return "mesh";
  }
  return "mesh";
}

std::int64_t ImportCheck::count(Severity severity) const {
  std::int64_t out = std::ranges::count(between, severity, &Finding::severity);
  for (const MeshLook& look : meshes)
    out += std::ranges::count(look.findings, severity, &Finding::severity);
  return out;
}

Result<MeshLook> lookAtMesh(const mesh::SurfaceMesh& mesh, MeshRole role, RunContext& run) {
  MeshLook out{.name = mesh.name, .role = role, .vertices = mesh.V.rows(), .faces = mesh.F.rows()};
  mesh::SurfaceCheck check = mesh::checkSurface(mesh, {.selfIntersections = true});
  out.pieces = std::ssize(check.components);
  out.closed = !check.components.empty() &&
               std::ranges::all_of(check.components, [](const auto& c) { return c.closed; });
  const bool finite = check.nonFiniteVertices == 0;
  out.size = finite ? mesh::boundingBox(mesh).diagonal() : 0.0;
  out.volume = finite ? mesh::signedVolume(mesh.V, mesh.F) : 0.0;
  out.findings = std::move(check.findings);

  // What is only seen while repairing, and what repairing cannot do
  auto prepared = domain::prepareMesh(mesh, role == MeshRole::Skin, kMovedRel * out.size, run);
  if (!prepared && prepared.error().code == ErrorCode::Cancelled) return passOn(prepared);
  bool closes = false;
  if (prepared) {
    closes = mesh::checkSurface(prepared->surface.mesh).holes.empty();
    for (const Finding& finding : prepared->surface.findings) {
      if (!has(out.findings, finding.kind)) out.findings.push_back(finding);
    }
  } else if (!has(out.findings, "hole") && !has(out.findings, "lone-face") &&
             !has(out.findings, "non-finite-vertex")) {
    out.findings.push_back({.severity = Severity::Error,
                            .kind = "refused",
                            .object = mesh.name,
                            .message = prepared.error().message,
                            .point = prepared.error().place.point,
                            .remedy = "build refuses the mesh"});
  }
  for (Finding& finding : out.findings) {
    if (finding.remedy.empty()) finding.remedy = remedyOf(finding, role, closes);
    if (finding.severity == Severity::Repaired) finding.severity = Severity::Warning;
    const bool open = finding.kind == "hole" || finding.kind == "lone-face";
    if (open && role == MeshRole::Skin && !closes) finding.severity = Severity::Error;
  }
  return out;
}

Result<ImportCheck> checkImport(const ProjectMeshes& meshes,
                                const std::vector<domain::CutPlane>& cutPlanes, double tolerance,
                                RunContext& run) {
  const Stage stage(run, "check meshes");
  struct Task {
    const mesh::SurfaceMesh* mesh;
    MeshRole role;
  };
  std::vector<Task> tasks{{&meshes.skin, MeshRole::Skin}};
  for (const auto& m : meshes.bones) tasks.push_back({&m, MeshRole::Bone});
  for (const auto& m : meshes.obstacles) tasks.push_back({&m, MeshRole::Obstacle});
  for (const auto& m : meshes.cavities) tasks.push_back({&m, MeshRole::Cavity});
  std::vector<Result<MeshLook>> looks(tasks.size());
  parallelFor(
      std::ssize(tasks),
      [&](std::int64_t i) {
        const Task& task = tasks[static_cast<std::size_t>(i)];
        looks[static_cast<std::size_t>(i)] = lookAtMesh(*task.mesh, task.role, run);
      },
      1);
  ImportCheck out;
  bool finite = true;
  for (auto& look : looks) {
    if (!look) return passOn(look);
    finite = finite && !has(look->findings, "non-finite-vertex");
    out.meshes.push_back(std::move(*look));
  }
  // Distances to what is no number are none
  if (finite) out.between = Between(meshes, cutPlanes, tolerance, run)();
  if (run.cancelled()) return fail(ErrorCode::Cancelled, "checking meshes was interrupted");
  return out;
}

}  // namespace ecorche::engine
