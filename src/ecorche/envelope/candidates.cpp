#include <ecorche/core/contract.h>
#include <ecorche/envelope/candidates.h>

#include <algorithm>
#include <bit>

namespace ecorche::envelope {
namespace {

using OutColumns = std::vector<std::int32_t>;

/// Tets around a simplex, and how many of them strike each column.
struct Star {
  std::int32_t tets = 0;
  std::map<std::int32_t, std::int32_t> strikes;
};

template <int N, class Visit>
void forEachSubset(std::array<std::int32_t, 4> tet, const Visit& visit) {
  std::ranges::sort(tet);
  for (unsigned mask = 1; mask < 16; ++mask) {
    if (std::popcount(mask) != N) continue;
    std::array<std::int32_t, N> key{};
    for (int c = 0, n = 0; c < 4; ++c) {
      if (mask >> c & 1) key[n++] = tet[c];
    }
    visit(key);
  }
}

std::array<std::int32_t, 4> corners(const mesh::Tets& T, Eigen::Index t) {
  return {T(t, 0), T(t, 1), T(t, 2), T(t, 3)};
}

template <int N>
std::map<std::array<std::int32_t, N>, OutColumns> outEverywhere(
    const mesh::Tets& T, const std::vector<std::uint8_t>& touched,
    const std::map<std::int32_t, OutColumns>& tets) {
  std::map<std::array<std::int32_t, N>, Star> stars;
  for (const auto& [t, columns] : tets) {
    forEachSubset<N>(corners(T, t), [&](const auto& key) {
      for (const std::int32_t c : columns) ++stars[key].strikes[c];
    });
  }
  for (Eigen::Index t = 0; t < T.rows(); ++t) {
    int marks = 0;
    for (int c = 0; c < 4; ++c) marks += touched[static_cast<std::size_t>(T(t, c))];
    if (marks < N) continue;
    forEachSubset<N>(corners(T, t), [&](const auto& key) {
      if (const auto star = stars.find(key); star != stars.end()) ++star->second.tets;
    });
  }
  std::map<std::array<std::int32_t, N>, OutColumns> out;
  for (const auto& [key, star] : stars) {
    for (const auto& [column, count] : star.strikes) {
      if (count == star.tets) out[key].push_back(column);
    }
  }
  return out;
}

template <class Map, class Key>
Candidates::Columns lookUp(const Map& map, const Key& key) {
  if (map.empty()) return {};
  const auto found = map.find(key);
  return found == map.end() ? Candidates::Columns{} : Candidates::Columns(found->second);
}

}  // namespace

Candidates::Candidates(const mesh::Tets& T, std::int32_t fieldCount, bool fatCompetes,
                       std::span<const TissueInTet> struck)
    : first_(fatCompetes ? 0 : 1), end_(fieldCount) {
  EC_REQUIRE(first_ < end_);
  if (struck.empty()) return;
  for (const TissueInTet& s : struck) {
    EC_REQUIRE(s.tet >= 0 && s.tet < T.rows());
    EC_REQUIRE(s.tissue >= kFat && s.tissue.value <= fieldCount);
    tets_[s.tet].push_back(s.tissue.value - kFat.value);
  }
  std::vector<std::uint8_t> touched(static_cast<std::size_t>(T.maxCoeff()) + 1, 0);
  for (auto& [t, columns] : tets_) {
    std::ranges::sort(columns);
    columns.erase(std::unique(columns.begin(), columns.end()), columns.end());
    EC_REQUIRE(static_cast<std::int32_t>(columns.size()) < end_ - first_);
    for (int c = 0; c < 4; ++c) touched[static_cast<std::size_t>(T(t, c))] = 1;
  }
  vertices_ = outEverywhere<1>(T, touched, tets_);
  edges_ = outEverywhere<2>(T, touched, tets_);
  faces_ = outEverywhere<3>(T, touched, tets_);
}

Candidates::Columns Candidates::outAtVertex(std::int32_t v) const {
  return lookUp(vertices_, std::array{v});
}
Candidates::Columns Candidates::outOnEdge(std::int32_t a, std::int32_t b) const {
  return lookUp(edges_, std::array{a, b});
}
Candidates::Columns Candidates::outOnFace(std::int32_t a, std::int32_t b, std::int32_t c) const {
  return lookUp(faces_, std::array{a, b, c});
}
Candidates::Columns Candidates::outInTet(std::int32_t t) const { return lookUp(tets_, t); }

}  // namespace ecorche::envelope
