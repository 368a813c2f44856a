#include <ecorche/authoring/muscle_heads.h>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <limits>
#include <map>
#include <numeric>
#include <set>
#include <utility>

namespace ecorche::authoring {

using mesh::Vector3;
using model::Attachment;

namespace {

using Places = std::vector<std::size_t>;

// Shares of the way between the two ends
constexpr double kWideEnd = 0.35;     // an end that measures less is one place
constexpr double kThreeCurves = 0.7;  // a fan wider than this gets a curve in its middle too
constexpr double kOffTheRow = 1.5;    // spacings of a row; a bone nearer than that is one of it
constexpr double kOnlyOnce = 1.5;     // what "one bone here, a row of bones there" counts more

constexpr double kNamesakesApartRel = 0.25;  // of the diagonal, between two muscles of one name

double meanToNearest(const Places& from, const Places& to, const std::vector<Vector3>& at) {
  double sum = 0.0;
  for (std::size_t a : from) {
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t b : to) least = std::min(least, (at[a] - at[b]).norm());
    sum += least;
  }
  return sum / static_cast<double>(from.size());
}

std::pair<std::size_t, std::size_t> farthestPair(const Places& places,
                                                 const std::vector<Vector3>& at) {
  std::pair best{places.front(), places.front()};
  for (std::size_t a : places) {
    for (std::size_t b : places) {
      if ((at[a] - at[b]).norm() > (at[best.first] - at[best.second]).norm()) best = {a, b};
    }
  }
  return best;
}

double extent(const Places& places, const std::vector<Vector3>& at) {
  const auto [a, b] = farthestPair(places, at);
  return (at[a] - at[b]).norm();
}

Vector3 middleOf(const Places& places, const std::vector<Vector3>& at) {
  Vector3 sum = Vector3::Zero();
  for (std::size_t k : places) sum += at[k];
  return sum / static_cast<double>(places.size());
}

std::size_t nearestTo(const Vector3& p, const Places& places, const std::vector<Vector3>& at) {
  return *std::ranges::min_element(places, {}, [&](std::size_t k) { return (at[k] - p).norm(); });
}

using Ends = std::array<Places, 2>;

Places joined(const std::vector<Places>& kinds) {
  Places out;
  for (const Places& kind : kinds) out.insert(out.end(), kind.begin(), kind.end());
  return out;
}

// Bones of which there is one each, all of them beside rows of bones: a scapula beside ribs and
// neck.
bool isBoneAndRow(const std::vector<Places>& bones, const std::vector<Places>& rows,
                  const std::vector<Vector3>& at) {
  const auto isRow = [](const Places& kind) { return kind.size() > 2; };
  const auto isOne = [](const Places& kind) { return kind.size() == 1; };
  if (!std::ranges::all_of(bones, isOne) || !std::ranges::all_of(rows, isRow)) return false;
  double spacing = 0.0;
  std::size_t count = 0;
  for (const Places& row : rows) {
    for (std::size_t k : row) {
      Places others = row;
      std::erase(others, k);
      spacing += meanToNearest({k}, others, at);
      ++count;
    }
  }
  spacing /= static_cast<double>(count);
  const Places here = joined(bones), there = joined(rows);
  const double off = meanToNearest(here, there, at);
  return off > kOffTheRow * spacing && extent(here, at) <= off;
}

// Sites of one bone kind alone: each goes to the nearer of the two farthest apart.
Ends splitByPlace(const Places& all, const std::vector<Vector3>& at) {
  const auto [a, b] = farthestPair(all, at);
  Ends out;
  for (std::size_t k : all)
    out[(at[k] - at[a]).norm() <= (at[k] - at[b]).norm() ? 0 : 1].push_back(k);
  return out;
}

double gapBetween(const Ends& ends, const std::vector<Vector3>& at) {
  return std::min(meanToNearest(ends[0], ends[1], at), meanToNearest(ends[1], ends[0], at));
}

// Bones that have sites of both ends.
int bonesWithBoth(const Ends& ends, const std::vector<int>& bones) {
  std::set<int> first, both;
  for (std::size_t k : ends[0]) first.insert(bones[k]);
  for (std::size_t k : ends[1]) {
    if (bones[k] >= 0 && first.contains(bones[k])) both.insert(bones[k]);
  }
  return static_cast<int>(both.size());
}

/// @param bones  that the sites sit on, -1: none
Ends endsOf(const std::vector<AttachmentSite>& sites, const std::vector<Vector3>& at,
            const std::vector<int>& bones) {
  using Role = Attachment::Role;
  Places all(sites.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  const auto any = [&](Role role) {
    return std::ranges::find(sites, role, &AttachmentSite::role) != sites.end();
  };
  if (any(Role::Origin) && any(Role::Insertion)) {
    Ends out;
    for (std::size_t k : all) {
      if (sites[k].role != Role::Unknown) out[sites[k].role == Role::Origin ? 0 : 1].push_back(k);
    }
    return out;
  }

  std::map<std::string, Places> byKind;
  for (std::size_t k : all) byKind[boneKind(sites[k].bone)].push_back(k);
  std::vector<Places> kinds;
  for (auto& [kind, places] : byKind) kinds.push_back(std::move(places));
  constexpr std::size_t kMostKinds = 12;
  if (kinds.size() == 1 || kinds.size() > kMostKinds) return splitByPlace(all, at);

  // Every way to part the kinds in two; the first one stays on the first side
  Ends best;
  double widest = -1.0;
  int fewest = std::numeric_limits<int>::max();
  for (std::size_t choice = 1; choice < std::size_t{1} << (kinds.size() - 1); ++choice) {
    std::array<std::vector<Places>, 2> side;
    for (std::size_t k = 0; k < kinds.size(); ++k)
      side[k == 0 ? 0 : (choice >> (k - 1)) & 1U].push_back(kinds[k]);
    const Ends ends{joined(side[0]), joined(side[1])};
    const double there = meanToNearest(ends[0], ends[1], at);
    const double back = meanToNearest(ends[1], ends[0], at);
    const int both = bonesWithBoth(ends, bones);
    double gap = gapBetween(ends, at);
    if (isBoneAndRow(side[0], side[1], at) || isBoneAndRow(side[1], side[0], at))
      gap = kOnlyOnce * 0.5 * (there + back);
    if (both > fewest || (both == fewest && gap <= widest)) continue;
    fewest = both;
    widest = gap;
    best = ends;
  }
  for (Places& places : best) std::ranges::sort(places);
  return best;
}

// How one end of a muscle is shaped, seen from the other.
struct End {
  Places picks;  ///< where curves start: one, or two or three side by side
  Places along;  ///< of a chain: the others, from the far end on
};

End shaped(const Places& places, const Vector3& other, const std::vector<Vector3>& at) {
  const Vector3 middle = middleOf(places, at);
  const double way = (other - middle).norm();
  const auto [a, b] = farthestPair(places, at);
  const Vector3 wide = at[b] - at[a];
  if (places.size() == 1 || way == 0.0 || wide.norm() < kWideEnd * way)
    return {{nearestTo(middle, places, at)}, {}};

  const Vector3 towards = (other - middle) / way;
  const auto advance = [&](std::size_t k) { return at[k].dot(towards); };
  const double onWay = std::abs(wide.dot(towards));
  if (onWay >= (wide - wide.dot(towards) * towards).norm()) {
    Places chain = places;
    std::ranges::stable_sort(chain, {}, advance);
    return {{chain.front()}, {chain.begin() + 1, chain.end()}};
  }
  End fan{{a, b}, {}};
  if (places.size() > 2 && wide.norm() > kThreeCurves * way) {
    const std::size_t between = nearestTo(0.5 * (at[a] + at[b]), places, at);
    if (between != a && between != b) fan.picks.insert(fan.picks.begin() + 1, between);
  }
  return fan;
}

}  // namespace

std::string boneKind(std::string_view bone) {
  static constexpr std::array<std::string_view, 14> kAside = {
      "l", "r", "left", "right", "i", "ii", "iii", "iv", "v", "vi", "vii", "viii", "ix", "x"};
  std::string out, word;
  const auto finish = [&] {
    if (std::ranges::find(kAside, word) == kAside.end()) out += word;
    word.clear();
  };
  for (const char c : bone) {
    const auto letter = static_cast<unsigned char>(c);
    if (std::isalpha(letter) != 0 || letter >= 0x80U) {
      word += static_cast<char>(std::tolower(letter));
    } else {
      finish();
    }
  }
  finish();
  return out.empty() ? std::string(bone) : out;
}

std::vector<MuscleSites> partedMuscles(const std::vector<MuscleSites>& table, double diagonal,
                                       Findings& findings) {
  std::vector<MuscleSites> out;
  for (const MuscleSites& muscle : table) {
    out.push_back(muscle);
    std::vector<Vector3> at;
    for (const AttachmentSite& site : muscle.sites) at.push_back(site.at);
    const std::vector<int> unknown(at.size(), -1);
    if (at.size() < 4) continue;
    const Ends ends = endsOf(muscle.sites, at, unknown);
    const double gap = gapBetween(ends, at);
    if (gap < kNamesakesApartRel * diagonal) continue;
    const auto isMuscle = [&](const Places& places) {
      constexpr double kLong = 0.35;  // of the gap between the two
      std::vector<AttachmentSite> sites;
      std::vector<Vector3> there;
      for (std::size_t k : places) {
        sites.push_back(muscle.sites[k]);
        there.push_back(at[k]);
      }
      const bool severalKinds = std::ranges::any_of(sites, [&](const AttachmentSite& site) {
        return boneKind(site.bone) != boneKind(sites.front().bone);
      });
      return severalKinds && gapBetween(endsOf(sites, there, unknown), there) > kLong * gap;
    };
    if (ends[0].size() < 2 || ends[1].size() < 2 || !isMuscle(ends[0]) || !isMuscle(ends[1]))
      continue;

    MuscleSites &first = out.back(), second{muscle.muscle + "_2", {}};
    first.sites.clear();
    for (std::size_t k = 0; k < muscle.sites.size(); ++k) {
      const bool isFirst = std::ranges::find(ends[0], k) != ends[0].end();
      (isFirst ? first : second).sites.push_back(muscle.sites[k]);
    }
    findings.push_back({Severity::Note, "two-muscles", muscle.muscle,
                        fmt::format("the attachments of {} are two groups {:.0f} mm apart; the "
                                    "second one became {}",
                                    muscle.muscle, 1e3 * gap, second.muscle),
                        second.sites.front().at});
    out.push_back(std::move(second));
  }
  return out;
}

std::vector<HeadPlan> planHeads(const std::vector<AttachmentSite>& sites,
                                const std::vector<Seat>& seats, const Vector3& centre) {
  if (sites.size() < 2) return {};
  std::vector<Vector3> at;
  std::vector<int> bones;
  for (const Seat& seat : seats) {
    at.push_back(seat.at);
    bones.push_back(seat.bone);
  }
  const Ends ends = endsOf(sites, at, bones);
  if (ends[0].empty() || ends[1].empty()) return {};
  std::array<Vector3, 2> middle{middleOf(ends[0], at), middleOf(ends[1], at)};
  std::array<End, 2> shape{shaped(ends[0], middle[1], at), shaped(ends[1], middle[0], at)};

  const bool known = std::ranges::all_of(
      ends[0], [&](std::size_t k) { return sites[k].role == Attachment::Role::Origin; });
  const auto remoteness = [&](std::size_t side) {
    return (middleOf(shape[side].picks, at) - centre).norm();
  };
  if (!known && remoteness(1) < remoteness(0)) std::swap(shape[0], shape[1]);

  // Fans on both sides run side by side: the second is turned so that its curves do not cross
  End &origin = shape[0], &insertion = shape[1];
  if (origin.picks.size() > 1 && insertion.picks.size() > 1) {
    const Vector3 a = at[origin.picks.back()] - at[origin.picks.front()];
    const Vector3 b = at[insertion.picks.back()] - at[insertion.picks.front()];
    if (a.dot(b) < 0.0) std::ranges::reverse(insertion.picks);
  }
  const std::size_t count = std::max(origin.picks.size(), insertion.picks.size());
  const auto pick = [&](const Places& picks, std::size_t k) {
    if (picks.size() == count) return picks[k];
    // Two curves for three, or one for all
    return k + 1 == count ? picks.back() : k == 0 ? picks.front() : picks[picks.size() / 2];
  };
  std::vector<HeadPlan> out;
  for (std::size_t k = 0; k < count; ++k) {
    HeadPlan head{pick(origin.picks, k), pick(insertion.picks, k), {}};
    if (head.from == head.to || at[head.from] == at[head.to]) continue;
    if (count == 1) {
      head.along = origin.along;
      head.along.insert(head.along.end(), insertion.along.rbegin(), insertion.along.rend());
    }
    out.push_back(std::move(head));
  }
  return out;
}

}  // namespace ecorche::authoring
