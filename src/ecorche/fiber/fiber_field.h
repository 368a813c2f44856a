#pragma once

#include <ecorche/core/finding.h>
#include <ecorche/core/result.h>
#include <ecorche/core/run_context.h>
#include <ecorche/domain/domain.h>
#include <ecorche/envelope/anatomy.h>
#include <ecorche/tissue/tissue.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace ecorche::fiber {

/// What a curve's end sits on: there the muscle's fibres begin (origin) or stop (insertion).
struct CurveEnd {
  enum class On : std::uint8_t { Bone, CutPlane, Tissue, Free };
  On on = On::Free;
  /// Bone or cut plane: its place in the domain's lists. Tissue: the other tissue's id. Free:
  /// unused.
  std::int32_t index = -1;
  /// Further points of the attachment, beside the curve's end itself [m].
  std::vector<mesh::Vector3> sites;
};

struct CurveEnds {
  CurveEnd origin;
  CurveEnd insertion;
};

/// Ends of one tissue, one pair per curve, in the order of CurveTissue::curves. Empty for fillers.
using MuscleEnds = std::vector<CurveEnds>;

/// What becomes of a piece of a muscle that no origin or no insertion touches, because its
/// neighbours pinch it off. Specks (FiberOptions::speckShare) follow their curve in any case.
enum class UnendedPiece : std::uint8_t {
  /// FiberWithoutEnds: nothing flows through such a piece.
  Refuse,
  /// Its fibres follow the nearest curve; a warning `piece-without-ends` names muscle and place.
  FollowCurve,
};

/// Lengths are shares of the muscle's own thickness, so that neither mesh nor unit matters.
struct FiberOptions {
  /// γ: how strongly fibres near the drawn curve follow it. 0: smoothness alone [unitless].
  double curveWeight = 10.0;
  /// Radius of the tube in which they do, over the muscle's local radius √(area / π) [unitless].
  double tubeRadiusRel = 0.75;
  /// How far an attachment reaches along the curve from its end, over the local radius [unitless].
  double attachmentReachRel = 1.0;
  /// How far an attachment reaches in space from the curve's end, over the local radius [unitless].
  double attachmentRadiusRel = 4.0;
  /// First and last share of the flow that is tendon, each in (0, 0.5). Unset: no tendon
  /// [unitless].
  std::optional<double> tendonShare;
  /// Fibres traced per muscle for its fibre length and for pictures. 0: none.
  int tracedCount = 100;
  /// Pieces with less than this share of the muscle's volume are specks: they may lack an end,
  /// their fibres follow the curve, a note says so [unitless].
  double speckShare = 0.01;
  UnendedPiece unendedPiece = UnendedPiece::Refuse;
};

/// Where fibres of one muscle begin or stop.
struct FiberEnd {
  double area = 0.0;                               ///< of the faces used [m²]
  mesh::Vector3 centroid = mesh::Vector3::Zero();  ///< of those faces [m]
  bool onAttachment =
      true;  ///< false: what the end should sit on was not reached; the muscle's own tip was used
};

/// Fibres of one muscle in figures and lines.
struct MuscleFibers {
  TissueId tissue;
  std::string name;
  std::vector<FiberEnd> origins;     ///< per curve
  std::vector<FiberEnd> insertions;  ///< per curve

  std::int64_t tetCount = 0;
  std::int64_t spreadTets =
      0;  ///< tets without a flow direction of their own: taken from neighbours
  double spreadVolumeShare = 0.0;  ///< their share of the muscle's volume
  std::int64_t vertexCount = 0;
  std::int64_t interiorExtrema =
      0;  ///< vertices off the ends where the flow is above or below all neighbours
  std::int64_t curveTets = 0;    ///< tets that the muscle's curves run through
  double angleToCurveDeg = 0.0;  ///< mean over those tets of the angle between fibre and tangent

  double fiberLength = 0.0;    ///< mean of the traced fibres, tendon excluded [m]
  double fiberLengthSd = 0.0;  ///< standard deviation [m]
  std::vector<std::vector<mesh::Vector3>> lines;  ///< traced fibres, origin first
};

/// Unit directions in which muscles contract, from origin to insertion.
struct FiberField {
  mesh::Directions tetFiber;     ///< #T×3 of the anatomy; zero in fat and fillers
  mesh::Directions vertexFiber;  ///< #V×3; on an interface that of the muscle with more volume
                                 ///< around; zero off muscles
  std::vector<double> flow;      ///< #T how far along its head, 0 about the origin … 1 about the
                                 ///< insertion, at the centroid; NaN off muscles
  std::vector<std::uint8_t> tendon;   ///< #T 1: tendon. Empty without FiberOptions::tendonShare
  std::vector<MuscleFibers> muscles;  ///< every tissue that is no filler and has tets, by id
  Findings findings;                  ///< directions spread, ends not reached, pieces without ends
};

/// Directions of the flow that runs through every muscle from its origins to its insertions.
///
/// Minimises ½ ∫|∇u|² + ½ γ ∫ φ |N∇u|² − ∫ q u over the muscle, N the normal plane of the nearest
/// curve and φ a tube about it [ABLSJ21 §4.4, integrals in place of the paper's sums over tets].
/// Every head lets in as much as its mean cross-section, evenly over its origin (q < 0), and out
/// over its insertion (q > 0); the rest of the surface is closed. The paper holds u = 0 and 1 there
/// instead, see docs/algorithms/fibers.md. Solved on the domain's tets, each with the volume that
/// the muscle has in it: the skinny tets of the subdivision carry directions but no unknowns.
///
/// @param anatomy  labelled tets [m]
/// @param domain   what the anatomy was cut from
/// @param tissues  muscles and fillers; id = kFirstMuscle + place
/// @param ends     per tissue, per curve; sizes as `tissues` (ContractError otherwise)
/// @return  unit directions in every tet and at every vertex of every muscle; turned with the
/// model, unchanged when it is scaled; the same bytes for any number of threads.
/// @errors  FiberWithoutEnds (a piece that no origin or no insertion touches, unless it is to
/// follow its curve), SystemSingular, Cancelled
[[nodiscard]] Result<FiberField> computeFibers(const envelope::Anatomy& anatomy,
                                               const domain::Domain& domain,
                                               const std::vector<tissue::CurveTissue>& tissues,
                                               const std::vector<MuscleEnds>& ends,
                                               const FiberOptions& options, RunContext& run);

}  // namespace ecorche::fiber
