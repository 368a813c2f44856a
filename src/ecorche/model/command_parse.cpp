#include <ecorche/model/command_forms.h>
#include <ecorche/model/command_text.h>

#include <fmt/format.h>

#include <charconv>

namespace ecorche::model {

namespace {

struct Token {
  std::string key;  // of key=value; else empty
  std::string text;
  int column = 0;
  bool used = false;
};

tl::unexpected<Error> syntax(std::string message, int column) {
  return fail(ErrorCode::CommandSyntax, std::move(message), {.line = 1, .column = column});
}

Result<std::vector<Token>> tokens(std::string_view line) {
  std::vector<Token> out;
  std::size_t at = 0;
  while (true) {
    while (at < line.size() && std::string_view(" \t\r").find(line[at]) != std::string_view::npos)
      ++at;
    if (at == line.size()) return out;
    Token token;
    token.column = static_cast<int>(at) + 1;
    bool keyAllowed = true;
    while (at < line.size() && std::string_view(" \t\r").find(line[at]) == std::string_view::npos) {
      const char c = line[at++];
      if (c == '=' && keyAllowed) {
        std::swap(token.key, token.text);
        keyAllowed = false;
      } else if (c == '"') {
        keyAllowed = false;
        for (; at < line.size() && line[at] != '"'; ++at) {
          if (line[at] != '\\') {
            token.text += line[at];
            continue;
          }
          if (++at == line.size()) break;
          const std::size_t known = std::string_view("\"\\nrt").find(line[at]);
          if (known == std::string_view::npos) {
            return syntax(
                fmt::format("\"\\{}\" means nothing; use \\\" \\\\ \\n \\r or \\t", line[at]),
                static_cast<int>(at));
          }
          token.text += "\"\\\n\r\t"[known];
        }
        if (at >= line.size()) return syntax("a quotation mark is not closed", token.column);
        ++at;
      } else {
        token.text += c;
      }
    }
    out.push_back(std::move(token));
  }
}

// Takes the words of one line in order; keeps the first thing that is wrong.
class Parser {
 public:
  Parser(std::vector<Token> tokens, std::string usage, int end)
      : tokens_(std::move(tokens)), usage_(std::move(usage)), end_(end) {}

  void name(const char* what, std::string& out) {
    if (const Token* t = next(what)) out = t->text;
  }
  void index(const char* what, std::size_t& out) {
    const Token* t = next(what);
    if (t == nullptr) return;
    const auto value = whole(t->text);
    if (!value || *value < 1) return wrong(*t, "a number from 1");
    out = static_cast<std::size_t>(*value) - 1;
  }
  void number(const char* what, double& out) {
    if (const Token* t = next(what)) read(*t, out);
  }
  void number(const char* what, std::optional<double>& out) {
    const Token* t = next(what);
    if (t == nullptr || t->text == "none") return;
    read(*t, out.emplace());
  }
  void count(const char* what, std::optional<std::int64_t>& out) {
    const Token* t = next(what);
    if (t == nullptr || t->text == "none") return;
    out = whole(t->text);
    if (!out) wrong(*t, "a whole number or none");
  }
  void vector(const char* what, Vector3& out) {
    if (const Token* t = next(what)) read(*t, out);
  }
  void onOff(bool& out) {
    const Token* t = next("on|off");
    if (t == nullptr) return;
    if (t->text != "on" && t->text != "off") return wrong(*t, "on or off");
    out = t->text == "on";
  }
  void unit(const char* what, Unit& out) {
    if (const Token* t = next(what)) read(*t, out);
  }
  void colour(std::optional<Colour>& out) {
    const Token* t = next("#RRGGBB|none");
    if (t == nullptr || t->text == "none") return;
    out = colourFrom(t->text);
    if (!out) wrong(*t, "a colour like #c0504d");
  }
  void support(Support& out) {
    if (const Token* t = next("bone:NAME|plane:NAME|tissue:NAME|free")) read(*t, out);
  }
  template <class Enum>
  void choice(Enum& out) {
    const Token* t = next(allWords<Enum>().c_str());
    if (t == nullptr || (t->text == "none" && word(Enum{}).empty())) return;
    const auto known = fromWord<Enum>(t->text);
    if (!known) return wrong(*t, allWords<Enum>());
    out = *known;
  }
  void points(std::vector<ControlPoint>& out) {
    do {
      vector("X,Y,Z", out.emplace_back().at);
    } while (!error && atWord());
    const Token* t = keyed("tissue");
    if (t == nullptr) return;
    const std::vector<std::string> parts = split(t->text);
    if (parts.size() != 1 && parts.size() != out.size()) {
      return wrong(*t, fmt::format("one tissue value or {}", out.size()));
    }
    for (std::size_t k = 0; k < out.size(); ++k) {
      const auto value = numberFrom(parts.size() == 1 ? parts[0] : parts[k]);
      if (!value) return wrong(*t, "numbers");
      out[k].tissue = *value;
    }
  }
  void mesh(MeshRef& out) {
    name("FILE", out.file);
    meshKeys(out);
    if (const Token* t = keyed("repair")) {
      const auto how = mesh::mendingNamed(t->text);
      if (!how) return wrong(*t, "none, fill-holes, outer-hull or wrap");
      out.repair = *how;
    }
  }
  void key(const char* key, std::string& out) {
    if (const Token* t = keyed(key)) out = t->text;
  }
  void key(const char* key, std::optional<MeshRef>& out) {
    const Token* t = keyed(key);
    if (t == nullptr) return;
    out.emplace().file = t->text;
    meshKeys(*out);
  }
  void key(const char* key, std::optional<Vector3>& out) {
    if (const Token* t = keyed(key)) read(*t, out.emplace());
  }
  template <class T>
  void key(const char* key, T& out) {
    if (const Token* t = keyed(key)) read(*t, out);
  }

  // What is left over was not asked for
  void finish() {
    for (const Token& t : tokens_) {
      if (!t.used) {
        return give(fmt::format("\"{}{}{}\" is too much; write: {}", t.key,
                                t.key.empty() ? "" : "=", t.text, usage_),
                    t.column);
      }
    }
  }

  std::optional<Error> error;

 private:
  void give(std::string message, int column) {
    if (!error) error = syntax(std::move(message), column).value();
  }
  void wrong(const Token& t, std::string_view wanted) {
    give(fmt::format("\"{}\" is not {}; write: {}", t.text, wanted, usage_), t.column);
  }

  // Keys may stand anywhere between words
  bool atWord() {
    while (here_ < tokens_.size() && !tokens_[here_].key.empty()) ++here_;
    return here_ < tokens_.size();
  }
  const Token* next(const char* what) {
    if (error) return nullptr;
    if (!atWord()) {
      give(fmt::format("{} is missing; write: {}", what, usage_), end_);
      return nullptr;
    }
    tokens_[here_].used = true;
    return &tokens_[here_++];
  }
  const Token* keyed(std::string_view key) {
    for (Token& t : tokens_) {
      if (error || t.used || t.key != key) continue;
      t.used = true;
      return &t;
    }
    return nullptr;
  }
  void meshKeys(MeshRef& out) {
    key("part", out.part);
    if (const Token* t = keyed("unit")) read(*t, out.unit.emplace());
  }

  static std::vector<std::string> split(const std::string& text) {
    std::vector<std::string> parts(1);
    for (char c : text) {
      if (c == ',') {
        parts.emplace_back();
      } else {
        parts.back() += c;
      }
    }
    return parts;
  }
  static std::optional<std::int64_t> whole(const std::string& text) {
    std::int64_t value = 0;
    const char* const end = text.data() + text.size();
    const auto [stop, fault] = std::from_chars(text.data(), end, value);
    if (text.empty() || stop != end || fault != std::errc()) return std::nullopt;
    return value;
  }

  void read(const Token& t, double& out) {
    const auto value = numberFrom(t.text);
    if (!value) return wrong(t, "a number");
    out = *value;
  }
  void read(const Token& t, Unit& out) {
    const auto value = unitFrom(t.text);
    if (!value) return wrong(t, "a unit (m, dm, cm, mm, in)");
    out = *value;
  }
  void read(const Token& t, Vector3& out) {
    const std::vector<std::string> parts = split(t.text);
    for (std::size_t k = 0; k < 3; ++k) {
      const auto value = parts.size() == 3 ? numberFrom(parts[k]) : std::nullopt;
      if (!value) return wrong(t, "x,y,z");
      out[static_cast<Eigen::Index>(k)] = *value;
    }
  }
  void read(const Token& t, Support& out) {
    if (t.text == "free") return;
    const std::size_t colon = t.text.find(':');
    const auto on = fromWord<Support::On>(t.text.substr(0, colon));
    if (!on || *on == Support::On::Free || colon == std::string::npos) {
      return wrong(t, "bone:NAME, plane:NAME, tissue:NAME or free");
    }
    out = {*on, t.text.substr(colon + 1)};
  }

  std::vector<Token> tokens_;
  std::string usage_;
  int end_;
  std::size_t here_ = 0;
};

template <class C>
Result<Command> parseAs(std::vector<Token> words, std::string usage, int end) {
  Parser parser(std::move(words), std::move(usage), end);
  C command;
  Form<C>::words(parser, command);
  parser.finish();
  if (parser.error) return tl::unexpected<Error>(std::move(*parser.error));
  return Command(std::move(command));
}

struct Row {
  std::string_view verb;
  Result<Command> (*parse)(std::vector<Token>, std::string usage, int end);
};
const std::vector<Row>& rows() {
  static const std::vector<Row> kRows = [] {
    std::vector<Row> out;
    eachCommand([&]<class C>(C) { out.push_back({Form<C>::kVerb, parseAs<C>}); }, Command::Act());
    return out;
  }();
  return kRows;
}

}  // namespace

Result<Command> parseCommand(std::string_view line) {
  auto words = tokens(line);
  if (!words) return passOn(words);
  if (words->empty()) return syntax("there is no command here", 1);
  const Token verb = words->front();
  words->erase(words->begin());
  static const std::vector<std::string> kUsages = commandUsages();
  for (std::size_t k = 0; k < rows().size(); ++k) {
    if (!verb.key.empty() || rows()[k].verb != verb.text) continue;
    return rows()[k].parse(std::move(*words), kUsages[k], static_cast<int>(line.size()) + 1);
  }
  return syntax(fmt::format("there is no command \"{}\"; ecorche run --help lists them", verb.text),
                verb.column);
}

Result<std::vector<ScriptLine>> parseScript(std::string_view text, const std::string& file) {
  std::vector<ScriptLine> out;
  int number = 0;
  while (!text.empty()) {
    const std::size_t end = text.find('\n');
    const std::string_view line = text.substr(0, end);
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    ++number;
    const std::size_t first = line.find_first_not_of(" \t\r");
    if (first == std::string_view::npos || line[first] == '#') continue;
    auto command = parseCommand(line);
    if (!command) {
      Error error = std::move(command.error());
      error.place.file = file;
      error.place.line = number;
      return tl::unexpected<Error>(std::move(error));
    }
    out.push_back({std::move(*command), number});
  }
  return out;
}

}  // namespace ecorche::model
