#include <ecorche/model/project.h>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>

namespace ecorche::model {

namespace {

template <class Enum>
struct Words;
template <>
struct Words<Tissue::Kind> {
  static constexpr std::array<std::string_view, 5> kAll = {"muscle", "filler", "obstacle", "cavity",
                                                           "fat"};
};
template <>
struct Words<CutPlane::Kind> {
  static constexpr std::array<std::string_view, 2> kAll = {"symmetry", "region"};
};
template <>
struct Words<Support::On> {
  static constexpr std::array<std::string_view, 4> kAll = {"free", "bone", "plane", "tissue"};
};
template <>
struct Words<Attachment::Role> {
  static constexpr std::array<std::string_view, 3> kAll = {"", "origin", "insertion"};
};
template <>
struct Words<Side> {
  static constexpr std::array<std::string_view, 4> kAll = {"", "left", "right", "median"};
};

template <class Enum>
std::string_view wordOf(Enum value) {
  return Words<Enum>::kAll[static_cast<std::size_t>(value)];
}

template <class Named>
std::optional<std::size_t> findNamed(const std::vector<Named>& list, std::string_view name) {
  const auto found = std::ranges::find(list, name, &Named::name);
  if (found == list.end()) return std::nullopt;
  return static_cast<std::size_t>(found - list.begin());
}

}  // namespace

std::string_view word(Tissue::Kind kind) { return wordOf(kind); }
std::string_view word(CutPlane::Kind kind) { return wordOf(kind); }
std::string_view word(Support::On on) { return wordOf(on); }
std::string_view word(Attachment::Role role) { return wordOf(role); }
std::string_view word(Side side) { return wordOf(side); }

template <class Enum>
std::optional<Enum> fromWord(std::string_view text) {
  const auto& all = Words<Enum>::kAll;
  const auto found = std::ranges::find(all, text);
  if (text.empty() || found == all.end()) return std::nullopt;
  return static_cast<Enum>(found - all.begin());
}

template <class Enum>
std::string allWords() {
  std::vector<std::string_view> words;
  for (std::string_view w : Words<Enum>::kAll) {
    if (!w.empty()) words.push_back(w);
  }
  std::string text(words.front());
  for (std::size_t k = 1; k < words.size(); ++k) {
    text += k + 1 == words.size() ? " or " : ", ";
    text += words[k];
  }
  return text;
}

template std::optional<Tissue::Kind> fromWord(std::string_view);
template std::optional<CutPlane::Kind> fromWord(std::string_view);
template std::optional<Support::On> fromWord(std::string_view);
template std::optional<Attachment::Role> fromWord(std::string_view);
template std::optional<Side> fromWord(std::string_view);
template std::string allWords<Tissue::Kind>();
template std::string allWords<CutPlane::Kind>();
template std::string allWords<Support::On>();
template std::string allWords<Attachment::Role>();
template std::string allWords<Side>();

std::filesystem::path meshPath(const Project& project, const MeshRef& mesh) {
  return project.folder / std::filesystem::path(mesh.file);
}

double metresPerUnit(const Project& project, const MeshRef& mesh) {
  return metresPer(mesh.unit.value_or(project.unit));
}

std::string pathFrom(const std::filesystem::path& folder, const std::filesystem::path& file) {
  // An empty folder is the current one, which absolute() does not take
  const auto here = std::filesystem::current_path();
  const auto whole = (here / file).lexically_normal();
  const auto relative = whole.lexically_relative((here / folder).lexically_normal());
  return (relative.empty() ? whole : relative).generic_string();  // empty: on another drive
}

MeshRef movedTo(MeshRef mesh, const std::filesystem::path& from, const std::filesystem::path& to) {
  if (!mesh.file.empty() && std::filesystem::path(mesh.file).is_relative())
    mesh.file = pathFrom(to, from / mesh.file);
  return mesh;
}

Project movedTo(Project project, const std::filesystem::path& folder) {
  const auto move = [&](MeshRef& mesh) { mesh = movedTo(mesh, project.folder, folder); };
  move(project.skin);
  for (Bone& bone : project.bones) move(bone.mesh);
  for (Tissue& tissue : project.tissues) {
    if (tissue.mesh) move(*tissue.mesh);
    for (Attachment& attachment : tissue.attachments) {
      if (attachment.patch) move(*attachment.patch);
    }
  }
  project.folder = folder;
  return project;
}

std::optional<std::size_t> findBone(const Project& project, std::string_view name) {
  return findNamed(project.bones, name);
}
std::optional<std::size_t> findCutPlane(const Project& project, std::string_view name) {
  return findNamed(project.cutPlanes, name);
}
std::optional<std::size_t> findTissue(const Project& project, std::string_view name) {
  return findNamed(project.tissues, name);
}

TissueId tissueId(const Project& project, std::size_t tissue) {
  const Tissue& asked = project.tissues.at(tissue);
  if (asked.kind == Tissue::Kind::Fat) return kFat;
  if (!asked.hasCurves()) return kNoTissue;
  const auto before = std::count_if(project.tissues.begin(),
                                    project.tissues.begin() + static_cast<std::ptrdiff_t>(tissue),
                                    [](const Tissue& t) { return t.hasCurves(); });
  return TissueId(kFirstMuscle.value + before);
}

mesh::Spline splineOf(const Curve& curve) {
  std::vector<Vector3> points;
  points.reserve(curve.points.size());
  for (const ControlPoint& p : curve.points) points.push_back(p.at);
  return mesh::Spline(std::move(points));
}

std::vector<double> tissueValuesOf(const Curve& curve) {
  std::vector<double> values;
  values.reserve(curve.points.size());
  for (const ControlPoint& p : curve.points) values.push_back(p.tissue);
  return values;
}

std::string curveLabel(const Tissue& tissue, std::size_t curve) {
  const std::string& name = tissue.curves.at(curve).name;
  std::string label = fmt::format("\"{}\"", tissue.name);
  if (tissue.curves.size() > 1 || !name.empty()) label += fmt::format(", curve {}", curve + 1);
  if (!name.empty()) label += fmt::format(" ({})", name);
  return label;
}

std::string colourText(Colour colour) {
  return fmt::format("#{:02x}{:02x}{:02x}", colour.red, colour.green, colour.blue);
}

std::optional<Colour> colourFrom(std::string_view text) {
  if (text.size() != 7 || text[0] != '#') return std::nullopt;
  std::array<std::uint8_t, 3> channel{};
  for (std::size_t k = 0; k < 3; ++k) {
    const char* first = text.data() + 1 + 2 * k;
    const auto [end, error] = std::from_chars(first, first + 2, channel[k], 16);
    if (error != std::errc() || end != first + 2) return std::nullopt;
  }
  return Colour{channel[0], channel[1], channel[2]};
}

}  // namespace ecorche::model
