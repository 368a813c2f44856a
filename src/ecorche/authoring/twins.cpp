#include <ecorche/authoring/muscle_heads.h>
#include <ecorche/authoring/names.h>
#include <ecorche/authoring/twins.h>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <unordered_map>

namespace ecorche::authoring {

namespace {

constexpr double kSamePlaceRel = 0.02;  // of the diagonal
constexpr double kOnPlaneRel = 1e-3;
constexpr double kTellsRel = 2e-4;  // by which twins' heights differ at least

AttachmentSite imageOf(const AttachmentSite& site, const Mirror& mirror) {
  AttachmentSite out = site;
  out.at = mirror.image(site.at);
  out.bone = mirroredName(site.bone).value_or(site.bone);
  out.patchFile.clear();
  return out;
}

bool isThere(const AttachmentSite& site, const std::vector<AttachmentSite>& sites,
             double diagonal) {
  return std::ranges::any_of(sites, [&](const AttachmentSite& other) {
    return boneKind(other.bone) == boneKind(site.bone) &&
           (other.at - site.at).norm() < kSamePlaceRel * diagonal;
  });
}

double meanHeight(const MuscleSites& muscle, const Mirror& mirror) {
  double sum = 0.0;
  for (const AttachmentSite& site : muscle.sites) sum += mirror.height(site.at);
  return sum / static_cast<double>(muscle.sites.size());
}

}  // namespace

std::vector<std::optional<std::size_t>> twinsIn(const std::vector<MuscleSites>& table) {
  std::unordered_map<std::string, std::size_t> byName;
  for (std::size_t k = 0; k < table.size(); ++k) byName.emplace(bareName(table[k].muscle), k);
  std::vector<std::optional<std::size_t>> out(table.size());
  for (std::size_t k = 0; k < table.size(); ++k) {
    const auto name = mirroredName(table[k].muscle);
    const auto twin = name ? byName.find(bareName(*name)) : byName.end();
    if (twin != byName.end() && twin->second != k) out[k] = twin->second;
  }
  return out;
}

std::vector<MuscleSites> withTwinSites(const std::vector<MuscleSites>& table, const Mirror& mirror,
                                       double diagonal, Findings& findings) {
  const auto twins = twinsIn(table);
  std::vector<MuscleSites> out = table;
  for (std::size_t k = 0; k < table.size(); ++k) {
    if (!twins[k]) continue;
    std::string given;
    for (const AttachmentSite& site : table[*twins[k]].sites) {
      const AttachmentSite image = imageOf(site, mirror);
      if (isThere(image, table[k].sites, diagonal)) continue;
      out[k].sites.push_back(image);
      out[k].sites.back().muscle = table[k].muscle;
      given += (given.empty() ? "" : ", ") + image.bone;
    }
    if (given.empty()) continue;
    findings.push_back(
        {Severity::Note, "twin-sites", table[k].muscle,
         fmt::format("{} has no attachment where {} has one; taken over mirrored: {}",
                     table[k].muscle, table[*twins[k]].muscle, given),
         out[k].sites.back().at});
  }
  return out;
}

std::vector<bool> onSecondSide(const std::vector<MuscleSites>& table, const Mirror& mirror,
                               double diagonal) {
  const auto twins = twinsIn(table);
  std::vector<bool> out;
  for (std::size_t k = 0; k < table.size(); ++k) {
    const double own = meanHeight(table[k], mirror);
    const double other = twins[k] ? meanHeight(table[*twins[k]], mirror) : own;
    const bool tells = std::abs(own - other) > kTellsRel * diagonal;
    out.push_back(tells ? own < other : own < -kOnPlaneRel * diagonal);
  }
  return out;
}

FoldedSites folded(const MuscleSites& muscle, const Mirror& mirror, double diagonal) {
  FoldedSites out;
  for (const AttachmentSite& site : muscle.sites) {
    if (mirror.height(site.at) > -kOnPlaneRel * diagonal) {
      out.sites.push_back(site);
    } else if (!out.beyond) {
      out.beyond = site;
    }
  }
  if (out.sites.empty()) return out;
  const std::vector<AttachmentSite> kept = out.sites;
  for (const AttachmentSite& site : muscle.sites) {
    if (mirror.height(site.at) > -kOnPlaneRel * diagonal) continue;
    const AttachmentSite image = imageOf(site, mirror);
    if (!isThere(image, kept, diagonal)) out.sites.push_back(image);
  }
  return out;
}

}  // namespace ecorche::authoring
