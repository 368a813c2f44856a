#include <ecorche/authoring/names.h>

#include <algorithm>
#include <cctype>
#include <set>

namespace ecorche::authoring {

namespace {

char lower(char c) { return static_cast<char>(std::tolower(static_cast<unsigned char>(c))); }
bool isLetter(char c) { return std::isalpha(static_cast<unsigned char>(c)) != 0; }
bool isUpper(char c) { return std::isupper(static_cast<unsigned char>(c)) != 0; }
bool isDigit(char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; }

std::string lowered(std::string_view text) {
  std::string out(text);
  std::ranges::transform(out, out.begin(), lower);
  return out;
}

// Takes the word off the front, whatever its case.
bool dropLead(std::string& text, std::string_view word) {
  if (!lowered(text).starts_with(word)) return false;
  text.erase(0, word.size());
  return true;
}

// Blanks and dashes as underscores, none of them at either end.
std::string joined(std::string text) {
  for (char& c : text) {
    if (c == ' ' || c == '-' || c == '\t') c = '_';
  }
  const auto blank = [](char c) { return c == '_' || c == '.'; };
  text.erase(text.begin(), std::ranges::find_if_not(text, blank));
  while (!text.empty() && blank(text.back())) text.pop_back();
  return text;
}

}  // namespace

std::string boneNameFrom(const std::filesystem::path& file) {
  const std::string stem = file.stem().string();
  std::string rest = stem;
  // "BONEScapula" is a bone called Scapula, "bones-tibia" and "bonesTibia" are tibias among bones
  constexpr std::size_t kMany = 5;
  const bool many = stem.size() == kMany ||
                    (stem.size() > kMany &&
                     (!isLetter(stem[kMany]) || (stem[kMany - 1] == 's' && isUpper(stem[kMany]))));
  if (!many || !dropLead(rest, "bones")) dropLead(rest, "bone");
  rest = joined(rest);
  return rest.empty() ? joined(stem) : rest;
}

std::string muscleNameFrom(std::string_view text) {
  std::string rest(text.substr(text.find_last_of("/\\") + 1));
  for (std::string_view suffix : {".stl", ".obj", ".ply", ".off", ".glb", ".gltf", ".fbx"}) {
    if (lowered(rest).ends_with(suffix)) rest.erase(rest.size() - suffix.size());
  }
  const std::string whole = joined(rest);
  if (!dropLead(rest, "muscle")) dropLead(rest, "musc");
  rest = joined(rest);
  // "m." and "mm." are the anatomists' musculus and musculi
  for (std::string_view lead : {"mm.", "mm_", "m.", "m_"}) {
    if (dropLead(rest, lead)) break;
  }
  rest = joined(rest);
  return rest.empty() ? whole : rest;
}

namespace {
// The last word of letters, digits and blanks behind it aside; of a name of one word nothing.
std::pair<std::size_t, std::size_t> lastWord(std::string_view name) {
  std::size_t end = name.size();
  while (end > 0 && isDigit(name[end - 1])) --end;
  while (end > 0 && !isLetter(name[end - 1])) --end;
  std::size_t begin = end;
  while (begin > 0 && isLetter(name[begin - 1])) --begin;
  return begin == 0 ? std::pair(end, end) : std::pair(begin, end);
}
}  // namespace

model::Side sideFrom(std::string_view name) {
  const auto [begin, end] = lastWord(name);
  const std::string word = lowered(name.substr(begin, end - begin));
  if (word == "l" || word == "left") return model::Side::Left;
  if (word == "r" || word == "right") return model::Side::Right;
  return model::Side::Unknown;
}

std::optional<std::string> mirroredName(std::string_view name) {
  const model::Side side = sideFrom(name);
  if (side == model::Side::Unknown) return std::nullopt;
  const auto [begin, end] = lastWord(name);
  std::string other = side == model::Side::Left ? "right" : "left";
  if (end - begin == 1) other.resize(1);
  // As the name is written: LEFT, Left or left
  for (std::size_t k = 0; k < other.size(); ++k) {
    const char like = name[begin + std::min(k, end - begin - 1)];
    if (isUpper(like)) {
      other[k] = static_cast<char>(std::toupper(static_cast<unsigned char>(other[k])));
    }
  }
  return std::string(name.substr(0, begin)) + other + std::string(name.substr(end));
}

std::string withoutSide(std::string_view name) {
  if (sideFrom(name) == model::Side::Unknown) return std::string(name);
  const auto [begin, end] = lastWord(name);
  return std::string(name.substr(0, begin)) + std::string(name.substr(end));
}

std::string bareName(std::string_view name) {
  std::string out;
  for (char c : name) {
    if (isLetter(c) || isDigit(c) || (static_cast<unsigned char>(c) & 0x80U) != 0) out += lower(c);
  }
  return out;
}

std::vector<std::string> madeUnique(std::vector<std::string> names) {
  std::set<std::string> taken(names.begin(), names.end());
  std::set<std::string> seen;
  for (std::string& name : names) {
    if (!seen.insert(name).second) {
      int k = 2;
      while (taken.contains(name + "_" + std::to_string(k))) ++k;
      name += "_" + std::to_string(k);
      taken.insert(name);
    }
  }
  return names;
}

}  // namespace ecorche::authoring
