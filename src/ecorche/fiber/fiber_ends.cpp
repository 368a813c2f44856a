#include <ecorche/core/contract.h>
#include <ecorche/fiber/fiber_ends.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace ecorche::fiber {

using mesh::Vector3;

namespace {

// A surface face with what the choice needs of it.
struct Face {
  Vector3 centroid;
  double area;
  CurveGuide::Nearest nearest;
};

std::vector<Face> describeSurface(const MuscleMesh& muscle, const CurveGuide& guide) {
  std::vector<Face> faces;
  faces.reserve(muscle.surface.size());
  for (const MuscleFace& f : muscle.surface) {
    const Vector3 a = muscle.mesh.V.row(f.v[0]).transpose();
    const Vector3 b = muscle.mesh.V.row(f.v[1]).transpose();
    const Vector3 c = muscle.mesh.V.row(f.v[2]).transpose();
    const Vector3 centroid = (a + b + c) / 3.0;
    faces.push_back({centroid, 0.5 * (b - a).cross(c - a).norm(), guide.nearest(centroid)});
  }
  return faces;
}

bool liesOn(const MuscleFace& face, const CurveEnd& end,
            const std::vector<domain::BoundaryTag>& tags) {
  using Kind = domain::BoundaryTag::Kind;
  if (end.on == CurveEnd::On::Free) return false;
  if (end.on == CurveEnd::On::Tissue) return face.boundary < 0 && face.beyond.value == end.index;
  if (face.boundary < 0) return false;
  const domain::BoundaryTag tag = tags[static_cast<std::size_t>(face.boundary)];
  const Kind wanted = end.on == CurveEnd::On::Bone ? Kind::Bone : Kind::CutPlane;
  return tag.kind == wanted && tag.index == end.index;
}

// One end of one curve while its faces are chosen.
struct End {
  std::int32_t curve = 0;
  bool insertion = false;
  Vector3 place;
  double radius = 0.0;  // local radius of the muscle [m]
  double reach = 0.0;   // along the curve [m]
  std::vector<std::int32_t> faces;
  FiberEnd figure;
};

End describeEnd(const CurveGuide& guide, std::int32_t curve, bool insertion,
                const FiberOptions& options) {
  End end;
  end.curve = curve;
  end.insertion = insertion;
  end.place = guide.end(curve, insertion);
  const double length = guide.length(curve);
  // Over the last eighth: the very end of a tapered muscle says little about it
  for (const double share : {0.0, 0.0625, 0.125}) {
    end.radius += guide.radius(curve, insertion ? length * (1.0 - share) : length * share) / 3.0;
  }
  end.reach = std::min(options.attachmentReachRel * end.radius, 0.25 * length);
  return end;
}

// Arc length between the face and the end, infinite where another curve is nearer and the end is
// not.
double arcFromEnd(const Face& face, const End& end, const CurveGuide& guide) {
  const double distance = (face.centroid - end.place).norm();
  if (face.nearest.curve == end.curve) {
    return end.insertion ? guide.length(end.curve) - face.nearest.arc : face.nearest.arc;
  }
  // Heads that share an end share its faces
  return distance <= end.radius ? 0.0 : std::numeric_limits<double>::infinity();
}

void chooseAttachment(End& end, const CurveEnd& on, const MuscleMesh& muscle,
                      const std::vector<Face>& faces, const CurveGuide& guide,
                      const std::vector<domain::BoundaryTag>& tags, const FiberOptions& options) {
  for (std::size_t f = 0; f < faces.size(); ++f) {
    if (!liesOn(muscle.surface[f], on, tags)) continue;
    const Vector3& x = faces[f].centroid;
    bool within = (x - end.place).norm() <= options.attachmentRadiusRel * end.radius &&
                  arcFromEnd(faces[f], end, guide) <= end.reach;
    for (const Vector3& site : on.sites) within = within || (x - site).norm() <= end.radius;
    if (within) end.faces.push_back(static_cast<std::int32_t>(f));
  }
}

// The muscle's surface past the end of its curve; where tets are too coarse to have any, the face
// nearest to the end.
void chooseTip(End& end, const MuscleMesh& muscle, const std::vector<Face>& faces,
               const CurveGuide& guide, const FiberOptions& options) {
  double nearestDistance = std::numeric_limits<double>::infinity();
  std::int32_t nearestFace = -1;
  const double past = 1e-9 * guide.length(end.curve);
  for (std::size_t f = 0; f < faces.size(); ++f) {
    const double distance = (faces[f].centroid - end.place).norm();
    if (distance < nearestDistance) {
      nearestDistance = distance;
      nearestFace = static_cast<std::int32_t>(f);
    }
    if (distance > options.attachmentRadiusRel * end.radius) continue;
    if (faces[f].nearest.curve == end.curve && arcFromEnd(faces[f], end, guide) <= past) {
      end.faces.push_back(static_cast<std::int32_t>(f));
    }
  }
  end.figure.onAttachment = false;
  if (!end.faces.empty() || nearestFace < 0) return;
  // Near means near the mesh as well: the face's own tet is the unit here
  const std::int32_t tet = muscle.surface[static_cast<std::size_t>(nearestFace)].tet;
  double size = 0.0;
  for (const auto& e : mesh::kTetEdge) {
    size = std::max(size, (muscle.mesh.V.row(muscle.mesh.T(tet, e[0])) -
                           muscle.mesh.V.row(muscle.mesh.T(tet, e[1])))
                              .norm());
  }
  if (nearestDistance <= 2.0 * std::max(end.radius, size)) end.faces.push_back(nearestFace);
}

// A face that an origin and an insertion claim goes to the nearer of the two places.
void partRoles(std::vector<End>& ends, const std::vector<Face>& faces) {
  constexpr double kFar = std::numeric_limits<double>::infinity();
  std::vector<std::array<double, 2>> nearest(faces.size(), {kFar, kFar});
  for (const End& end : ends) {
    for (const std::int32_t f : end.faces) {
      double& d = nearest[static_cast<std::size_t>(f)][end.insertion ? 1 : 0];
      d = std::min(d, (faces[static_cast<std::size_t>(f)].centroid - end.place).norm());
    }
  }
  for (End& end : ends) {
    std::erase_if(end.faces, [&](std::int32_t f) {
      const auto& d = nearest[static_cast<std::size_t>(f)];
      return end.insertion ? d[0] < d[1] : d[1] <= d[0] && d[1] < kFar;
    });
  }
}

FiberEnd measureEnd(const End& end, const std::vector<Face>& faces) {
  FiberEnd figure = end.figure;
  for (const std::int32_t f : end.faces) {
    const Face& face = faces[static_cast<std::size_t>(f)];
    figure.area += face.area;
    figure.centroid += face.area * face.centroid;
  }
  figure.centroid = figure.area > 0.0 ? Vector3(figure.centroid / figure.area) : end.place;
  return figure;
}

Vector3 componentCentroid(const MuscleMesh& muscle, std::int32_t component) {
  Vector3 sum = Vector3::Zero();
  double volume = 0.0;
  for (std::size_t t = 0; t < muscle.component.size(); ++t) {
    if (muscle.component[t] != component) continue;
    const double v = muscle.volume[static_cast<Eigen::Index>(t)];
    sum += v * muscle.centroid(static_cast<std::int64_t>(t));
    volume += v;
  }
  return volume > 0.0 ? Vector3(sum / volume) : sum;
}

}  // namespace

Result<SelectedEnds> selectEnds(const MuscleMesh& muscle, const CurveGuide& guide,
                                const std::vector<domain::BoundaryTag>& boundaryTag,
                                const tissue::CurveTissue& tissue, const MuscleEnds& ends,
                                const FiberOptions& options) {
  EC_REQUIRE_EQ(ends.size(), tissue.curves.size());
  const std::vector<Face> faces = describeSurface(muscle, guide);

  SelectedEnds out;
  std::vector<End> chosen;
  for (std::int32_t c = 0; c < guide.curveCount(); ++c) {
    for (const bool insertion : {false, true}) {
      const CurveEnds& both = ends[static_cast<std::size_t>(c)];
      const CurveEnd& on = insertion ? both.insertion : both.origin;
      End end = describeEnd(guide, c, insertion, options);
      chooseAttachment(end, on, muscle, faces, guide, boundaryTag, options);
      if (end.faces.empty()) {
        chooseTip(end, muscle, faces, guide, options);
        if (on.on != CurveEnd::On::Free) {
          out.findings.push_back(
              {Severity::Warning, "end-not-reached", tissue.name,
               fmt::format("{} of \"{}\" does not touch what its curve{} ends on; fibres {} at the "
                           "muscle's tip",
                           insertion ? "the insertion" : "the origin", tissue.name,
                           tissue.curves.size() > 1 ? fmt::format(" {}", c + 1) : "",
                           insertion ? "stop" : "begin"),
               end.place, 0.0});
        }
      }
      chosen.push_back(std::move(end));
    }
  }

  partRoles(chosen, faces);

  // Flow needs both ends in every piece
  const auto componentOf = [&](std::int32_t face) {
    const auto tet = static_cast<std::size_t>(muscle.surface[static_cast<std::size_t>(face)].tet);
    return static_cast<std::size_t>(muscle.component[tet]);
  };
  std::vector<std::array<bool, 2>> has(muscle.componentVolume.size(), {false, false});
  for (const End& end : chosen) {
    for (const std::int32_t f : end.faces) {
      has[componentOf(f)][end.insertion ? 1 : 0] |= faces[static_cast<std::size_t>(f)].area > 0.0;
    }
  }
  const double total = muscle.volume.sum();
  out.unended.assign(has.size(), 0);
  for (std::size_t c = 0; c < has.size(); ++c) {
    if (has[c][0] && has[c][1]) continue;
    out.unended[c] = 1;
    const double volume = muscle.componentVolume[c];
    const Vector3 centre = componentCentroid(muscle, static_cast<std::int32_t>(c));
    if (volume < options.speckShare * total) {
      out.findings.push_back(
          {Severity::Note, "speck-without-ends", tissue.name,
           fmt::format("a speck of \"{}\" lacks an end; its fibres follow the curve", tissue.name),
           centre, volume});
      continue;
    }
    const std::string fault = fmt::format(
        "a piece of \"{}\" of {:.3g} cm³ ({:.1f} % of the muscle) has no {}: its neighbours pinch "
        "it off from its curve's end",
        tissue.name, volume * 1e6, 100.0 * volume / total,
        has[c][0]   ? "insertion"
        : has[c][1] ? "origin"
                    : "origin and no insertion");
    constexpr const char* kRemedy = "raise the tissue value there or move the curve";
    if (options.unendedPiece == UnendedPiece::Refuse) {
      return fail(ErrorCode::FiberWithoutEnds, fmt::format("{}; {}", fault, kRemedy),
                  {.object = tissue.name, .point = centre});
    }
    out.findings.push_back({Severity::Warning, "piece-without-ends", tissue.name,
                            fmt::format("{}; its fibres follow the curve; {}", fault, kRemedy),
                            centre, volume});
  }

  out.attached.assign(muscle.vertexId.size(), 0);
  for (End& end : chosen) {
    (end.insertion ? out.insertions : out.origins).push_back(measureEnd(end, faces));
    for (const std::int32_t f : end.faces) {
      for (const std::int32_t v : muscle.surface[static_cast<std::size_t>(f)].v) {
        out.attached[static_cast<std::size_t>(v)] = 1;
      }
    }
    std::erase_if(end.faces, [&](std::int32_t f) { return out.unended[componentOf(f)] != 0; });
    FlowEnd flow{end.insertion ? Role::Insertion : Role::Origin, guide.flux(end.curve),
                 std::move(end.faces), 0.0};
    for (const std::int32_t f : flow.faces) flow.area += faces[static_cast<std::size_t>(f)].area;
    out.flow.push_back(std::move(flow));
  }
  return out;
}

}  // namespace ecorche::fiber
