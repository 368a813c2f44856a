#include <ecorche/core/contract.h>
#include <ecorche/core/parallel.h>
#include <ecorche/tissue/curve_trace.h>
#include <ecorche/tissue/nearest_boundary.h>
#include <ecorche/tissue/nearest_samples.h>
#include <ecorche/tissue/piece_rows.h>

#include <algorithm>
#include <cmath>
#include <optional>

namespace ecorche::tissue {

using domain::BoundaryTag;
using domain::Domain;
using mesh::Vector3;

namespace {

// A curve with its place in the list, and all that became of it.
struct Job {
  std::size_t tissue = 0;
  std::size_t curve = 0;
  std::vector<CoreSample> samples;
  std::vector<NearCurve> nearCurves;  // samples counted within the job
  Findings findings;
  double covered = 0.0;  // [m]
  double length = 0.0;   // [m]
  std::optional<Error> error;
};

std::string nameOf(const CurveTissue& tissue, std::size_t curve) {
  const std::string& own = tissue.curves[curve].name;
  const std::string what = fmt::format("\"{}\"", tissue.name);
  if (!own.empty()) return fmt::format("{}, curve {} ({})", what, curve + 1, own);
  return tissue.curves.size() == 1 ? what : fmt::format("{}, curve {}", what, curve + 1);
}

std::string whatIs(const BoundaryTag& tag, const Domain& domain) {
  const auto named = [&](const std::vector<std::string>& names, const char* what) {
    const auto i = static_cast<std::size_t>(tag.index);
    return i < names.size() ? fmt::format("{} \"{}\"", what, names[i]) : std::string(what);
  };
  switch (tag.kind) {
    case BoundaryTag::Kind::Skin:
      return "the skin";
    case BoundaryTag::Kind::Bone:
      return named(domain.boneNames, "bone");
    case BoundaryTag::Kind::CutPlane:
      return named(domain.cutPlaneNames, "cut plane");
    case BoundaryTag::Kind::Obstacle:
      return "an obstacle";
    case BoundaryTag::Kind::Cavity:
      return "a cavity";
  }
  return "the boundary";
}

// A gap is the skin's where no end of it lies on anything else.
bool leavesThroughSkin(const CurveGap& gap) {
  const auto isSkin = [](const std::optional<BoundaryTag>& tag) {
    return !tag || tag->kind == BoundaryTag::Kind::Skin;
  };
  return isSkin(gap.exit) && isSkin(gap.entry);
}

// The point of a gap that lies farthest outside, where it is farther than the tolerance.
struct Outlier {
  Vector3 point;
  double distance;
};
std::optional<Outlier> farthestOutside(const Domain& domain, const mesh::Spline& spline,
                                       const CurveGap& gap) {
  constexpr int kSamples = 16;
  const double tolerance = kOutsideTolerance * domain.skinDiagonal;
  std::optional<Outlier> worst;
  for (int k = 0; k <= kSamples; ++k) {
    const Vector3 p = spline.at(gap.u0 + (gap.u1 - gap.u0) * k / kSamples);
    // Cheap bound first: the ends of the gap lie on the boundary
    double bound = std::numeric_limits<double>::infinity();
    if (gap.exit) bound = std::min(bound, (p - spline.at(gap.u0)).norm());
    if (gap.entry) bound = std::min(bound, (p - spline.at(gap.u1)).norm());
    if (bound <= tolerance || (worst && bound <= worst->distance)) continue;
    const double distance = nearestOnBoundary(domain, p).distance;
    if (distance > tolerance && (!worst || distance > worst->distance))
      worst = Outlier{p, distance};
  }
  return worst;
}

void judgeGaps(const Domain& domain, const CurveTissue& tissue, const CurveWalk& walk, Job& job) {
  const mesh::Spline& spline = tissue.curves[job.curve].spline;
  const std::string who = nameOf(tissue, job.curve);
  for (const CurveGap& gap : walk.gaps) {
    const double lost = spline.lengthTo(gap.u1) - spline.lengthTo(gap.u0);
    const Vector3 middle = spline.at(0.5 * (gap.u0 + gap.u1));
    if (leavesThroughSkin(gap)) {
      const auto outlier = farthestOutside(domain, spline, gap);
      if (!outlier) continue;
      job.error = Error{
          ErrorCode::CurveOutsideSkin,
          fmt::format(
              "{} leaves the skin by {:.3g} mm, at most {:.2g} mm are allowed; move its control "
              "points inside",
              who, 1e3 * outlier->distance, 1e3 * kOutsideTolerance * domain.skinDiagonal),
          {.object = tissue.name, .point = outlier->point}};
      return;
    }
    // Ends in bone are how muscles attach; what counts is how much of the curve is gone
    const BoundaryTag& tag = gap.exit ? *gap.exit : *gap.entry;
    const double share = job.length > 0.0 ? lost / job.length : 0.0;
    if (share < 0.01) continue;
    job.findings.push_back(
        {share > 0.1 ? Severity::Warning : Severity::Note, "curve-lost", tissue.name,
         fmt::format("{}: {:.1f} mm ({:.0f} %) lie inside {} and pull on nothing", who, 1e3 * lost,
                     1e2 * share, whatIs(tag, domain)),
         middle, lost});
  }
}

void traceOne(const CurveWalker& walker, const Domain& domain, const CurveTissue& tissue,
              const TissueOptions& options, Job& job) {
  const TissueCurve& curve = tissue.curves[job.curve];
  if (curve.spline.points().size() < 2) {
    job.error = Error{
        ErrorCode::ZeroLengthCurve,
        fmt::format("{} has no length; draw it again or delete it", nameOf(tissue, job.curve)),
        {.object = tissue.name}};
    return;
  }
  EC_REQUIRE_EQ(curve.values.size(), curve.spline.points().size());
  job.length = curve.spline.length();
  const CurveWalk walk = walker.walk(curve.spline);
  if (walk.pieces.empty()) {
    const Vector3 middle = curve.spline.at(0.5 * curve.spline.lastParameter());
    job.error =
        Error{ErrorCode::CurveOutsideDomain,
              fmt::format(
                  "{} lies nowhere between skin and bones; move its control points into the flesh",
                  nameOf(tissue, job.curve)),
              {.object = tissue.name, .point = middle}};
    return;
  }
  judgeGaps(domain, tissue, walk, job);
  if (job.error) return;

  const double rho = coreRadius(tissue, options, domain);
  std::vector<PieceRows> made(walk.pieces.size());
  parallelFor(
      std::ssize(made),
      [&](std::int64_t i) {
        made[static_cast<std::size_t>(i)] =
            rowsOfPiece(walker, domain, curve.spline, walk.pieces[static_cast<std::size_t>(i)],
                        TissueId(kFirstMuscle.value + static_cast<std::int64_t>(job.tissue)),
                        static_cast<std::int32_t>(job.curve), rho, options.alpha);
      },
      kPieceGrain);
  NearestSamples nearest;
  for (const PieceRows& piece : made) {
    job.covered += piece.length;
    nearest.add(domain, piece.well, piece.middle, static_cast<std::int32_t>(job.samples.size()));
    job.samples.insert(job.samples.end(), piece.samples.begin(), piece.samples.end());
  }
  job.nearCurves = nearest.byVertex();
}

}  // namespace

double coreRadius(const CurveTissue& tissue, const TissueOptions& options, const Domain& domain) {
  return tissue.coreRadius.value_or(options.coreRadius.value_or(0.001 * domain.skinDiagonal));
}

Result<CoreSamples> traceCurves(const Domain& domain, const std::vector<CurveTissue>& tissues,
                                const TissueOptions& options, RunContext& run) {
  if (run.cancelled()) return fail(ErrorCode::Cancelled, "cancelled while tracing curves");
  const CurveWalker walker(domain);
  return traceCurves(walker, domain, tissues, options, run);
}

struct KeptTraces::Entry {
  // All that a trace depends on, beside the domain
  std::string name;  // in messages
  std::vector<Vector3> points;
  double rho = 0.0;
  std::optional<double> alpha;

  Job job;

  [[nodiscard]] bool isOf(const Entry& other) const {
    return name == other.name && points == other.points && rho == other.rho && alpha == other.alpha;
  }
};

KeptTraces::KeptTraces() = default;
KeptTraces::KeptTraces(KeptTraces&&) noexcept = default;
KeptTraces& KeptTraces::operator=(KeptTraces&&) noexcept = default;
KeptTraces::~KeptTraces() = default;

Result<CoreSamples> traceCurves(const CurveWalker& walker, const Domain& domain,
                                const std::vector<CurveTissue>& tissues,
                                const TissueOptions& options, RunContext& run) {
  KeptTraces none;
  return traceCurves(walker, domain, tissues, options, run, none);
}

Result<CoreSamples> traceCurves(const CurveWalker& walker, const Domain& domain,
                                const std::vector<CurveTissue>& tissues,
                                const TissueOptions& options, RunContext& run, KeptTraces& kept) {
  const Stage stage(run, "curves");
  std::vector<KeptTraces::Entry> entries;
  std::vector<std::size_t> toTrace;
  for (std::size_t i = 0; i < tissues.size(); ++i) {
    if (tissues[i].curves.empty()) {
      return fail(ErrorCode::MuscleWithoutCurve,
                  fmt::format("{} has no curve; draw one or delete it", tissues[i].name),
                  {.object = tissues[i].name});
    }
    for (std::size_t c = 0; c < tissues[i].curves.size(); ++c) {
      KeptTraces::Entry entry{nameOf(tissues[i], c), tissues[i].curves[c].spline.points(),
                              coreRadius(tissues[i], options, domain), options.alpha, Job{}};
      const auto known = std::ranges::find_if(
          kept.entries_, [&](const KeptTraces::Entry& e) { return e.isOf(entry); });
      if (known != kept.entries_.end()) {
        entry.job = known->job;
        for (CoreSample& s : entry.job.samples) {
          s.tissue = TissueId(kFirstMuscle.value + static_cast<std::int64_t>(i));
          s.curve = static_cast<std::int32_t>(c);
        }
      } else {
        toTrace.push_back(entries.size());
      }
      entry.job.tissue = i;
      entry.job.curve = c;
      entries.push_back(std::move(entry));
    }
  }
  parallelFor(
      static_cast<std::int64_t>(toTrace.size()),
      [&](std::int64_t k) {
        Job& job = entries[toTrace[static_cast<std::size_t>(k)]].job;
        if (!run.cancelled()) traceOne(walker, domain, tissues[job.tissue], options, job);
      },
      1);
  if (run.cancelled()) return fail(ErrorCode::Cancelled, "cancelled while tracing curves");
  kept.entries_ = std::move(entries);

  CoreSamples out;
  std::vector<double> covered(tissues.size(), 0.0);
  std::vector<double> length(tissues.size(), 0.0);
  for (const KeptTraces::Entry& entry : kept.entries_) {
    const Job& job = entry.job;
    if (job.error) return tl::unexpected<Error>(*job.error);
    const auto before = static_cast<std::int32_t>(out.samples.size());
    for (NearCurve near : job.nearCurves) {
      near.sample += before;
      out.nearCurves.push_back(near);
    }
    out.samples.insert(out.samples.end(), job.samples.begin(), job.samples.end());
    out.findings.insert(out.findings.end(), job.findings.begin(), job.findings.end());
    covered[job.tissue] += job.covered;
    length[job.tissue] += job.length;
  }
  for (std::size_t i = 0; i < tissues.size(); ++i) {
    out.coveredShare.push_back(length[i] > 0.0 ? std::min(1.0, covered[i] / length[i]) : 0.0);
  }
  return out;
}

}  // namespace ecorche::tissue
