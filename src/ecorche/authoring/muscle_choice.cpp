#include <ecorche/authoring/muscle_choice.h>
#include <ecorche/authoring/names.h>
#include <ecorche/core/files.h>

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

namespace ecorche::authoring {

namespace {

std::string trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(" \t\r");
  if (first == std::string_view::npos) return {};
  return std::string(text.substr(first, text.find_last_not_of(" \t\r") - first + 1));
}

std::vector<std::string> split(std::string_view text, char at) {
  std::vector<std::string> out;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(at, begin), text.size());
    std::string_view piece = text.substr(begin, end - begin);
    if (at == '\n') piece = piece.substr(0, piece.find('#'));
    if (std::string name = trimmed(piece); !name.empty()) out.push_back(std::move(name));
    begin = end + 1;
  }
  return out;
}

bool matches(std::string_view name, std::string_view muscle) {
  const std::string wanted = bareName(name);
  return wanted == bareName(muscle) || wanted == bareName(withoutSide(muscle));
}

// Names that hold the wanted one's first letters, a few of them
std::string likeIt(const std::vector<MuscleSites>& table, std::string_view name) {
  constexpr std::size_t kLetters = 5;
  constexpr int kMost = 4;
  const std::string start = bareName(name).substr(0, kLetters);
  std::string out;
  int count = 0;
  for (const MuscleSites& muscle : table) {
    if (bareName(muscle.muscle).find(start) == std::string::npos || ++count > kMost) continue;
    out += (out.empty() ? "" : ", ") + muscle.muscle;
  }
  return out;
}

}  // namespace

Result<std::vector<std::string>> muscleNamesFrom(const std::string& listOrFile) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(listOrFile, ignored)) return split(listOrFile, ',');
  const auto text = readFile(listOrFile);
  if (!text) return passOn(text);
  auto names = split(*text, '\n');
  if (names.empty())
    return fail(ErrorCode::FileEmpty, "this list names no muscle", {.file = listOrFile});
  return names;
}

Result<std::vector<MuscleSites>> chosenMuscles(const std::vector<MuscleSites>& table,
                                               const std::vector<std::string>& names) {
  std::vector<bool> wanted(table.size(), false);
  for (const std::string& name : names) {
    bool found = false;
    for (std::size_t k = 0; k < table.size(); ++k) {
      if (!matches(name, table[k].muscle)) continue;
      wanted[k] = true;
      found = true;
    }
    if (found) continue;
    const std::string like = likeIt(table, name);
    return fail(ErrorCode::UnknownName,
                fmt::format("the table has no muscle \"{}\"{}", name,
                            like.empty() ? "" : "; it has " + like),
                {.object = name});
  }
  std::vector<MuscleSites> out;
  for (std::size_t k = 0; k < table.size(); ++k) {
    if (wanted[k]) out.push_back(table[k]);
  }
  return out;
}

}  // namespace ecorche::authoring
