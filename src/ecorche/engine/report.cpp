#include <ecorche/core/parallel.h>
#include <ecorche/engine/machine.h>
#include <ecorche/engine/report.h>
#include <ecorche/fiber/curve_tets.h>
#include <fmt/format.h>

#include <algorithm>

namespace ecorche::engine {

namespace {

constexpr double kCm2 = 1e4;
constexpr double kCm3 = 1e6;

std::string boundaryName(const domain::BoundaryTag& tag, const domain::Domain& domain) {
  const auto& names =
      tag.kind == domain::BoundaryTag::Kind::Bone ? domain.boneNames : domain.cutPlaneNames;
  const auto index = static_cast<std::size_t>(tag.index);
  return index < names.size() ? names[index] : std::string();
}

// Origin, insertion, both ("origin and insertion" would be a muscle from a bone to itself) or a
// mere contact
std::string roleOf(const model::Tissue& tissue, const std::string& name) {
  bool origin = false;
  bool insertion = false;
  for (const model::Curve& curve : tissue.curves) {
    origin = origin || curve.start.name == name;
    insertion = insertion || curve.end.name == name;
  }
  return origin ? "origin" : insertion ? "insertion" : "";
}

exchange::TissueFigures figuresOf(const model::Project& project, const Build& build,
                                  std::size_t place, const exchange::WrittenOutput& written) {
  exchange::TissueFigures out;
  const envelope::TissueSurface& surface = build.surfaces[place];
  const envelope::TissueMeasure& measure = build.measures[place];
  out.id = static_cast<std::int32_t>(place) + 1;
  out.name = surface.mesh.name;
  out.kind = "fat";
  out.file = place < written.tissueFiles.size() ? written.tissueFiles[place] : "";
  out.volumeCm3 = measure.volume * kCm3;
  out.areaCm2 = mesh::surfaceArea(surface.mesh.V, surface.mesh.F) * kCm2;
  out.components = measure.components;
  out.tets = measure.tets;
  if (place == 0) return out;

  const model::Tissue& tissue = project.tissues[curveTissuePlaces(project)[place - 1]];
  out.kind = std::string(model::word(tissue.kind));
  out.side = std::string(model::word(tissue.side));
  out.group = tissue.group;
  for (const envelope::Attachment& patch : envelope::attachmentsOf(surface)) {
    exchange::AttachmentFigures figures;
    figures.on = patch.tag.kind == domain::BoundaryTag::Kind::Bone ? "bone" : "cut-plane";
    figures.name = boundaryName(patch.tag, build.domain.domain);
    figures.role = roleOf(tissue, figures.name);
    figures.areaCm2 = patch.area * kCm2;
    figures.centroid = patch.centroid;
    out.attachments.push_back(std::move(figures));
  }
  const auto fibers = std::ranges::find_if(
      build.fibers.muscles, [&](const fiber::MuscleFibers& m) { return m.tissue.value == out.id; });
  if (fibers != build.fibers.muscles.end()) {
    out.fibers = exchange::FiberFigures{
        .lengthCm = fibers->fiberLength * 100.0,
        .lengthSdCm = fibers->fiberLengthSd * 100.0,
        .traced = static_cast<std::int64_t>(fibers->lines.size()),
        .angleToCurveDeg = fibers->angleToCurveDeg,
        .interiorExtremaShare = fibers->vertexCount > 0
                                    ? static_cast<double>(fibers->interiorExtrema) /
                                          static_cast<double>(fibers->vertexCount)
                                    : 0.0,
        .spreadShare = fibers->spreadVolumeShare};
  }
  return out;
}

exchange::QualityFigures qualityOf(const mesh::TetMesh& mesh) {
  exchange::QualityFigures out;
  const Eigen::MatrixX2d range = mesh::dihedralRangeDeg(mesh);
  out.minDihedralDeg = range.col(0).minCoeff();
  out.maxDihedralDeg = range.col(1).maxCoeff();
  constexpr std::array<double, 5> kLimits = {1.0, 5.0, 10.0, 20.0, 30.0};
  out.minDihedralHistogram.assign(kLimits.size() + 1, 0);
  for (Eigen::Index t = 0; t < range.rows(); ++t) {
    const auto bin = std::ranges::upper_bound(kLimits, range(t, 0)) - kLimits.begin();
    ++out.minDihedralHistogram[static_cast<std::size_t>(bin)];
  }
  out.smallestVolume = mesh::signedVolumes(mesh).minCoeff();
  return out;
}

exchange::EnvelopeFigures envelopeOf(const envelope::EnvelopeStats& stats, double volume) {
  double islands = 0.0;
  for (const double v : stats.islandVolume) islands += v;
  const auto share = [&](double part) { return volume > 0.0 ? part / volume : 0.0; };
  return {.newVertices = stats.newVertices,
          .clampedVertices = stats.clampedVertices,
          .repairedVertices = stats.repairedVertices,
          .rebuiltTets = stats.rebuiltTets,
          .nonPositiveAt32Bits = stats.nonPositiveRounded,
          .offLabelTets = stats.offLabelTets,
          .offLabelShare = share(stats.offLabelVolume),
          .offLabelUnexplained = stats.unexplainedOffLabelTets,
          .islands = stats.islands,
          .islandShare = share(islands),
          .fatPockets = stats.fatPockets};
}

Findings envelopeFindings(const Build& build) {
  const envelope::EnvelopeStats& stats = build.envelopeStats;
  Findings out;
  if (stats.islands > 0) {
    double volume = 0.0;
    for (const double v : stats.islandVolume) volume += v;
    out.push_back({.severity = Severity::Repaired,
                   .kind = "islands",
                   .message = fmt::format(
                       "{} pieces of muscle that touched none of their curves were given to their "
                       "neighbours, {:.3g} cm³ in all",
                       stats.islands, volume * kCm3),
                   .size = volume});
  }
  for (const TissueId lost : stats.lostTissues) {
    const std::string& name = build.tissues[static_cast<std::size_t>(lost.value - 2)].name;
    out.push_back(
        {.severity = Severity::Warning,
         .kind = "lost-tissue",
         .object = name,
         .message = fmt::format("nothing of \"{}\" holds its own curve, so nothing of it is "
                                "left: raise its tissue value",
                                name)});
  }
  if (stats.rebuiltTets > 0) {
    out.push_back(
        {.severity = Severity::Repaired,
         .kind = "tets-rebuilt",
         .message = fmt::format("the inside of {} tets of the domain was cut anew: no place "
                                "for their points gave every piece volume",
                                stats.rebuiltTets),
         .size = static_cast<double>(stats.rebuiltTets)});
  }
  return out;
}

std::vector<exchange::Check> checksOf(const Build& build) {
  std::vector<exchange::Check> out;
  const auto& stats = build.envelopeStats;
  const domain::Domain& domain = build.domain.domain;
  const domain::DomainReport& report = build.domain.report;
  const auto add = [&](std::string name, bool pass, double value, double limit,
                       std::string detail) {
    exchange::Check check;
    check.name = std::move(name);
    check.pass = pass;
    check.value = value;
    check.limit = limit;
    check.detail = std::move(detail);
    out.push_back(std::move(check));
  };

  add("surface-deviation", report.maxDeviation <= report.tolerance, report.maxDeviation,
      report.tolerance,
      fmt::format("skin and bones lie within {:.3g} mm of the input, both ways",
                  report.maxDeviation * 1e3));
  add("tets-positive", stats.nonPositiveTets == 0, static_cast<double>(stats.nonPositiveTets), 0.0,
      "output tets without positive volume");
  const double share = envelopeOf(stats, domain.volume).offLabelShare;
  add("labels-largest", share <= 5e-4 && stats.unexplainedOffLabelTets == 0, share, 5e-4,
      fmt::format("volume share of tets whose tissue is not the largest field at the centroid: {} "
                  "tets at {} clamped and {} repaired vertices of {}, or in {} islands; {} without "
                  "such a reason",
                  stats.offLabelTets, stats.clampedVertices, stats.repairedVertices,
                  stats.newVertices, stats.islands, stats.unexplainedOffLabelTets));
  double total = 0.0;
  for (const auto& m : build.measures) total += m.volume;
  const double off = domain.volume > 0.0 ? std::abs(total - domain.volume) / domain.volume : 0.0;
  add("volumes-add-up", off <= 1e-9, off, 1e-9, "sum of tissue volumes against the domain");
  const std::vector<double> inside = curveSharesInside(build);
  for (std::size_t i = 0; i < inside.size(); ++i) {
    if (build.tissues[i].filler || inside[i] >= 0.95) continue;
    exchange::Check check;
    check.name = "curves-inside";
    check.pass = false;
    check.value = inside[i];
    check.limit = 0.95;
    check.object = build.tissues[i].name;
    check.detail = fmt::format(
        "only {:.1f} % of the curve lies inside its own muscle: another curve runs too near, "
        "or the tissue value is too small",
        inside[i] * 100.0);
    out.push_back(std::move(check));
  }
  add("fields-bounded", build.fields.overshoot <= 0.05 && build.fields.undershoot <= 0.05,
      std::max(build.fields.overshoot, build.fields.undershoot), 0.05,
      "how far fields leave [0, largest value] on poor tets");
  return out;
}

}  // namespace

std::vector<double> curveSharesInside(const Build& build) {
  std::vector<std::vector<std::int32_t>> tetsOf(build.tissues.size() + 2);
  for (std::size_t t = 0; t < build.anatomy.label.size(); ++t) {
    tetsOf[static_cast<std::size_t>(build.anatomy.label[t].value)].push_back(
        static_cast<std::int32_t>(t));
  }
  std::vector<double> share(build.tissues.size(), 0.0);
  parallelFor(
      std::ssize(build.tissues),
      [&](std::int64_t i) {
        const auto at = static_cast<std::size_t>(i);
        std::vector<std::vector<mesh::Vector3>> lines;
        for (const tissue::TissueCurve& curve : build.tissues[at].curves)
          lines.push_back(curve.spline.sample(curve.spline.length() / 200).point);
        share[at] = fiber::shareInside(build.anatomy.mesh, tetsOf[at + 2], lines);
      },
      1);
  return share;
}

exchange::Report makeReport(const model::Project& project, const Build& build,
                            const exchange::WrittenOutput& written, const RunContext& run) {
  const domain::Domain& domain = build.domain.domain;
  exchange::Report out;
  out.program = "ecorche " ECORCHE_VERSION;
  out.project = project.name;
  out.sourceUnit = std::string(model::symbol(project.unit));
  out.skinDiagonal = domain.skinDiagonal;
  out.domainVolumeCm3 = domain.volume * kCm3;
  out.domainTets = domain.mesh.T.rows();
  out.domainVertices = domain.mesh.V.rows();
  out.freeVertices = domain.freeVertexCount();
  out.tets = build.anatomy.mesh.T.rows();
  out.vertices = build.anatomy.mesh.V.rows();
  for (std::size_t i = 0; i < build.surfaces.size(); ++i)
    out.tissues.push_back(figuresOf(project, build, i, written));
  const auto& counts = build.envelopeStats.tetsByTissueCount;
  for (const std::int64_t n : counts) {
    out.tissuesPerTet.push_back(static_cast<double>(n) /
                                std::max<double>(1.0, static_cast<double>(out.domainTets)));
  }
  out.envelope = envelopeOf(build.envelopeStats, domain.volume);
  out.quality = qualityOf(build.anatomy.mesh);
  out.checks = checksOf(build);
  out.references = written.references;
  const Findings cut = envelopeFindings(build);
  for (const Findings* list :
       {&build.domain.report.findings, &build.cores.findings, &cut, &build.fibers.findings}) {
    out.findings.insert(out.findings.end(), list->begin(), list->end());
  }
  out.stages = run.stageTimes();
  out.peakMemoryBytes = static_cast<std::int64_t>(peakMemory());
  out.peakWorkerMemoryBytes = static_cast<std::int64_t>(peakMemoryOfChildren());
  out.machine = thisMachine();
  return out;
}

}  // namespace ecorche::engine
