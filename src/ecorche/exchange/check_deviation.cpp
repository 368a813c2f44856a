#include <ecorche/core/parallel.h>
#include <ecorche/exchange/check_parts.h>
#include <ecorche/mesh/face_repair.h>
#include <ecorche/mesh/open_sheets.h>
#include <ecorche/mesh/read_mesh.h>
#include <ecorche/mesh/surface_check.h>
#include <ecorche/mesh/surface_query.h>
#include <ecorche/mesh/surface_topology.h>
#include <ecorche/mesh/weld.h>
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

namespace ecorche::exchange {

using mesh::Vector3;

namespace {

// A point of a surface and the direction that its face looks in.
struct Sample {
  Vector3 point;
  Vector3 normal;
};

// An original as it was given, ready for questions.
struct Original {
  std::string name;
  std::string kind;
  mesh::SurfaceMesh mesh;
  mesh::SurfaceQuery query;
  mesh::Box box;
  bool closed = false;
  std::vector<std::uint8_t> border;  // by face, of an open one: bit k where its side k is a border
  std::vector<std::uint8_t> hollow;  // by face: wall of a hollow in it, or a stray beside it

  // Over a hole the domain has a cap, and what is nearest to it is the border.
  [[nodiscard]] bool isOverHole(const mesh::SurfaceQuery::Closest& nearest) const {
    if (closed || nearest.face < 0) return false;
    const std::uint8_t sides = border[static_cast<std::size_t>(nearest.face)];
    for (int k = 0; k < 3; ++k) {
      if ((sides >> k & 1) == 0) continue;
      const Vector3 a = mesh.V.row(mesh.F(nearest.face, k)).transpose();
      const Vector3 b = mesh.V.row(mesh.F(nearest.face, (k + 1) % 3)).transpose();
      const double s = std::clamp((nearest.point - a).dot(b - a) / (b - a).squaredNorm(), 0.0, 1.0);
      if ((a + s * (b - a) - nearest.point).norm() < 1e-9 * box.diagonal()) return true;
    }
    return false;
  }
};

// Marrow and the like: no domain is in there, so nothing can be near these walls.
std::vector<std::uint8_t> hollowFaces(const mesh::SurfaceMesh& mesh) {
  const mesh::FaceComponents pieces = mesh::components(mesh.F);
  const auto check = mesh::checkSurface(mesh).components;
  std::vector<std::uint8_t> out(pieces.label.size(), 0);
  for (std::size_t f = 0; f < out.size(); ++f)
    out[f] = check[static_cast<std::size_t>(pieces.label[f])].inward && check.size() > 1;
  return out;
}

// Hair cards and crumbs beside a skin: the domain leaves them out, and its findings say so.
std::vector<std::uint8_t> strayFaces(const mesh::SurfaceMesh& mesh) {
  const mesh::SurfaceEdges edges = mesh::surfaceEdges(mesh.F);
  const mesh::FaceComponents pieces = mesh::components(mesh.F, edges);
  const std::vector<char> sheet = mesh::openSheets(mesh.V, mesh.F, edges, pieces);
  const std::vector<char> crumb =
      mesh::crumbs(mesh.V, mesh.F, pieces, mesh::checkSurface(mesh).components);
  std::vector<std::uint8_t> out(pieces.label.size(), 0);
  for (std::size_t f = 0; f < out.size(); ++f) {
    const auto piece = static_cast<std::size_t>(pieces.label[f]);
    out[f] = sheet[piece] != 0 || crumb[piece] != 0;
  }
  return out;
}

std::vector<std::uint8_t> borderSides(const mesh::Triangles& F) {
  std::vector<std::uint8_t> out(static_cast<std::size_t>(F.rows()), 0);
  const mesh::SurfaceEdges edges = mesh::surfaceEdges(F);
  for (std::size_t e = 0; e < edges.count(); ++e) {
    if (edges.faceCount(e) != 1) continue;
    const std::int32_t slot = edges.slot[static_cast<std::size_t>(edges.first[e])];
    out[static_cast<std::size_t>(slot / 3)] |= static_cast<std::uint8_t>(1 << slot % 3);
  }
  return out;
}

// Points of a face no farther apart than `spacing`, without its corners.
void sampleFace(const Vector3& a, const Vector3& b, const Vector3& c, double spacing,
                std::vector<Sample>& out) {
  const Vector3 normal = (b - a).cross(c - a).normalized();
  const double longest =
      std::sqrt(std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()}));
  const auto n = static_cast<int>(std::clamp(std::ceil(longest / spacing), 1.0, 64.0));
  for (int i = 0; i < n; ++i) {
    for (int j = 0; i + j < n; ++j) {
      const double s = (i + 1.0 / 3.0) / n;
      const double t = (j + 1.0 / 3.0) / n;
      out.push_back({a + s * (b - a) + t * (c - a), normal});
    }
  }
}

struct Farthest {
  double distance = 0.0;
  Vector3 point = Vector3::Zero();
  std::string object;
  std::int64_t asked = 0;
  std::int64_t hidden = 0;
  std::int64_t beyond = 0;

  void see(double d, const Vector3& x, const std::string& name, double limit) {
    ++asked;
    beyond += d > limit;
    if (d <= distance) return;
    distance = d;
    point = x;
    object = name;
  }
};

class Deviation {
 public:
  explicit Deviation(const CheckedFiles& files) : files_(files) {
    limit_ = files.record.surfaceTolerance * files.record.skinDiagonal;
    spacing_ = 4.0 * limit_;
    // Joint gaps narrower than this may be closed by a wrap around both bones
    clearance_ = 5.0 * limit_;
  }

  Result<void> read(RunContext& run) {
    for (const SurfaceRecord& s : files_.record.surfaces) {
      auto mesh = mesh::readMesh(files_.folder / s.file, {}, run);
      if (!mesh) return passOn(mesh);
      mesh::SurfaceQuery query(*mesh);
      const mesh::Box box = mesh::boundingBox(*mesh);
      const mesh::SurfaceMesh welded = mesh::weldExact(*mesh);  // faces in the same order
      const bool closed = mesh::isClosed(welded.F);
      auto border = closed ? std::vector<std::uint8_t>() : borderSides(welded.F);
      std::vector<std::uint8_t> hollow;
      if (closed && s.kind == "bone") hollow = hollowFaces(welded);
      if (s.kind == "skin") hollow = strayFaces(welded);
      originals_.push_back({s.name, s.kind, std::move(*mesh), std::move(query), box, closed,
                            std::move(border), std::move(hollow)});
    }
    return {};
  }

  // Faces of the domain that carry a kind, against the originals of that kind; and back.
  void check(const std::string& kind, const char* checkName, Checks& checks) const {
    if (std::ranges::none_of(originals_, [&](const Original& o) { return o.kind == kind; })) return;
    const mesh::SurfaceMesh written = facesOf(kind);
    Farthest outward = toOriginals(written, kind);
    Farthest back = fromOriginals(kind);
    Check c{checkName};
    c.limit = files_.record.surfaceTolerance;
    const Farthest& worst = outward.distance > back.distance ? outward : back;
    c.value = worst.distance / files_.record.skinDiagonal;
    c.pass = c.value <= c.limit;
    if (!c.pass) {
      c.point = worst.point;
      c.object = worst.object;
    }
    c.detail = fmt::format(
        "domain to original {:.4f} %, original to domain {:.4f} % of the diagonal; {} of {} points "
        "beyond, {} points "
        "that the domain cannot reach left out",
        100.0 * outward.distance / files_.record.skinDiagonal,
        100.0 * back.distance / files_.record.skinDiagonal, outward.beyond + back.beyond,
        outward.asked + back.asked, back.hidden);
    checks.push_back(std::move(c));
  }

 private:
  // Triangles of the MEDIT file that are marked as this kind; of a VTU alone all that no plane
  // holds.
  mesh::SurfaceMesh facesOf(const std::string& kind) const {
    mesh::SurfaceMesh out;
    out.V = files_.anatomy->mesh.V;
    std::vector<Eigen::Index> rows;
    if (files_.medit) {
      for (std::size_t f = 0; f < files_.medit->reference.size(); ++f) {
        const auto& references = files_.record.references;
        const auto at =
            std::ranges::find(references, files_.medit->reference[f], &FaceReference::reference);
        if (at != references.end() && at->kind == kind)
          rows.push_back(static_cast<Eigen::Index>(f));
      }
    } else {
      for (Eigen::Index f = 0; f < files_.boundary.F.rows(); ++f) rows.push_back(f);
    }
    const mesh::Triangles& F = files_.medit ? files_.medit->F : files_.boundary.F;
    out.F = F(rows, Eigen::all);
    return out;
  }

  template <class Ask>
  Farthest farthestOf(const std::vector<Sample>& samples, const std::string& object,
                      const Ask& ask) const {
    // Below zero: the sample does not count
    std::vector<double> distance(samples.size());
    parallelFor(static_cast<std::int64_t>(samples.size()), [&](std::int64_t i) {
      distance[static_cast<std::size_t>(i)] = ask(samples[static_cast<std::size_t>(i)]);
    });
    Farthest far;
    for (std::size_t i = 0; i < samples.size(); ++i) {
      if (distance[i] < 0.0) {
        ++far.hidden;
      } else {
        far.see(distance[i], samples[i].point, object, limit_);
      }
    }
    return far;
  }

  std::vector<Sample> samplesOf(const mesh::SurfaceMesh& mesh,
                                const std::vector<std::uint8_t>& leaveOut = {}) const {
    std::vector<Sample> samples;
    std::vector<std::uint8_t> seen(static_cast<std::size_t>(mesh.V.rows()), 0);
    for (Eigen::Index f = 0; f < mesh.F.rows(); ++f) {
      if (!leaveOut.empty() && leaveOut[static_cast<std::size_t>(f)] != 0) continue;
      const Vector3 a = mesh.V.row(mesh.F(f, 0)).transpose();
      const Vector3 b = mesh.V.row(mesh.F(f, 1)).transpose();
      const Vector3 c = mesh.V.row(mesh.F(f, 2)).transpose();
      const Vector3 area = (b - a).cross(c - a);
      if (!(area.norm() > 0.0)) continue;
      for (int k = 0; k < 3; ++k) {
        const std::int32_t v = mesh.F(f, k);
        if (!std::exchange(seen[static_cast<std::size_t>(v)], 1))
          samples.push_back({mesh.V.row(v).transpose(), area.normalized()});
      }
      sampleFace(a, b, c, spacing_, samples);
    }
    return samples;
  }

  Farthest toOriginals(const mesh::SurfaceMesh& written, const std::string& kind) const {
    return farthestOf(samplesOf(written), kind, [&](const Sample& s) {
      double nearest = std::numeric_limits<double>::infinity();
      bool overHole = false;
      for (const Original& o : originals_) {
        // Without marks any original will do, and planes as well
        if (files_.medit && o.kind != kind) continue;
        if (boxDistance(o.box, s.point) >= nearest) continue;
        const auto closest = o.query.closest(s.point);
        if (closest.distance >= nearest) continue;
        nearest = closest.distance;
        overHole = o.isOverHole(closest);
      }
      if (!files_.medit) {
        for (const PlaneRecord& p : files_.record.planes)
          nearest = std::min(nearest, std::abs((s.point - p.point).dot(p.normal)));
      }
      return overHole ? -1.0 : nearest;
    });
  }

  Farthest fromOriginals(const std::string& kind) const {
    const mesh::SurfaceQuery domain(files_.anatomy->mesh.V, files_.boundary.F);
    Farthest worst;
    for (const Original& o : originals_) {
      if (o.kind != kind) continue;
      const Farthest far = farthestOf(samplesOf(o.mesh, o.hollow), o.name, [&](const Sample& s) {
        const double distance = domain.distance(s.point);
        // Whether the domain could have reached a point costs much: it is asked where it may decide
        if (distance <= 0.5 * limit_) return distance;
        return isExposed(o, s) ? distance : -1.0;
      });
      if (far.distance > worst.distance) {
        worst.distance = far.distance;
        worst.point = far.point;
        worst.object = far.object;
      }
      worst.asked += far.asked;
      worst.beyond += far.beyond;
      worst.hidden += far.hidden;
    }
    return worst;
  }

  static double boxDistance(const mesh::Box& box, const Vector3& p) {
    return (box.lo - p).cwiseMax(p - box.hi).cwiseMax(0.0).norm();
  }

  // On the kept side of every plane, outside every other hole, inside the skin, and not in a gap
  // too narrow for a wrap.
  bool isExposed(const Original& own, const Sample& s) const {
    for (const PlaneRecord& p : files_.record.planes) {
      if ((s.point - p.point).dot(p.normal) <= limit_) return false;
    }
    for (const Original& other : originals_) {
      if (&other == &own) continue;
      if (other.kind == "skin") {
        if (other.closed && other.query.windingNumber(s.point).value_or(0) == 0) return false;
        continue;
      }
      if (boxDistance(other.box, s.point) > clearance_) continue;
      if (other.query.distance(s.point) <= clearance_) return false;
      if (other.closed && other.query.inside(s.point)) return false;
    }
    if (own.kind == "skin") return true;
    // Its own far side as well: cavities and cracks of a bone are closed over
    const Vector3 lifted = s.point + 1e-3 * limit_ * s.normal;
    return !own.query.firstHit(lifted, s.normal, clearance_).has_value() &&
           !(own.closed && own.query.windingNumber(lifted).value_or(1) != 0);
  }

  const CheckedFiles& files_;
  std::vector<Original> originals_;
  double limit_ = 0.0;
  double spacing_ = 0.0;
  double clearance_ = 0.0;
};

}  // namespace

Result<void> checkDeviation(const CheckedFiles& files, Checks& checks, RunContext& run) {
  if (files.record.surfaces.empty()) return {};
  Deviation deviation(files);
  if (auto ok = deviation.read(run); !ok) return passOn(ok);
  if (run.cancelled()) return fail(ErrorCode::Cancelled, "checking files");
  deviation.check("skin", "skin-deviation", checks);
  deviation.check("bone", "bone-deviation", checks);
  return {};
}

}  // namespace ecorche::exchange
