#include <ecorche/core/contract.h>
#include <ecorche/render/image.h>
#include <ecorche/render/palette.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>
#include <unordered_map>

namespace ecorche::render {
namespace {

using Matrix3 = std::array<std::array<double, 3>, 3>;

// Machado, Oliveira, Fernandes 2009, severity 1.0, on linear RGB.
constexpr Matrix3 kNoRedCones{{{0.152286, 1.052583, -0.204868},
                               {0.114503, 0.786281, 0.099216},
                               {-0.003882, -0.048116, 1.051998}}};
constexpr Matrix3 kNoGreenCones{{{0.367322, 0.860646, -0.227968},
                                 {0.280085, 0.672501, 0.047413},
                                 {-0.011820, 0.042940, 0.968881}}};

Rgba seenBy(const Matrix3& m, const Rgba& c) {
  Rgba out{0.0f, 0.0f, 0.0f, 1.0f};
  for (std::size_t i = 0; i < 3; ++i) {
    double sum = 0.0;
    for (std::size_t j = 0; j < 3; ++j) sum += m[i][j] * static_cast<double>(c[j]);
    out[i] = static_cast<float>(std::clamp(sum, 0.0, 1.0));
  }
  return out;
}

double labDistance(const Rgba& a, const Rgba& b) {
  const OkLab p = okLabFromLinear(a);
  const OkLab q = okLabFromLinear(b);
  return std::hypot(p[0] - q[0], p[1] - q[1], p[2] - q[2]);
}

std::array<double, 3> unclampedLinear(const OkLab& lab) {
  const double l = std::pow(lab[0] + 0.3963377774 * lab[1] + 0.2158037573 * lab[2], 3.0);
  const double m = std::pow(lab[0] - 0.1055613458 * lab[1] - 0.0638541728 * lab[2], 3.0);
  const double s = std::pow(lab[0] - 0.0894841775 * lab[1] - 1.2914855480 * lab[2], 3.0);
  return {4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s,
          -1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s,
          -0.0041960863 * l - 0.7034186147 * m + 1.7076147010 * s};
}

bool onScreen(const OkLab& lab) {
  for (const double c : unclampedLinear(lab))
    if (c < 0.0 || c > 1.0) return false;
  return true;
}

OkLab fromHue(double lightness, double chroma, double hueDeg) {
  const double h = hueDeg * std::numbers::pi / 180.0;
  return {lightness, chroma * std::cos(h), chroma * std::sin(h)};
}

Rgba srgb(float r, float g, float b) {
  return {linearFromSrgb(r), linearFromSrgb(g), linearFromSrgb(b), 1.0f};
}

// What a tissue may look like. Lightness varies at every hue: that is what colour-blind eyes tell
// apart.
std::vector<Rgba> candidates(Palette palette) {
  std::vector<Rgba> out;
  const auto add = [&](double lightness, double chroma, double hueDeg) {
    const OkLab lab = fromHue(lightness, chroma, hueDeg);
    if (onScreen(lab)) out.push_back(linearFromOkLab(lab));
  };
  if (palette == Palette::Anatomical) {
    // Hue about 25 is flesh red; 43 terracotta; 56 ochre; 9 rose; 0 plum. Yellower is lighter and
    // rarer, as in printed atlases; no colour comes near bone or fat.
    for (const double lightness : {0.45, 0.52, 0.59, 0.66}) {
      add(lightness, 0.150, 27.0);
      add(lightness, 0.135, 18.0);
      add(lightness, 0.130, 35.0);
    }
    for (const double lightness : {0.60, 0.67, 0.73}) add(lightness, 0.118, 43.0);
    for (const double lightness : {0.69, 0.75}) add(lightness, 0.100, 56.0);
    for (const double lightness : {0.48, 0.57, 0.66, 0.73}) add(lightness, 0.110, 9.0);
    for (const double lightness : {0.46, 0.55}) add(lightness, 0.088, 0.0);
    for (const double lightness : {0.72, 0.77}) add(lightness, 0.080, 30.0);
  } else {
    for (const double lightness : {0.55, 0.66, 0.77})
      for (int k = 0; k < 12; ++k) add(lightness, 0.115, 25.0 + 30.0 * k + 40.0 * lightness);
  }
  return out;
}

}  // namespace

OkLab okLabFromLinear(const Rgba& c) {
  const double r = static_cast<double>(c[0]);
  const double g = static_cast<double>(c[1]);
  const double b = static_cast<double>(c[2]);
  const double l = std::cbrt(0.4122214708 * r + 0.5363325363 * g + 0.0514459929 * b);
  const double m = std::cbrt(0.2119034982 * r + 0.6806995451 * g + 0.1073969566 * b);
  const double s = std::cbrt(0.0883024619 * r + 0.2817188376 * g + 0.6299787005 * b);
  return {0.2104542553 * l + 0.7936177850 * m - 0.0040720468 * s,
          1.9779984951 * l - 2.4285922050 * m + 0.4505937099 * s,
          0.0259040371 * l + 0.7827717662 * m - 0.8086757660 * s};
}

Rgba linearFromOkLab(const OkLab& lab) {
  const auto c = unclampedLinear(lab);
  Rgba out{0.0f, 0.0f, 0.0f, 1.0f};
  for (std::size_t i = 0; i < 3; ++i) out[i] = static_cast<float>(std::clamp(c[i], 0.0, 1.0));
  return out;
}

double colourDistance(const Rgba& a, const Rgba& b) {
  const double withoutRed = labDistance(seenBy(kNoRedCones, a), seenBy(kNoRedCones, b));
  const double withoutGreen = labDistance(seenBy(kNoGreenCones, a), seenBy(kNoGreenCones, b));
  return std::min(labDistance(a, b), 1.6 * std::min(withoutRed, withoutGreen));
}

std::optional<Rgba> colourFromHex(std::string_view text) {
  if (text.size() != 7 || text[0] != '#') return std::nullopt;
  std::array<int, 3> value{};
  for (std::size_t i = 1; i < 7; ++i) {
    const char c = text[i];
    int digit = 0;
    if (c >= '0' && c <= '9')
      digit = c - '0';
    else if (c >= 'a' && c <= 'f')
      digit = c - 'a' + 10;
    else if (c >= 'A' && c <= 'F')
      digit = c - 'A' + 10;
    else
      return std::nullopt;
    value[(i - 1) / 2] = value[(i - 1) / 2] * 16 + digit;
  }
  return srgb(static_cast<float>(value[0]) / 255.0f, static_cast<float>(value[1]) / 255.0f,
              static_cast<float>(value[2]) / 255.0f);
}

std::string hexFromColour(const Rgba& linear) {
  const auto byte = [](float x) {
    return static_cast<int>(std::lround(255.0f * srgbFromLinear(std::clamp(x, 0.0f, 1.0f))));
  };
  return fmt::format("#{:02x}{:02x}{:02x}", byte(linear[0]), byte(linear[1]), byte(linear[2]));
}

namespace tint {
Rgba bone() { return srgb(0.930f, 0.890f, 0.795f); }
Rgba fat() { return srgb(0.960f, 0.885f, 0.640f); }
Rgba skin() { return srgb(0.930f, 0.720f, 0.600f); }
Rgba filler() { return srgb(0.700f, 0.625f, 0.620f); }
Rgba obstacle() { return srgb(0.560f, 0.600f, 0.660f); }
Rgba curve() { return srgb(0.110f, 0.230f, 0.420f); }
}  // namespace tint

std::vector<Rgba> tissueColours(std::int32_t count, const NeighbourPairs& neighbours,
                                Palette palette, const std::vector<std::int32_t>& twin,
                                const std::vector<std::optional<Rgba>>& fixed) {
  EC_REQUIRE(count >= 0);
  EC_REQUIRE(twin.empty() || static_cast<std::int32_t>(twin.size()) == count);
  EC_REQUIRE(fixed.empty() || static_cast<std::int32_t>(fixed.size()) == count);
  const auto n = static_cast<std::size_t>(count);
  const auto leader = [&](std::size_t i) {
    return twin.empty() || twin[i] < 0 ? i : static_cast<std::size_t>(twin[i]);
  };

  std::vector<std::set<std::size_t>> near(n);
  for (const auto& [a, b] : neighbours) {
    EC_REQUIRE(a >= 0 && a < count && b >= 0 && b < count);
    const std::size_t i = leader(static_cast<std::size_t>(a));
    const std::size_t j = leader(static_cast<std::size_t>(b));
    if (i == j) continue;
    near[i].insert(j);
    near[j].insert(i);
  }

  std::vector<Rgba> colour(n, Rgba{0.0f, 0.0f, 0.0f, 1.0f});
  std::vector<bool> done(n, false);
  for (std::size_t i = 0; i < n && !fixed.empty(); ++i)
    if (fixed[i]) {
      colour[i] = *fixed[i];
      done[i] = true;
      if (!done[leader(i)]) {
        colour[leader(i)] = *fixed[i];
        done[leader(i)] = true;
      }
    }

  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < n; ++i)
    if (leader(i) == i && !done[i]) order.push_back(i);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return near[a].size() > near[b].size(); });

  const std::vector<Rgba> choices = candidates(palette);
  std::vector<int> used(choices.size(), 0);
  constexpr double kEnough = 0.16;  // beyond this, more distance is worth less than variety
  for (const std::size_t i : order) {
    std::size_t best = 0;
    double bestScore = -1e9;
    for (std::size_t c = 0; c < choices.size(); ++c) {
      double distance = kEnough;
      for (const std::size_t j : near[i])
        if (done[j]) distance = std::min(distance, colourDistance(choices[c], colour[j]));
      const double score = distance - 0.012 * used[c];
      if (score > bestScore + 1e-12) {
        bestScore = score;
        best = c;
      }
    }
    colour[i] = choices[best];
    done[i] = true;
    ++used[best];
  }
  for (std::size_t i = 0; i < n; ++i)
    if (!done[i]) colour[i] = colour[leader(i)];
  return colour;
}

NeighbourPairs touchingTissues(const std::vector<TissueId>& label,
                               const mesh::TetNeighbours& neighbours, TissueId firstLabel) {
  EC_REQUIRE_EQ(static_cast<Eigen::Index>(label.size()), neighbours.rows());
  std::set<std::pair<std::int32_t, std::int32_t>> pairs;
  for (Eigen::Index t = 0; t < neighbours.rows(); ++t)
    for (int k = 0; k < 4; ++k) {
      const std::int32_t other = neighbours(t, k);
      if (other < 0) continue;
      const TissueId a = label[static_cast<std::size_t>(t)];
      const TissueId b = label[static_cast<std::size_t>(other)];
      if (a < b && a >= firstLabel)
        pairs.emplace(a.value - firstLabel.value, b.value - firstLabel.value);
    }
  return {pairs.begin(), pairs.end()};
}

NeighbourPairs nearSurfaces(const std::vector<const mesh::SurfaceMesh*>& meshes, double distance) {
  EC_REQUIRE(distance > 0.0);
  using Cell = std::array<std::int32_t, 3>;
  std::map<Cell, std::set<std::int32_t>> inCell;
  for (std::size_t m = 0; m < meshes.size(); ++m)
    for (Eigen::Index v = 0; v < meshes[m]->V.rows(); ++v) {
      Cell cell;
      for (Eigen::Index c = 0; c < 3; ++c)
        cell[static_cast<std::size_t>(c)] =
            static_cast<std::int32_t>(std::floor(meshes[m]->V(v, c) / distance));
      inCell[cell].insert(static_cast<std::int32_t>(m));
    }
  std::set<std::pair<std::int32_t, std::int32_t>> pairs;
  for (const auto& [cell, here] : inCell)
    for (int k = 13; k < 27; ++k) {  // each pair of cells once
      const auto there =
          inCell.find({cell[0] + k / 9 - 1, cell[1] + k / 3 % 3 - 1, cell[2] + k % 3 - 1});
      if (there == inCell.end()) continue;
      for (const std::int32_t a : here)
        for (const std::int32_t b : there->second)
          if (a != b) pairs.emplace(std::min(a, b), std::max(a, b));
    }
  return {pairs.begin(), pairs.end()};
}

std::vector<std::int32_t> sideTwins(const std::vector<std::string>& names) {
  const auto withoutSide = [](const std::string& name) {
    // Words between separators; "l", "r", "left", "right" count as one and the same
    std::string out;
    std::string word;
    const auto flush = [&] {
      if (word == "l" || word == "r" || word == "left" || word == "right") word = "~";
      out += word + " ";
      word.clear();
    };
    for (const char c : name) {
      if (c == '_' || c == ' ' || c == '.' || c == '-')
        flush();
      else
        word += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    }
    flush();
    return out;
  };
  std::unordered_map<std::string, std::int32_t> first;
  std::vector<std::int32_t> twin(names.size(), -1);
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto [at, fresh] = first.emplace(withoutSide(names[i]), static_cast<std::int32_t>(i));
    if (!fresh) twin[i] = at->second;
  }
  return twin;
}

}  // namespace ecorche::render
