#include <ecorche/core/files.h>
#include <ecorche/model/json.h>
#include <ecorche/model/migrations.h>
#include <ecorche/model/project_check.h>
#include <ecorche/model/project_file.h>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>

namespace ecorche::model {

std::span<const ObjectKeys> projectKeys() {
  static const std::vector<ObjectKeys> kKeys = {
      {"project",
       {"schema", "skin"},
       {"name", "unit", "bones", "cut_planes", "settings", "tissues"}},
      {"skin", {"file"}, {"part", "unit", "repair"}},
      {"bone", {"name", "file"}, {"part", "unit", "repair"}},
      {"cut_plane", {"name", "point", "normal"}, {"kind"}},
      {"settings", {}, {"fat", "core_radius", "alpha", "tets", "edge_length", "surface_tolerance"}},
      {"curve_tissue",
       {"name", "kind"},
       {"side", "group", "layer", "color", "protected", "keeps_twin", "core_radius", "anisotropy",
        "curves", "attachments"}},
      {"mesh_tissue",
       {"name", "kind", "file"},
       {"part", "unit", "repair", "side", "group", "layer", "color", "protected"}},
      {"fat_tissue", {"name", "kind"}, {"color"}},
      {"anisotropy", {}, {"lambda2", "lambda3", "rotation"}},
      {"curve", {"points"}, {"name", "start", "end"}},
      {"control_point", {"at"}, {"tissue"}},
      {"support", {"on"}, {"name"}},
      {"attachment", {"on"}, {"role", "name", "at", "patch"}},
      {"patch", {"file"}, {"part", "unit"}},
  };
  return kKeys;
}

namespace {

// Walks the tree and keeps the first error; after one, everything reads as its default.
class Reader {
 public:
  explicit Reader(std::string file) : file_(std::move(file)) {}

  Project project(const Json& root) {
    Project p;
    if (!object(root, "project", "the project")) return p;
    p.name = text(root, "name");
    if (const Json* unit = root.find("unit")) p.unit = unitOf(*unit);
    unit_ = p.unit;  // needed by every length below, wherever the key stands
    if (const Json* skin = root.find("skin"); object(*skin, "skin", "the skin"))
      p.skin = mesh(*skin);
    for (const Json& item : list(root, "bones")) {
      if (object(item, "bone", "a bone")) p.bones.push_back({text(item, "name"), mesh(item)});
    }
    for (const Json& item : list(root, "cut_planes")) {
      if (object(item, "cut_plane", "a cut plane")) p.cutPlanes.push_back(cutPlane(item));
    }
    if (const Json* s = root.find("settings"); s && object(*s, "settings", "the settings")) {
      p.settings = settings(*s);
    }
    for (const Json& item : list(root, "tissues")) p.tissues.push_back(tissue(item));
    return p;
  }

  std::optional<Error> error;

 private:
  void give(ErrorCode code, std::string message, Json::Spot spot) {
    if (!error) {
      error = Error{
          code, std::move(message), {.file = file_, .line = spot.line, .column = spot.column}};
    }
  }

  // Is this an object with all the keys it needs and none that we do not know?
  bool object(const Json& json, std::string_view kind, const std::string& what) {
    if (error) return false;
    if (json.kind != Json::Kind::Object) {
      give(ErrorCode::WrongType,
           fmt::format("{} is {}; it must be an object", what, describe(json.kind)), json.spot);
      return false;
    }
    const auto keys = projectKeys();
    const ObjectKeys& known = *std::ranges::find(keys, kind, &ObjectKeys::object);
    std::vector<std::string_view> all = known.required;
    all.insert(all.end(), known.optional.begin(), known.optional.end());
    for (const Json::Key& key : json.keys) {
      if (std::ranges::find(all, key.name) != all.end()) continue;
      give(ErrorCode::UnknownKey,
           fmt::format("{} has no \"{}\"; it may have {}", what, key.name, fmt::join(all, ", ")),
           key.spot);
      return false;
    }
    for (std::string_view key : known.required) {
      if (json.find(key) != nullptr) continue;
      give(ErrorCode::MissingKey, fmt::format("{} lacks \"{}\"; add it", what, key), json.spot);
      return false;
    }
    return true;
  }

  bool is(const Json& json, Json::Kind kind, std::string_view key) {
    if (error) return false;
    if (json.kind == kind) return true;
    give(ErrorCode::WrongType,
         fmt::format("\"{}\" is {}; it must be {}", key, describe(json.kind), describe(kind)),
         json.spot);
    return false;
  }

  std::string text(const Json& json, std::string_view key) {
    const Json* value = json.find(key);
    return value && is(*value, Json::Kind::String, key) ? value->text : std::string();
  }

  std::span<const Json> list(const Json& json, std::string_view key) {
    const Json* value = json.find(key);
    if (value == nullptr || !is(*value, Json::Kind::Array, key)) return {};
    return value->items;
  }

  template <class Convert>
  std::optional<double> converted(const Json& json, std::string_view key, const Convert& convert) {
    if (!is(json, Json::Kind::Number, key)) return std::nullopt;
    const std::optional<double> value = convert(json.text);
    if (!value)
      give(ErrorCode::ValueOutOfRange,
           fmt::format("\"{}\" is {}, too large a number", key, json.text), json.spot);
    return value;
  }
  std::optional<double> number(const Json& json, std::string_view key) {
    const Json* value = json.find(key);
    return value ? converted(*value, key, numberFrom) : std::nullopt;
  }
  std::optional<double> length(const Json& json, std::string_view key) {
    const Json* value = json.find(key);
    if (value == nullptr) return std::nullopt;
    return converted(*value, key, [&](std::string_view t) { return lengthFrom(t, unit_); });
  }
  std::optional<std::int64_t> whole(const Json& json, std::string_view key) {
    const Json* value = json.find(key);
    if (value == nullptr || !is(*value, Json::Kind::Number, key)) return std::nullopt;
    const double x = numberFrom(value->text).value_or(HUGE_VAL);
    if (x == std::floor(x) && std::abs(x) < 9e15) return static_cast<std::int64_t>(x);
    give(ErrorCode::WrongType,
         fmt::format("\"{}\" is {}; it must be a whole number", key, value->text), value->spot);
    return std::nullopt;
  }

  bool flag(const Json& json, std::string_view key) {
    const Json* value = json.find(key);
    return value != nullptr && is(*value, Json::Kind::Bool, key) && value->boolean;
  }

  Vector3 vector(const Json& json, std::string_view key, bool isLength) {
    Vector3 out = Vector3::Zero();
    const Json* value = json.find(key);
    if (value == nullptr || !is(*value, Json::Kind::Array, key)) return out;
    if (value->items.size() != 3) {
      give(ErrorCode::WrongType,
           fmt::format("\"{}\" has {} entries; it must be [x, y, z]", key, value->items.size()),
           value->spot);
      return out;
    }
    for (int k = 0; k < 3; ++k) {
      const Json& item = value->items[static_cast<std::size_t>(k)];
      out[k] = converted(item, key, [&](std::string_view t) {
                 return isLength ? lengthFrom(t, unit_) : numberFrom(t);
               }).value_or(0.0);
    }
    return out;
  }

  template <class Enum>
  Enum choice(const Json& json, std::string_view key, Enum fallback) {
    const Json* value = json.find(key);
    if (value == nullptr || !is(*value, Json::Kind::String, key)) return fallback;
    if (const auto known = fromWord<Enum>(value->text)) return *known;
    give(ErrorCode::ValueOutOfRange,
         fmt::format("\"{}\" is \"{}\"; it must be {}", key, value->text, allWords<Enum>()),
         value->spot);
    return fallback;
  }

  Unit unitOf(const Json& json) {
    if (!is(json, Json::Kind::String, "unit")) return Unit::Metre;
    if (const auto known = unitFrom(json.text)) return *known;
    give(ErrorCode::ValueOutOfRange,
         fmt::format("\"unit\" is \"{}\"; it must be m, dm, cm, mm or in", json.text), json.spot);
    return Unit::Metre;
  }

  mesh::Mending repairOf(const Json& json) {
    if (!is(json, Json::Kind::String, "repair")) return mesh::Mending::None;
    if (const auto known = mesh::mendingNamed(json.text)) return *known;
    give(ErrorCode::ValueOutOfRange,
         fmt::format("\"repair\" is \"{}\"; it must be none, fill-holes, outer-hull or wrap",
                     json.text),
         json.spot);
    return mesh::Mending::None;
  }

  MeshRef mesh(const Json& json) {
    MeshRef out{text(json, "file"), text(json, "part"), std::nullopt};
    if (const Json* unit = json.find("unit")) out.unit = unitOf(*unit);
    if (const Json* repair = json.find("repair")) out.repair = repairOf(*repair);
    return out;
  }

  CutPlane cutPlane(const Json& json) {
    CutPlane plane;
    plane.name = text(json, "name");
    plane.kind = choice(json, "kind", CutPlane::Kind::Symmetry);
    plane.point = vector(json, "point", true);
    plane.normal = vector(json, "normal", false);
    // Unit inside; left alone where it is one already, so that writing and reading changes nothing
    const double size = plane.normal.stableNorm();
    if (size > 0.0 && std::abs(size - 1.0) > 1e-12) plane.normal /= size;
    return plane;
  }

  Settings settings(const Json& json) {
    Settings s;
    s.fat = number(json, "fat").value_or(s.fat);
    s.coreRadius = length(json, "core_radius");
    s.alpha = number(json, "alpha");
    s.tets = whole(json, "tets");
    s.edgeLength = length(json, "edge_length");
    s.surfaceTolerance = number(json, "surface_tolerance").value_or(s.surfaceTolerance);
    return s;
  }

  Tissue tissue(const Json& json) {
    Tissue t;
    if (error) return t;
    // The kind decides which keys there are, so it comes first
    const Json* const kind = json.find("kind");
    if (json.kind == Json::Kind::Object && kind == nullptr) {
      give(ErrorCode::MissingKey,
           fmt::format("tissue \"{}\" lacks \"kind\": {}", text(json, "name"),
                       allWords<Tissue::Kind>()),
           json.spot);
    }
    t.kind = choice(json, "kind", Tissue::Kind::Muscle);
    t.name = text(json, "name");
    const bool isFat = t.kind == Tissue::Kind::Fat;
    const std::string_view keys = t.hasCurves() ? "curve_tissue"
                                  : isFat       ? "fat_tissue"
                                                : "mesh_tissue";
    if (!object(json, keys, fmt::format("{} \"{}\"", word(t.kind), t.name))) return t;

    t.side = choice(json, "side", Side::Unknown);
    t.group = text(json, "group");
    if (const auto layer = whole(json, "layer"))
      t.layer = static_cast<int>(std::clamp<std::int64_t>(*layer, -1, 100000));
    if (const Json* colour = json.find("color");
        colour && is(*colour, Json::Kind::String, "color")) {
      t.colour = colourFrom(colour->text);
      if (!t.colour) {
        give(ErrorCode::ValueOutOfRange,
             fmt::format("\"color\" is \"{}\"; write it like \"#c0504d\"", colour->text),
             colour->spot);
      }
    }
    t.isProtected = flag(json, "protected");
    t.keepsTwin = flag(json, "keeps_twin");
    if (json.find("file") != nullptr) t.mesh = mesh(json);
    t.coreRadius = length(json, "core_radius");
    if (const Json* a = json.find("anisotropy"); a && object(*a, "anisotropy", "the anisotropy")) {
      t.anisotropy = anisotropy(*a);
    }
    for (const Json& item : list(json, "curves")) {
      if (object(item, "curve", fmt::format("a curve of \"{}\"", t.name)))
        t.curves.push_back(curve(item));
    }
    for (const Json& item : list(json, "attachments")) {
      if (object(item, "attachment", fmt::format("an attachment of \"{}\"", t.name))) {
        t.attachments.push_back(attachment(item));
      }
    }
    return t;
  }

  Anisotropy anisotropy(const Json& json) {
    Anisotropy a;
    a.lambda2 = number(json, "lambda2").value_or(a.lambda2);
    a.lambda3 = number(json, "lambda3").value_or(a.lambda3);
    if (const Json* rotation = json.find("rotation")) {
      a.rotation = converted(*rotation, "rotation", angleFromDeg).value_or(0.0);
    }
    return a;
  }

  Curve curve(const Json& json) {
    Curve c;
    c.name = text(json, "name");
    for (const Json& item : list(json, "points")) {
      if (!object(item, "control_point", "a control point")) break;
      c.points.push_back({vector(item, "at", true), number(item, "tissue").value_or(1.0)});
    }
    for (auto [key, end] : {std::pair("start", &c.start), std::pair("end", &c.end)}) {
      const Json* value = json.find(key);
      if (value && object(*value, "support", fmt::format("the {} of a curve", key)))
        *end = support(*value);
    }
    return c;
  }

  Support support(const Json& json) {
    return {choice(json, "on", Support::On::Free), text(json, "name")};
  }

  Attachment attachment(const Json& json) {
    Attachment a;
    a.role = choice(json, "role", Attachment::Role::Unknown);
    a.support = support(json);
    if (json.find("at") != nullptr) a.at = vector(json, "at", true);
    if (const Json* patch = json.find("patch"); patch && object(*patch, "patch", "a patch"))
      a.patch = mesh(*patch);
    return a;
  }

  std::string file_;
  Unit unit_ = Unit::Metre;
};

}  // namespace

Result<Project> parseProject(std::string_view text, const std::filesystem::path& file) {
  const std::string shown = file.string();
  auto root = parseJson(text, shown);
  const auto first = std::min(text.find_first_not_of("\xEF\xBB\xBF \t\r\n"), text.size() - 1);
  if (!root && root.error().code == ErrorCode::FileSyntax && text[first] != '{' &&
      text[first] != '[') {
    return fail(
        ErrorCode::FileUnknownFormat,
        "this is no project file, those begin with \"{\"; make one from meshes by `ecorche new`",
        root.error().place);
  }
  if (!root) return passOn(root);
  if (auto current = migrate(*root, kSchema, migrations(), shown); !current) return passOn(current);

  Reader reader(shown);
  Project project = reader.project(*root);
  if (reader.error) return tl::unexpected<Error>(std::move(*reader.error));
  project.folder = file.parent_path();
  if (auto fault = findFault(project)) {
    const Json::Spot spot = spotOf(*root, fault->pointer);
    return fail(fault->code, std::move(fault->message),
                {.file = shown,
                 .line = spot.line,
                 .column = spot.column,
                 .object = std::move(fault->object)});
  }
  return project;
}

Result<Project> loadProject(const std::filesystem::path& file) {
  const auto text = readFile(file);
  if (!text) return passOn(text);
  return parseProject(*text, file);
}

}  // namespace ecorche::model
