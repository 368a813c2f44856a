#include <ecorche/model/command_forms.h>
#include <ecorche/model/command_text.h>

#include <fmt/format.h>

namespace ecorche::model {

namespace {

// Plain words stand as they are; others in double quotes.
std::string quoted(const std::string& text) {
  if (!text.empty() && text.find_first_of(" \t\r\n\"\\=") == std::string::npos) return text;
  std::string out = "\"";
  for (char c : text) {
    switch (c) {
      case '"':
        out += "\\\"";
        break;
      case '\\':
        out += "\\\\";
        break;
      case '\n':
        out += "\\n";
        break;
      case '\r':
        out += "\\r";
        break;
      case '\t':
        out += "\\t";
        break;
      default:
        out += c;
    }
  }
  return out + "\"";
}

std::string vectorText(const Vector3& x) {
  return numberText(x.x()) + "," + numberText(x.y()) + "," + numberText(x.z());
}
std::string supportText(const Support& s) {
  return s.on == Support::On::Free ? "free" : fmt::format("{}:{}", word(s.on), s.name);
}

class Formatter {
 public:
  explicit Formatter(std::string_view verb) : out(verb) {}

  void name(const char*, const std::string& text) { add(quoted(text)); }
  void index(const char*, std::size_t value) { add(std::to_string(value + 1)); }
  void number(const char*, double value) { add(numberText(value)); }
  void number(const char*, const std::optional<double>& value) {
    add(value ? numberText(*value) : "none");
  }
  void count(const char*, const std::optional<std::int64_t>& value) {
    add(value ? std::to_string(*value) : "none");
  }
  void vector(const char*, const Vector3& value) { add(vectorText(value)); }
  void onOff(bool value) { add(value ? "on" : "off"); }
  void unit(const char*, Unit value) { add(std::string(symbol(value))); }
  void colour(const std::optional<Colour>& value) { add(value ? colourText(*value) : "none"); }
  void support(const Support& value) { add(quoted(supportText(value))); }
  template <class Enum>
  void choice(Enum value) {
    add(word(value).empty() ? "none" : std::string(word(value)));
  }
  void points(const std::vector<ControlPoint>& points) {
    std::string values;
    bool same = true;
    for (const ControlPoint& p : points) {
      add(vectorText(p.at));
      values += (values.empty() ? "" : ",") + numberText(p.tissue);
      same = same && p.tissue == points.front().tissue;
    }
    if (points.empty() || (same && points.front().tissue == 1.0)) return;
    add("tissue=" + (same ? numberText(points.front().tissue) : values));
  }
  void mesh(const MeshRef& mesh) {
    add(quoted(mesh.file));
    key("part", mesh.part);
    if (mesh.unit) add("unit=" + std::string(symbol(*mesh.unit)));
    if (mesh.repair != mesh::Mending::None) add("repair=" + std::string(mesh::name(mesh.repair)));
  }
  void key(const char* key, const std::string& text) {
    if (!text.empty()) add(std::string(key) + "=" + quoted(text));
  }
  void key(const char* key, double value) {
    if (value != 1.0) add(std::string(key) + "=" + numberText(value));
  }
  void key(const char* key, const Support& value) {
    if (value != Support{}) add(std::string(key) + "=" + quoted(supportText(value)));
  }
  void key(const char* key, const std::optional<Vector3>& value) {
    if (value) add(std::string(key) + "=" + vectorText(*value));
  }
  void key(const char* key, const std::optional<MeshRef>& value) {
    if (!value) return;
    add(std::string(key) + "=" + quoted(value->file));
    this->key("part", value->part);
    if (value->unit) add("unit=" + std::string(symbol(*value->unit)));
  }

  std::string out;

 private:
  void add(const std::string& text) { out += " " + text; }
};

// Words in capitals, keys in brackets.
class Usage {
 public:
  explicit Usage(std::string_view verb) : out(verb) {}
  template <class T>
  void name(const char* what, T&) {
    add(what);
  }
  template <class T>
  void index(const char* what, T&) {
    add(what);
  }
  template <class T>
  void number(const char* what, T&) {
    add(what);
  }
  template <class T>
  void count(const char* what, T&) {
    add(what);
  }
  template <class T>
  void vector(const char* what, T&) {
    add(what);
  }
  template <class T>
  void unit(const char* what, T&) {
    add(what);
  }
  void onOff(bool&) { add("on|off"); }
  void colour(std::optional<Colour>&) { add("#RRGGBB|none"); }
  void support(Support&) { add("bone:NAME|plane:NAME|tissue:NAME|free"); }
  void choice(CutPlane::Kind&) { add("symmetry|region"); }
  void choice(Side&) { add("left|right|median|none"); }
  void choice(Attachment::Role&) { add("origin|insertion|none"); }
  void points(std::vector<ControlPoint>&) { add("X,Y,Z X,Y,Z ... [tissue=VALUE[,VALUE...]]"); }
  void mesh(MeshRef&) { add("FILE [part=PART] [unit=UNIT] [repair=fill-holes|outer-hull|wrap]"); }
  void key(const char* key, std::string&) { addKey(key, "TEXT"); }
  void key(const char* key, double&) { addKey(key, "VALUE"); }
  void key(const char* key, Support&) { addKey(key, "bone:NAME|plane:NAME|tissue:NAME"); }
  void key(const char* key, std::optional<Vector3>&) { addKey(key, "X,Y,Z"); }
  void key(const char* key, std::optional<MeshRef>&) {
    add(fmt::format("[{}=FILE [part=PART] [unit=UNIT]]", key));
  }
  std::string out;

 private:
  void add(const std::string& text) { out += " " + text; }
  void addKey(const char* key, const char* what) { add(fmt::format("[{}={}]", key, what)); }
};

}  // namespace

std::string formatCommand(const Command& command) {
  return std::visit(
      [](auto copy) {
        using C = decltype(copy);
        Formatter formatter(Form<C>::kVerb);
        Form<C>::words(formatter, copy);
        return formatter.out;
      },
      command.act);
}

template <class C>
std::string usageOf() {
  Usage usage(Form<C>::kVerb);
  C command;
  Form<C>::words(usage, command);
  return usage.out;
}

std::vector<std::string> commandUsages() {
  std::vector<std::string> out;
  eachCommand([&]<class C>(C) { out.push_back(usageOf<C>()); }, Command::Act());
  return out;
}

}  // namespace ecorche::model
