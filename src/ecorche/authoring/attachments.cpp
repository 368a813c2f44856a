#include <ecorche/authoring/attachments.h>
#include <ecorche/authoring/names.h>
#include <ecorche/core/files.h>
#include <ecorche/model/units.h>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <unordered_map>

namespace ecorche::authoring {

namespace {

struct Cell {
  std::string text;
  int column = 1;
};

// Cells of one line; quotes inside quotes are doubled.
std::vector<Cell> cellsOf(std::string_view line) {
  std::vector<Cell> cells(1);
  bool quoted = false;
  for (std::size_t k = 0; k < line.size(); ++k) {
    const char c = line[k];
    if (c == '"' && quoted && k + 1 < line.size() && line[k + 1] == '"') {
      cells.back().text += '"';
      ++k;
    } else if (c == '"') {
      quoted = !quoted;
    } else if (c == ',' && !quoted) {
      cells.push_back({"", static_cast<int>(k) + 2});
    } else {
      cells.back().text += c;
    }
  }
  for (Cell& cell : cells) {
    const std::size_t first = cell.text.find_first_not_of(" \t\r");
    const std::size_t last = cell.text.find_last_not_of(" \t\r");
    cell.text = first == std::string::npos ? "" : cell.text.substr(first, last - first + 1);
  }
  return cells;
}

// What a column means, and what it may be called.
enum class Meaning { Muscle, Bone, X, Y, Z, Role, Patch };
struct Column {
  Meaning meaning;
  std::string_view plain;
  std::string_view ofSites;
  bool needed;
};
constexpr std::array<Column, 7> kColumns = {{{Meaning::Muscle, "muscle", "muscle_file", true},
                                             {Meaning::Bone, "bone", "bone_name_in_site", true},
                                             {Meaning::X, "x", "cx", true},
                                             {Meaning::Y, "y", "cy", true},
                                             {Meaning::Z, "z", "cz", true},
                                             {Meaning::Role, "role", "", false},
                                             {Meaning::Patch, "patch", "site_file", false}}};

class TableReader {
 public:
  TableReader(std::string file, double metresPerUnit)
      : file_(std::move(file)), scale_(metresPerUnit) {}

  std::optional<Error> header(const std::vector<Cell>& cells, int line) {
    ofSites_ = std::ranges::find(cells, "muscle_file", &Cell::text) != cells.end();
    width_ = cells.size();
    for (const Column& column : kColumns) {
      const std::string_view name = ofSites_ ? column.ofSites : column.plain;
      const auto found = std::ranges::find(cells, name, &Cell::text);
      if (!name.empty() && found != cells.end()) {
        where_[static_cast<std::size_t>(column.meaning)] =
            static_cast<std::size_t>(found - cells.begin());
      } else if (column.needed) {
        return error(ErrorCode::MissingKey,
                     fmt::format("the table has no column \"{}\"; it needs muscle, bone, x, y, z "
                                 "and may have role, patch",
                                 name),
                     line, 1);
      }
    }
    if (ofSites_) return std::nullopt;
    for (const Cell& cell : cells) {
      if (std::ranges::find(kColumns, cell.text, &Column::plain) != kColumns.end()) continue;
      return error(
          ErrorCode::UnknownKey,
          fmt::format("there is no column \"{}\"; known are muscle, role, bone, x, y, z, patch",
                      cell.text),
          line, cell.column);
    }
    return std::nullopt;
  }

  // Lists of sites hold patches that were joined to no muscle
  [[nodiscard]] bool belongsToNoMuscle(const std::vector<Cell>& cells) const {
    return ofSites_ && cells.size() == width_ && cell(cells, Meaning::Muscle)->text.empty();
  }

  Result<AttachmentSite> site(const std::vector<Cell>& cells, int line) {
    if (cells.size() != width_) {
      return tl::unexpected<Error>(
          error(ErrorCode::FileSyntax,
                fmt::format("{} cells where the first line has {}", cells.size(), width_), line,
                cells.back().column));
    }
    AttachmentSite out;
    out.line = line;
    const Cell& muscle = *cell(cells, Meaning::Muscle);
    out.muscle = muscleNameFrom(muscle.text);
    if (out.muscle.empty()) {
      return tl::unexpected<Error>(
          error(ErrorCode::MissingKey, "this line names no muscle", line, muscle.column));
    }
    out.bone = cell(cells, Meaning::Bone)->text;
    for (int k = 0; k < 3; ++k) {
      const Cell& number = *cell(cells, static_cast<Meaning>(static_cast<int>(Meaning::X) + k));
      const auto value = model::numberFrom(number.text);
      if (!value) {
        return tl::unexpected<Error>(error(ErrorCode::WrongType,
                                           fmt::format("\"{}\" is not a number", number.text), line,
                                           number.column));
      }
      out.at[k] = *value * scale_;
    }
    if (const Cell* role = cell(cells, Meaning::Role); role != nullptr && !role->text.empty()) {
      const auto known = model::fromWord<model::Attachment::Role>(role->text);
      if (!known) {
        return tl::unexpected<Error>(
            error(ErrorCode::ValueOutOfRange,
                  fmt::format("\"{}\" is no role; write origin, insertion or nothing", role->text),
                  line, role->column));
      }
      out.role = *known;
    }
    if (const Cell* patch = cell(cells, Meaning::Patch)) out.patchFile = patch->text;
    return out;
  }

 private:
  [[nodiscard]] Error error(ErrorCode code, std::string message, int line, int column) const {
    return {code, std::move(message), {.file = file_, .line = line, .column = column}};
  }
  [[nodiscard]] const Cell* cell(const std::vector<Cell>& cells, Meaning meaning) const {
    const auto& at = where_[static_cast<std::size_t>(meaning)];
    return at ? &cells[*at] : nullptr;
  }

  std::string file_;
  double scale_;
  std::size_t width_ = 0;
  bool ofSites_ = false;
  std::array<std::optional<std::size_t>, kColumns.size()> where_;
};

}  // namespace

Result<std::vector<MuscleSites>> parseAttachments(std::string_view text, const std::string& file,
                                                  double metresPerUnit) {
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  TableReader reader(file, metresPerUnit);
  std::vector<MuscleSites> out;
  std::unordered_map<std::string, std::size_t> known;
  bool headerSeen = false;
  for (int line = 1; !text.empty(); ++line) {
    const std::size_t end = text.find('\n');
    const std::string_view row = text.substr(0, end);
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    if (row.find_first_not_of(" \t\r,") == std::string_view::npos) continue;
    const std::vector<Cell> cells = cellsOf(row);
    if (!headerSeen) {
      headerSeen = true;
      if (auto fault = reader.header(cells, line)) return tl::unexpected<Error>(std::move(*fault));
      continue;
    }
    if (reader.belongsToNoMuscle(cells)) continue;
    auto site = reader.site(cells, line);
    if (!site) return passOn(site);
    const auto [at, fresh] = known.emplace(site->muscle, out.size());
    if (fresh) out.push_back({site->muscle, {}});
    out[at->second].sites.push_back(std::move(*site));
  }
  if (!headerSeen) return fail(ErrorCode::FileEmpty, "the table is empty", {.file = file});
  return out;
}

Result<std::vector<MuscleSites>> readAttachments(const std::filesystem::path& file,
                                                 double metresPerUnit) {
  const auto text = readFile(file);
  if (!text) return passOn(text);
  return parseAttachments(*text, file.string(), metresPerUnit);
}

}  // namespace ecorche::authoring
