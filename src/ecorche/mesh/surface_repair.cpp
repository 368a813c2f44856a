#include <ecorche/mesh/face_repair.h>
#include <ecorche/mesh/hole_fill.h>
#include <ecorche/mesh/inner_walls.h>
#include <ecorche/mesh/open_sheets.h>
#include <ecorche/mesh/surface_check.h>
#include <ecorche/mesh/surface_repair.h>
#include <ecorche/mesh/surface_topology.h>
#include <ecorche/mesh/t_junctions.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>

namespace ecorche::mesh {

namespace {

LabelledFaces labelled(const SurfaceMesh& mesh) {
  LabelledFaces faces{
      .V = mesh.V,
      .F = mesh.F,
      .label = std::vector<std::int32_t>(static_cast<std::size_t>(mesh.F.rows()), 0)};
  for (std::size_t p = 0; p < mesh.parts.size(); ++p) {
    std::fill_n(faces.label.begin() + mesh.parts[p].firstFace, mesh.parts[p].faceCount,
                static_cast<std::int32_t>(p));
  }
  return faces;
}

// Faces of a part together again, in their order; parts that lost all their faces are gone.
SurfaceMesh assembled(const LabelledFaces& faces, const SurfaceMesh& original) {
  SurfaceMesh mesh;
  mesh.name = original.name;
  mesh.V = faces.V;
  std::vector<std::int32_t> order(faces.label.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::stable_sort(
      order, {}, [&](std::int32_t f) { return faces.label[static_cast<std::size_t>(f)]; });
  mesh.F.resize(faces.F.rows(), 3);
  for (std::size_t i = 0; i < order.size(); ++i) {
    const auto f = static_cast<Eigen::Index>(i);
    mesh.F.row(f) = faces.F.row(order[i]);
    if (original.parts.empty()) continue;
    const std::string& name =
        original.parts[static_cast<std::size_t>(faces.label[static_cast<std::size_t>(order[i])])]
            .name;
    const bool begins = i == 0 || faces.label[static_cast<std::size_t>(order[i])] !=
                                      faces.label[static_cast<std::size_t>(order[i - 1])];
    if (begins) mesh.parts.push_back({name, static_cast<std::int32_t>(i), 0});
    ++mesh.parts.back().faceCount;
  }
  return compacted(mesh);
}

/// How far the widest border is at most from all others, where that is little: it is no hole then,
/// but one side of a crack.
std::optional<double> crackWidth(const SurfaceMesh& mesh) {
  constexpr double kLittle = 0.02;              // of the border's extent
  constexpr std::size_t kMostPairs = 20000000;  // of vertices and edges: a fraction of a second
  const SurfaceEdges edges = surfaceEdges(mesh.F);
  const std::vector<Border> all = borders(edges);
  const auto end = [&](std::int32_t e, std::size_t k) -> Vector3 {
    return mesh.V.row(edges.ends[static_cast<std::size_t>(e)][k]).transpose();
  };
  const auto extent = [&](const Border& border) {
    Box box;
    for (const std::int32_t e : border.edges) {
      box.add(end(e, 0));
      box.add(end(e, 1));
    }
    return box.diagonal();
  };
  const auto widest = std::ranges::max_element(all, {}, extent);
  std::vector<std::int32_t> others;
  for (auto border = all.begin(); border != all.end(); ++border) {
    if (border != widest) others.insert(others.end(), border->edges.begin(), border->edges.end());
  }
  if (others.empty() || widest->edges.size() * others.size() > kMostPairs) return std::nullopt;
  double width = 0.0;
  for (const std::int32_t e : widest->edges) {
    const Vector3 p = end(e, 0);
    double nearest = std::numeric_limits<double>::infinity();
    for (const std::int32_t other : others) {
      const Vector3 a = end(other, 0);
      const Vector3 along = end(other, 1) - a;
      const double length = along.squaredNorm();
      const double t = length > 0.0 ? std::clamp((p - a).dot(along) / length, 0.0, 1.0) : 0.0;
      nearest = std::min(nearest, (a + t * along - p).norm());
    }
    width = std::max(width, nearest);
  }
  if (width > kLittle * extent(*widest)) return std::nullopt;
  return width;
}

class Repair {
 public:
  Repair(const SurfaceMesh& mesh, const RepairOptions& options, RunContext& run)
      : mesh_(mesh), options_(options), run_(run) {}

  Result<RepairedSurface> go() {
    const Stage stage(run_, "repairing");
    const SurfaceCheck before = checkSurface(mesh_);
    if (before.nonFiniteVertices > 0) {
      return fail(ErrorCode::NonFiniteVertex,
                  fmt::format("\"{}\": {}; remove or place it where the mesh was made", mesh_.name,
                              before.findings.front().message),
                  {.object = mesh_.name});
    }
    if (mesh_.empty()) return nothingLeft();
    crowdedEdges_ = before.nonManifoldEdges;
    if (before.unusedVertices > 0) {
      note(Severity::Note, "unused-vertices",
           fmt::format("{} vertices belonged to no face", before.unusedVertices), std::nullopt,
           double(before.unusedVertices));
    }
    const double diagonal = boundingBox(mesh_).diagonal();
    speckExtent_ = options_.speckRel * diagonal;
    const double crumb = kCrumbShare * std::abs(signedVolume(mesh_.V, mesh_.F));
    if (before.isSound() && std::ranges::none_of(before.components, [&](const auto& c) {
          return c.inward || c.box.diagonal() < speckExtent_ ||
                 (options_.mustClose && std::abs(c.volume) < crumb);
        })) {
      return RepairedSurface{.mesh = compacted(mesh_), .findings = std::move(findings_)};
    }
    faces_ = labelled(mesh_);
    if (!before.isSound()) {
      if (auto ok = mend(diagonal, before); !ok) return passOn(ok);
    }
    report("speck", dropSpecks(faces_, speckExtent_),
           "dropped {} small pieces, up to {:.3g} m across");
    if (faces_.F.rows() == 0) return nothingLeft();
    if (run_.cancelled()) return fail(ErrorCode::Cancelled, "repair was interrupted");
    report("inward", orientOutward(faces_), "turned {} pieces outward, up to {:.3g} m³");
    if (options_.mustClose) {
      report("speck", dropCrumbs(faces_),
             "left out {} small pieces that touch nothing, up to {:.3g} m across");
    }

    RepairedSurface out{.mesh = assembled(faces_, mesh_), .findings = {}};
    if (auto ok = look(out.mesh); !ok) return passOn(ok);
    out.findings = std::move(findings_);
    return out;
  }

 private:
  // The order matters: each step may rely on what those before it made true.
  Result<void> mend(double diagonal, const SurfaceCheck& before) {
    report("duplicate-vertices", weldEqual(faces_),
           "merged {} vertices with others at the same place");
    report("crack", weldBorders(faces_, options_.weldRel * diagonal),
           "merged {} vertices along cracks, up to {:.3g} m wide");
    if (before.borderEdges > 0) splitSeams(diagonal);
    report("degenerate-faces", dropCollapsed(faces_), "dropped {} faces without area");
    report("duplicate-faces", dropDoubled(faces_),
           "dropped {} faces that lay upon others or between touching pieces");
    report("inner-wall", dropInnerWalls(faces_, options_.holeRel),
           "dropped {} walls inside, up to {:.3g} m across");
    // Before anything is split or filled, so that a stray face is not taken for a surface
    report("speck", dropSpecks(faces_, speckExtent_),
           "dropped {} small pieces, up to {:.3g} m across");
    if (run_.cancelled()) return fail(ErrorCode::Cancelled, "repair was interrupted");
    if (faces_.F.rows() == 0) return {};
    if ((options_.mustClose || options_.leaveOutSheets) && before.borderEdges > 0) dropSheets();
    // Faces that shared no vertices before they were welded could not disagree
    const std::int64_t turned = checkSurface({.V = faces_.V, .F = faces_.F}).inconsistentEdges;
    auto done = makeManifold(faces_, options_.holeRel, run_);
    if (!done) {
      Error error = done.error();
      error.place.object = mesh_.name;
      return tl::unexpected(std::move(error));
    }
    if (turned > 0) {
      note(Severity::Repaired, "inconsistent-orientation",
           fmt::format("turned faces that looked to opposite sides across {} edges", turned),
           std::nullopt, double(turned));
    }
    report("non-manifold", done->split, "split {} vertices where too many faces hung together");
    report("degenerate-faces", done->flat, "took out {} faces without area");
    report("hole", done->filled, "filled {} holes, up to {:.3g} m across");
    return {};
  }

  // Before holes are filled, which would make two-sided sheets of them
  void dropSheets() {
    const FaceComponents pieces = components(faces_.F);
    const std::vector<char> sheet = openSheets(faces_.V, faces_.F, surfaceEdges(faces_.F), pieces);
    std::vector<Box> boxes(sheet.size());
    std::vector<char> stays(faces_.label.size(), 1);
    std::vector<char> partGoes(mesh_.parts.size(), 0);
    for (std::size_t f = 0; f < stays.size(); ++f) {
      const auto piece = static_cast<std::size_t>(pieces.label[f]);
      if (sheet[piece] == 0) continue;
      stays[f] = 0;
      if (!partGoes.empty()) partGoes[static_cast<std::size_t>(faces_.label[f])] = 1;
      for (const std::int32_t v : faces_.F.row(static_cast<Eigen::Index>(f)))
        boxes[piece].add(faces_.V.row(v).transpose());
    }
    StepReport left;
    for (const Box& box : boxes) {
      if (!box.empty()) left.see(box.centre(), box.diagonal());
    }
    if (left.count == 0) return;
    const std::string names = partsNamed(mesh_, partGoes);
    note(Severity::Repaired, "sheet",
         fmt::format("left out {} open sheets that enclose nothing, up to {:.3g} m across{}{}",
                     left.count, left.size, names.empty() ? "" : ": ", names),
         left.place, left.size);
    faces_.keep(stays);
  }

  // A face gets corners on one side at a time, and corners on one side may leave others to be found
  void splitSeams(double diagonal) {
    constexpr int kRounds = 4;
    StepReport all;
    for (int round = 0; round < kRounds; ++round) {
      const StepReport step = splitAtTJunctions(faces_, options_.weldRel * diagonal);
      if (step.count == 0) break;
      if (!all.place) all.place = step.place;
      all.count += step.count;
      all.size = std::max(all.size, step.size);
    }
    if (all.count == 0) return;
    all.size = 0.0;  // they lie where they lay; their number says more
    report("t-junctions", all, "gave {} vertices of one side of a seam to the other");
    weldBorders(faces_, options_.weldRel * diagonal);
  }

  // What no repair here can mend, and a skin must not have.
  Result<void> look(const SurfaceMesh& mesh) {
    const SurfaceCheck after = checkSurface(mesh);
    if (options_.mustClose && !after.holes.empty()) {
      const auto& hole = after.holes.front();
      return fail(ErrorCode::SkinNotClosed, whyNotClosed(mesh, after),
                  {.object = mesh.name, .point = hole.place});
    }
    for (const Finding& finding : after.findings) {
      const bool known = finding.kind == "components" || finding.kind == "duplicate-vertices";
      if (finding.kind == "inward") {
        note(Severity::Note, "cavity",
             "an inward piece within an outward one is taken for the wall of a cavity",
             finding.point, finding.size);
      } else if (!known) {
        findings_.push_back(finding);
      }
    }
    return {};
  }

  // What is wrong, and a way out that leads somewhere: what was not filled although every hole was
  // to be is not sent there again.
  [[nodiscard]] std::string whyNotClosed(const SurfaceMesh& mesh, const SurfaceCheck& after) const {
    const auto& hole = after.holes.front();
    const std::int64_t pieces = std::ssize(after.components);
    const std::string others =
        after.holes.size() > 1 ? fmt::format(", and {} more", after.holes.size() - 1) : "";
    if (pieces > faces_.F.rows() / 4 && pieces > 4) {
      return fmt::format(
          "the {} faces of \"{}\" hang together in {} pieces; merge its vertices by "
          "distance where the mesh was made, or ask for \"repair\": \"wrap\" (a skin "
          "laid around it)",
          faces_.F.rows(), mesh_.name, pieces);
    }
    const auto width = crackWidth(mesh);
    if (width && *width < options_.weldRel * boundingBox(mesh).diagonal() && crowdedEdges_ > 0) {
      return fmt::format(
          "\"{}\" has {} edges where more than two faces meet, as blocks have that touch along an "
          "edge; cut apart there it is open along {} edges, {:.3g} m across{}: clean it where it "
          "was made, or ask for \"repair\": \"wrap\" (a skin laid around it)",
          mesh_.name, crowdedEdges_, hole.edges, hole.extent, others);
    }
    if (width) {
      return fmt::format(
          "\"{}\" is cracked along a border of {} edges, {:.3g} m across: others run "
          "along it, up to {:.2g} mm apart{}; merge vertices by that distance where "
          "the mesh was made, or ask for \"repair\": \"wrap\" (a skin laid around it)",
          mesh_.name, hole.edges, hole.extent, *width * 1e3, others);
    }
    const bool filled = std::isinf(options_.holeRel);
    return fmt::format(
        "\"{}\" has a hole of {} edges, {:.3g} m across{}; {}close it where the mesh "
        "was made, or ask for {}\"wrap\" (a skin laid around it)",
        mesh_.name, hole.edges, hole.extent, others, filled ? "it cannot be filled: " : "",
        filled ? "\"repair\": " : "\"repair\": \"fill-holes\" (a flat cap) or ");
  }

  void note(Severity severity, const char* kind, std::string message, std::optional<Vector3> point,
            double size) {
    findings_.push_back({.severity = severity,
                         .kind = kind,
                         .object = mesh_.name,
                         .message = std::move(message),
                         .point = point,
                         .size = size});
  }
  void report(const char* kind, const StepReport& step, const char* sentence) {
    if (step.count == 0) return;
    note(Severity::Repaired, kind, fmt::format(fmt::runtime(sentence), step.count, step.size),
         step.place, step.size > 0.0 ? step.size : double(step.count));
  }
  [[nodiscard]] tl::unexpected<Error> nothingLeft() const {
    return fail(ErrorCode::MeshWithoutFaces,
                fmt::format("\"{}\" has no faces with an area", mesh_.name),
                {.object = mesh_.name});
  }

  const SurfaceMesh& mesh_;
  const RepairOptions& options_;
  RunContext& run_;
  LabelledFaces faces_;
  double speckExtent_ = 0.0;       // [m]
  std::int64_t crowdedEdges_ = 0;  // with more than two faces, as the mesh came
  Findings findings_;
};

}  // namespace

Result<RepairedSurface> repairSurface(const SurfaceMesh& mesh, const RepairOptions& options,
                                      RunContext& run) {
  return Repair(mesh, options, run).go();
}

}  // namespace ecorche::mesh
