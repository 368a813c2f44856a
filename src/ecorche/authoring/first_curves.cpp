#include <ecorche/authoring/curve_relaxation.h>
#include <ecorche/authoring/first_curves.h>
#include <ecorche/authoring/muscle_heads.h>
#include <ecorche/authoring/names.h>
#include <ecorche/authoring/seats.h>
#include <ecorche/core/parallel.h>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace ecorche::authoring {

using mesh::Vector3;
using model::Attachment;
using model::Support;

namespace {

constexpr double kOnPlaneRel = 1e-3;   // of the diagonal
constexpr double kShortestRel = 1e-3;  // no curve between ends nearer than this
constexpr double kPlacedRel = 5e-4;    // deeper than this counts as inside a bone
constexpr double kMostOutside = 0.1;   // of a curve's length; it is left out beyond
constexpr double kMostInBone = 0.02;   // a warning beyond

struct Head {
  HeadPlan plan;  ///< places in the muscle's sites; `to` is past the end where it ends on the plane
  Seat from, to;
  Band band;
};

/// A muscle that is being made from its sites.
struct Draft {
  std::size_t row = 0;  ///< in the table
  std::vector<AttachmentSite> sites;
  std::vector<Seat> seats;
  std::vector<Head> heads;
  /// Side of the mirror that it keeps to: 1 or −1; 0: none.
  double side = 0.0;
  bool median = false;  ///< folded onto the first side, to be unfolded when both sides are kept
};

class FirstCurves {
 public:
  FirstCurves(const std::vector<MuscleSites>& table, const Surroundings& around, RunContext& run)
      : table_(table), around_(around), run_(run), space_(around.skin, around.bones) {}

  Result<FirstMuscles> make() {
    plan();
    spread();
    settleAll();
    if (run_.cancelled()) return fail(ErrorCode::Cancelled, "first curves");
    return finish();
  }

 private:
  const std::vector<MuscleSites>& table_;
  const Surroundings& around_;
  RunContext& run_;
  FreeSpace space_;
  std::vector<std::optional<Draft>> drafts_;          // by row
  std::vector<std::optional<std::size_t>> imagesOf_;  // by row: the twin that it is the image of
  std::vector<Findings> findings_;                    // by row

  [[nodiscard]] double rel(double share) const { return share * around_.diagonal; }

  void leaveOut(std::size_t row, const char* kind, std::string message) {
    findings_[row].push_back({Severity::Note, kind, table_[row].muscle, std::move(message),
                              table_[row].sites.front().at});
  }

  // --- who is made, who is an image, and from which sites
  // -----------------------------------------

  void plan() {
    drafts_.resize(table_.size());
    imagesOf_.resize(table_.size());
    findings_.resize(table_.size());
    std::vector<bool> second(table_.size(), false);
    std::vector<std::optional<std::size_t>> twins(table_.size());
    if (around_.mirror) {
      second = onSecondSide(table_, *around_.mirror, around_.diagonal);
      twins = twinsIn(table_);
    }
    parallelFor(
        std::ssize(table_),
        [&](std::int64_t k) {
          const auto row = static_cast<std::size_t>(k);
          if (run_.cancelled()) return;
          if (second[row] && !around_.keepsBothSides) {
            leaveOut(row, "other-half",
                     fmt::format("{} lies on the side that the symmetry plane removes",
                                 table_[row].muscle));
          } else if (second[row] && twins[row] && !second[*twins[row]]) {
            imagesOf_[row] = twins[row];
          } else {
            drafts_[row] = draftOf(row, second[row]);
          }
        },
        1);
  }

  std::optional<Draft> draftOf(std::size_t row, bool second) {
    Draft draft{.row = row, .sites = table_[row].sites, .seats = {}, .heads = {}};
    std::optional<AttachmentSite> beyond;
    if (around_.mirror) {
      const bool sided = sideFrom(table_[row].muscle) != model::Side::Unknown;
      draft.side = second ? -1.0 : 1.0;
      draft.median = !sided && !second;
      if (draft.median || !around_.keepsBothSides) {
        FoldedSites fold = folded(table_[row], *around_.mirror, around_.diagonal);
        draft.sites = std::move(fold.sites);
        beyond = fold.beyond;
      }
      if (draft.sites.empty()) {
        leaveOut(
            row, "other-half",
            fmt::format("{} lies on the side that the symmetry plane removes", table_[row].muscle));
        return std::nullopt;
      }
    }
    for (const AttachmentSite& site : draft.sites) {
      draft.seats.push_back(seatOf(site, around_.bones, space_, around_.diagonal));
      keepOnSide(draft.seats.back());
    }

    std::vector<HeadPlan> plans = planHeads(draft.sites, draft.seats, around_.centre);
    if (plans.empty() && beyond) {
      // From the one kept site towards the other side, as far as the plane
      const Vector3 a = draft.seats[0].at;
      const double ha = around_.mirror->height(a), hb = around_.mirror->height(beyond->at);
      const Seat seat = seatOnPlane(a + (beyond->at - a) * ha / (ha - hb), *around_.mirror,
                                    around_.plane, space_, around_.diagonal);
      draft.heads.push_back({{0, draft.sites.size(), {}}, draft.seats[0], seat, {}});
    }
    for (HeadPlan& each : plans)
      draft.heads.push_back({each, draft.seats[each.from], draft.seats[each.to], {}});
    std::erase_if(draft.heads, [&](const Head& head) {
      return (head.from.at - head.to.at).norm() < rel(kShortestRel);
    });
    if (draft.heads.empty()) {
      leaveOut(
          row, "too-few-sites",
          fmt::format("{} has no two attachments apart from each other; draw its curve by hand",
                      table_[row].muscle));
      return std::nullopt;
    }
    return draft;
  }

  // An end on the removed side of the plane would be cut off: along its bone to the plane
  void keepOnSide(Seat& seat) const {
    if (!around_.mirror || around_.keepsBothSides) return;
    constexpr int kSteps = 8;
    for (int step = 0; step <= kSteps; ++step) {
      const double height = around_.mirror->height(seat.at);
      if (height >= 0.0) return;
      const Vector3 onPlane = seat.at - height * around_.mirror->normal;
      if (seat.bone < 0 || step == kSteps) {
        seat.at = onPlane;
      } else {
        seat = slid(seat, onPlane - height * around_.mirror->normal, around_.bones, space_,
                    around_.diagonal);
      }
    }
  }

  // --- ends, then curves
  // --------------------------------------------------------------------------

  [[nodiscard]] bool onPlane(const Head& head) const {
    return std::abs(around_.mirror->height(head.from.at)) < rel(kOnPlaneRel) &&
           std::abs(around_.mirror->height(head.to.at)) < rel(kOnPlaneRel);
  }

  // The half space that a head keeps to; none for one that runs along the plane of a whole body
  [[nodiscard]] Vector3 sideOf(const Draft& draft, const Head& head) const {
    if (draft.side == 0.0) return Vector3::Zero();
    if (around_.keepsBothSides && draft.median && onPlane(head)) return Vector3::Zero();
    return draft.side * around_.mirror->normal;
  }

  void spread() {
    std::vector<SlidingEnd> ends;
    for (auto& draft : drafts_) {
      if (!draft) continue;
      for (Head& head : draft->heads) {
        const Band band = bandThrough(head.from.at, {}, head.to.at, around_.diagonal);
        for (Seat* seat : {&head.from, &head.to}) {
          SlidingEnd end{seat, static_cast<int>(draft->row), band.apart};
          // Muscles of the middle meet there; the others keep from their twins
          if (around_.mirror && !draft->median) {
            end.planePoint = around_.mirror->point;
            end.planeNormal = sideOf(*draft, head);
          }
          ends.push_back(end);
        }
      }
    }
    spreadEnds(ends, around_.bones, space_, around_.diagonal);
  }

  void settleAll() {
    std::vector<Head*> heads;
    std::vector<Band> bands;
    for (auto& draft : drafts_) {
      if (!draft) continue;
      for (Head& head : draft->heads) {
        std::vector<Vector3> along;
        for (const std::size_t k : head.plan.along) along.push_back(draft->seats[k].at);
        Band band = bandThrough(head.from.at, along, head.to.at, around_.diagonal);
        band.muscle = static_cast<int>(draft->row);
        band.planeNormal = sideOf(*draft, head);
        if (around_.mirror) band.planePoint = around_.mirror->point;
        heads.push_back(&head);
        bands.push_back(std::move(band));
      }
    }
    parallelFor(
        std::ssize(bands),
        [&](std::int64_t k) {
          if (!run_.cancelled()) settle(bands[static_cast<std::size_t>(k)], space_);
        },
        1);
    if (run_.cancelled()) return;
    const bool mirrored = around_.mirror && around_.keepsBothSides;
    settleTogether(bands, space_, mirrored ? around_.mirror->point : Vector3::Zero(),
                   mirrored ? around_.mirror->normal : Vector3::Zero());
    for (std::size_t k = 0; k < bands.size(); ++k) heads[k]->band = std::move(bands[k]);
  }

  // --- tissues
  // ------------------------------------------------------------------------------------

  Result<FirstMuscles> finish() {
    std::vector<std::optional<model::Tissue>> muscles(table_.size());
    parallelFor(
        std::ssize(table_),
        [&](std::int64_t k) {
          const auto row = static_cast<std::size_t>(k);
          if (run_.cancelled()) return;
          if (drafts_[row]) {
            muscles[row] = muscleOf(*drafts_[row]);
          } else if (imagesOf_[row] && drafts_[*imagesOf_[row]]) {
            muscles[row] = imageOf(*drafts_[*imagesOf_[row]], row);
          } else if (imagesOf_[row]) {
            leaveOut(row, "twin-left-out",
                     fmt::format("{} was left out with its twin {}", table_[row].muscle,
                                 table_[*imagesOf_[row]].muscle));
          }
        },
        1);
    if (run_.cancelled()) return fail(ErrorCode::Cancelled, "first curves");
    FirstMuscles out;
    for (std::size_t row = 0; row < table_.size(); ++row) {
      if (muscles[row]) out.muscles.push_back(std::move(*muscles[row]));
      out.findings.insert(out.findings.end(), findings_[row].begin(), findings_[row].end());
    }
    return out;
  }

  [[nodiscard]] std::vector<Vector3> rounded(std::vector<Vector3> points) const {
    // A millionth of the body is as fine as a first guess can be meant, and reads better in a file
    const double perStep = std::pow(10.0, -std::floor(std::log10(rel(1e-6))));
    for (Vector3& p : points) p = (p * perStep).array().round() / perStep + 0.0;
    return points;
  }

  static model::Curve curveOf(const std::vector<Vector3>& points, const Support& start,
                              const Support& end) {
    model::Curve curve;
    curve.start = start;
    curve.end = end;
    // Thick in the middle, as muscles are
    for (std::size_t p = 0; p < points.size(); ++p) {
      const bool atEnd = p == 0 || p + 1 == points.size();
      curve.points.push_back({points[p], atEnd ? 0.5 : 1.0});
    }
    return curve;
  }

  // Adds the curve, unless it leaves the skin; says what is wrong with it.
  void add(model::Tissue& muscle, model::Curve curve, std::size_t row) {
    if (muscle.curves.size() > 0 && curve.name.empty())
      curve.name = fmt::format("head {}", muscle.curves.size() + 1);
    const Placement placed = placementOf(model::splineOf(curve), around_);
    if (placed.outside > kMostOutside) {
      leaveOut(row, "no-way",
               fmt::format("{} would leave the skin on its way between its attachments; are all of "
                           "them its own? Draw its curve by hand",
                           table_[row].muscle));
      return;
    }
    if (placed.inBone > kMostInBone || placed.outside > 0.0) {
      findings_[row].push_back(
          {Severity::Warning, "in-the-way", table_[row].muscle,
           fmt::format("{}: no way around; {:.0f} % of its curve run through bone and {:.0f} % "
                       "outside the skin",
                       table_[row].muscle, 100 * placed.inBone, 100 * placed.outside),
           curve.points[curve.points.size() / 2].at});
    }
    muscle.curves.push_back(std::move(curve));
  }

  std::optional<model::Tissue> muscleOf(const Draft& draft) {
    model::Tissue muscle = named(draft.row);
    for (const Head& head : draft.heads) {
      const std::vector<Vector3> points = rounded(controlPoints(head.band, space_));
      if (!draft.median || !around_.keepsBothSides || onPlane(head)) {
        add(muscle, curveOf(points, head.from.support, head.to.support), draft.row);
        continue;
      }
      const Head image = imageOf(head);
      const std::vector<Vector3> imagePoints = imageOf(points, head, image);
      if (head.to.support.on == Support::On::Plane) {
        // One curve through the plane
        std::vector<Vector3> through = points;
        through.insert(through.end(), imagePoints.rbegin() + 1, imagePoints.rend());
        add(muscle, curveOf(through, head.from.support, image.from.support), draft.row);
      } else {
        add(muscle, curveOf(points, head.from.support, head.to.support), draft.row);
        add(muscle, curveOf(imagePoints, image.from.support, image.to.support), draft.row);
      }
    }
    if (muscle.curves.empty()) return std::nullopt;
    addAttachments(muscle, draft, false);
    return muscle;
  }

  // --- images of twins
  // ----------------------------------------------------------------------------

  std::optional<model::Tissue> imageOf(const Draft& draft, std::size_t row) {
    model::Tissue muscle = named(row);
    for (const Head& head : draft.heads) {
      const Head image = imageOf(head);
      add(muscle,
          curveOf(imageOf(rounded(controlPoints(head.band, space_)), head, image),
                  image.from.support, image.to.support),
          row);
    }
    if (muscle.curves.empty()) return std::nullopt;
    addAttachments(muscle, draft, true);
    return muscle;
  }

  [[nodiscard]] Seat imageOf(const Seat& seat) const {
    Seat out = seat;
    out.at = around_.mirror->image(seat.at);
    if (seat.bone < 0) return out;
    AttachmentSite site{.muscle = {}, .bone = {}, .at = out.at, .patchFile = {}};
    site.bone = mirroredName(seat.support.name).value_or(seat.support.name);
    return seatOf(site, around_.bones, space_, around_.diagonal);
  }

  [[nodiscard]] Head imageOf(const Head& head) const {
    Head out{head.plan, imageOf(head.from), imageOf(head.to), head.band};
    for (Vector3& p : out.band.points) p = around_.mirror->image(p);
    for (Vector3& p : out.band.guide) p = around_.mirror->image(p);
    out.band.planeNormal = -head.band.planeNormal;
    out.band.points.front() = out.from.at;
    out.band.points.back() = out.to.at;
    return out;
  }

  // The mirrored control points between the image's own ends where they do, else settled anew
  [[nodiscard]] std::vector<Vector3> imageOf(std::vector<Vector3> points, const Head& head,
                                             const Head& image) const {
    for (Vector3& p : points) p = around_.mirror->image(p);
    points.front() = image.from.at;
    points.back() = image.to.at;
    points = rounded(std::move(points));
    constexpr double kWorse = 0.25;  // of the clearance
    const double clearance = head.band.clearance;
    const mesh::Spline spline(points);
    const auto samples = spline.sample(0.5 * clearance);
    const auto roomAt = [&](std::size_t k, const Vector3& p) {
      const double s = spline.lengthTo(samples.u[k]);
      const double wanted = clearance * easeNearEnd(std::min(s, spline.length() - s), clearance);
      return std::pair(space_.room(p, wanted), wanted);
    };
    for (std::size_t k = 0; k < samples.u.size(); ++k) {
      const auto [room, wanted] = roomAt(k, samples.point[k]);
      const double twins = roomAt(k, around_.mirror->image(samples.point[k])).first;
      if (room >= std::min(twins, wanted) - kWorse * clearance) continue;
      Band band = image.band;
      settleNearby(band, space_);
      return rounded(controlPoints(band, space_));
    }
    return points;
  }

  // --- attachments
  // --------------------------------------------------------------------------------

  [[nodiscard]] model::Tissue named(std::size_t row) const {
    return {.name = table_[row].muscle,
            .kind = model::Tissue::Kind::Muscle,
            .side = sideFrom(table_[row].muscle)};
  }

  // The table's own sites of the muscle; roles where the table is silent are those of the curves
  void addAttachments(model::Tissue& muscle, const Draft& draft, bool image) const {
    const std::size_t row = image ? rowOf(muscle) : draft.row;
    for (const AttachmentSite& site : table_[row].sites) {
      if (around_.mirror && !around_.keepsBothSides &&
          around_.mirror->height(site.at) <= -rel(kOnPlaneRel))
        continue;
      const Seat seat = seatOf(site, around_.bones, space_, around_.diagonal);
      Attachment attachment{site.role, seat.support, site.at, std::nullopt};
      if (attachment.role == Attachment::Role::Unknown) attachment.role = roleIn(draft, site.at);
      if (!site.patchFile.empty())
        attachment.patch = model::MeshRef{.file = site.patchFile, .part = {}, .unit = {}};
      muscle.attachments.push_back(std::move(attachment));
    }
  }

  [[nodiscard]] std::size_t rowOf(const model::Tissue& muscle) const {
    return static_cast<std::size_t>(std::ranges::find(table_, muscle.name, &MuscleSites::muscle) -
                                    table_.begin());
  }

  [[nodiscard]] Attachment::Role roleIn(const Draft& draft, const Vector3& at) const {
    const auto isHere = [&](std::size_t site) {
      if (site >= draft.sites.size()) return false;
      const Vector3& there = draft.sites[site].at;
      return there == at ||
             (around_.mirror && (around_.mirror->image(there) - at).norm() < rel(0.01));
    };
    for (const Head& head : draft.heads) {
      if (isHere(head.plan.from)) return Attachment::Role::Origin;
      if (isHere(head.plan.to)) return Attachment::Role::Insertion;
    }
    return Attachment::Role::Unknown;
  }
};

}  // namespace

std::vector<Vector3> bentCurve(const Vector3& from, const Vector3& to, const Surroundings& around) {
  if (from == to) return {from, to};
  const FreeSpace space(around.skin, around.bones);
  Band band = bandThrough(from, {}, to, around.diagonal);
  settle(band, space);
  return controlPoints(band, space);
}

Placement placementOf(const mesh::Spline& curve, const Surroundings& around) {
  constexpr int kSamples = 200;
  const double tolerance = kPlacedRel * around.diagonal;
  Placement out;
  for (int k = 0; k <= kSamples; ++k) {
    const Vector3 p = curve.at(curve.parameterAt(curve.length() * k / kSamples));
    if (!around.skin.inside(p) && around.skin.distance(p) > 1e-6 * around.diagonal)
      out.outside += 1.0 / (kSamples + 1);
    const bool within = std::ranges::any_of(around.bones, [&](const BoneSurface& bone) {
      return bone.solid && bone.distanceToBox(p) == 0.0 && bone.solid->inside(p) &&
             bone.solid->distance(p) > tolerance;
    });
    if (within) out.inBone += 1.0 / (kSamples + 1);
  }
  return out;
}

Result<FirstMuscles> firstMuscles(const std::vector<MuscleSites>& table, const Surroundings& around,
                                  RunContext& run) {
  return FirstCurves(table, around, run).make();
}

}  // namespace ecorche::authoring
