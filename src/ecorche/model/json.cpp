#include <ecorche/model/json.h>

#include <algorithm>
#include <charconv>
#include <nlohmann/json.hpp>

namespace ecorche::model {

namespace {

constexpr std::size_t kDeepest = 64;

// Feeds the parser and counts how much it took: its SAX interface does not tell places.
class CountingIterator {
 public:
  using iterator_category = std::input_iterator_tag;
  using value_type = char;
  using difference_type = std::ptrdiff_t;
  using pointer = const char*;
  using reference = const char&;

  CountingIterator(const char* at, const char** taken) : at_(at), taken_(taken) {}
  reference operator*() const { return *at_; }
  CountingIterator& operator++() {
    *taken_ = ++at_;
    return *this;
  }
  CountingIterator operator++(int) {
    CountingIterator before = *this;
    ++*this;
    return before;
  }
  bool operator==(const CountingIterator& other) const { return at_ == other.at_; }
  bool operator!=(const CountingIterator& other) const { return at_ != other.at_; }

 private:
  const char* at_;
  const char** taken_;
};

class TreeBuilder : public nlohmann::json_sax<nlohmann::json> {
 public:
  TreeBuilder(std::string_view text, const std::string& file)
      : file_(file), at_(text.data()), end_(text.data() + text.size()), taken_(text.data()) {
    if (text.starts_with("\xEF\xBB\xBF")) at_ += 3;
    counted_ = at_;
  }

  const char** taken() { return &taken_; }

  bool null() override { return put({}); }
  bool boolean(bool value) override {
    Json json;
    json.kind = Json::Kind::Bool;
    json.boolean = value;
    return put(std::move(json));
  }
  bool number_integer(number_integer_t) override { return putNumber(); }
  bool number_unsigned(number_unsigned_t) override { return putNumber(); }
  bool number_float(number_float_t, const string_t&) override { return putNumber(); }
  bool string(string_t& value) override { return put(Json::string(std::move(value))); }
  bool binary(binary_t&) override { return false; }

  bool start_object(std::size_t) override { return open(Json::object()); }
  bool start_array(std::size_t) override { return open(Json::array()); }
  bool end_object() override { return close(); }
  bool end_array() override { return close(); }

  bool key(string_t& name) override {
    const Json::Spot spot = walkToToken();
    at_ = taken_;
    const bool known =
        std::ranges::any_of(open_.back()->keys, [&](const Json::Key& k) { return k.name == name; });
    if (known) {
      return give(ErrorCode::DuplicateName, "the key \"" + name + "\" is given twice; keep one",
                  spot);
    }
    open_.back()->keys.push_back({name, spot});
    return true;
  }

  bool parse_error(std::size_t, const std::string&, const nlohmann::json::exception& e) override {
    // The parser's sentence without its own counting: "… syntax error while parsing value -
    // unexpected ','"
    std::string_view what = e.what();
    for (std::string_view lead : {"syntax error ", "number overflow "}) {
      if (const std::size_t from = what.find(lead); from != std::string_view::npos) {
        what.remove_prefix(from);
        break;
      }
    }
    Json::Spot spot = walkToToken();
    const auto says = [&](std::string_view words) { return what.find(words) != what.npos; };
    const bool cutToken = taken_ == end_ && !open_.empty() && says("invalid ");
    if (cutToken || says("unexpected end of input") || says("missing closing quote")) {
      return give(ErrorCode::FileTruncated, "the file breaks off here; copy or save it again",
                  spot);
    }
    return give(ErrorCode::FileSyntax, "this is not JSON: " + std::string(what), spot);
  }

  Json root;
  std::optional<Error> error;

 private:
  bool give(ErrorCode code, std::string message, Json::Spot spot) {
    error =
        Error{code, std::move(message), {.file = file_, .line = spot.line, .column = spot.column}};
    return false;
  }

  // From the end of the last token to the beginning of this one; only blanks, commas and colons lie
  // between.
  Json::Spot walkToToken() {
    while (at_ < end_ && std::string_view(" \t\r\n,:").find(*at_) != std::string_view::npos) ++at_;
    for (; counted_ < at_; ++counted_) {
      if (*counted_ == '\n') {
        ++spot_.line;
        spot_.column = 1;
      } else if ((static_cast<unsigned char>(*counted_) & 0xC0U) != 0x80U) {
        ++spot_.column;
      }
    }
    return spot_;
  }

  Json* place(Json value) {
    if (open_.empty()) return &(root = std::move(value));
    open_.back()->items.push_back(std::move(value));
    return &open_.back()->items.back();
  }

  bool put(Json value) {
    value.spot = walkToToken();
    at_ = taken_;
    place(std::move(value));
    return true;
  }

  // The parser reads one character past a number, so its own text says where it ends.
  bool putNumber() {
    const Json::Spot spot = walkToToken();
    const char* first = at_;
    while (at_ < end_ && std::string_view("+-.0123456789eE").find(*at_) != std::string_view::npos)
      ++at_;
    Json value = Json::number(std::string(first, at_));
    value.spot = spot;
    place(std::move(value));
    return true;
  }

  bool open(Json value) {
    value.spot = walkToToken();
    at_ = taken_;
    if (open_.size() == kDeepest) {
      return give(ErrorCode::FileSyntax, "lists within lists, more than 64 deep", value.spot);
    }
    open_.push_back(
        place(std::move(value)));  // stays put: nothing joins its parent until it is closed
    return true;
  }

  bool close() {
    walkToToken();
    at_ = taken_;
    open_.pop_back();
    return true;
  }

  std::string file_;
  const char* at_;  // behind the last token
  const char* end_;
  const char* taken_;              // how far the parser has read
  const char* counted_ = nullptr;  // where spot_ is
  Json::Spot spot_{1, 1};
  std::vector<Json*> open_;
};

std::string asText(const std::string& text) {
  return nlohmann::json(text).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

bool holdsObjects(const Json& value) {
  if (value.kind == Json::Kind::Array) {
    return std::ranges::any_of(value.items,
                               [](const Json& i) { return i.kind == Json::Kind::Object; });
  }
  return std::ranges::any_of(value.items, holdsObjects);
}

void printInline(const Json& value, std::string& out) {
  switch (value.kind) {
    case Json::Kind::Null:
      out += "null";
      return;
    case Json::Kind::Bool:
      out += value.boolean ? "true" : "false";
      return;
    case Json::Kind::Number:
      out += value.text;
      return;
    case Json::Kind::String:
      out += asText(value.text);
      return;
    case Json::Kind::Array:
    case Json::Kind::Object:
      break;
  }
  const bool object = value.kind == Json::Kind::Object;
  out += object ? '{' : '[';
  for (std::size_t k = 0; k < value.items.size(); ++k) {
    if (k > 0) out += ", ";
    if (object) out += asText(value.keys[k].name) + ": ";
    printInline(value.items[k], out);
  }
  out += object ? '}' : ']';
}

void print(const Json& value, std::size_t indent, std::size_t used, std::string& out) {
  constexpr std::size_t kLine = 100;
  if (!holdsObjects(value) && indent > 0) {
    std::string line;
    printInline(value, line);
    if (used + line.size() < kLine || value.items.empty()) {
      out += line;
      return;
    }
  }
  const bool object = value.kind == Json::Kind::Object;
  out += object ? "{\n" : "[\n";
  for (std::size_t k = 0; k < value.items.size(); ++k) {
    const std::size_t begin = out.size();
    out += std::string(indent + 2, ' ');
    if (object) out += asText(value.keys[k].name) + ": ";
    print(value.items[k], indent + 2, out.size() - begin, out);
    out += k + 1 < value.items.size() ? ",\n" : "\n";
  }
  out += std::string(indent, ' ') + (object ? '}' : ']');
}

}  // namespace

Json Json::number(std::string text) {
  Json value;
  value.kind = Kind::Number;
  value.text = std::move(text);
  return value;
}
Json Json::string(std::string text) {
  Json value;
  value.kind = Kind::String;
  value.text = std::move(text);
  return value;
}
Json Json::truth(bool value) {
  Json out;
  out.kind = Kind::Bool;
  out.boolean = value;
  return out;
}
Json Json::array(std::vector<Json> items) {
  Json value;
  value.kind = Kind::Array;
  value.items = std::move(items);
  return value;
}
Json Json::object() {
  Json value;
  value.kind = Kind::Object;
  return value;
}

const Json* Json::find(std::string_view key) const {
  const auto found = std::ranges::find(keys, key, &Key::name);
  return found == keys.end() ? nullptr : &items[static_cast<std::size_t>(found - keys.begin())];
}
Json* Json::find(std::string_view key) { return const_cast<Json*>(std::as_const(*this).find(key)); }

Json& Json::add(std::string key, Json value) {
  keys.push_back({std::move(key), {}});
  items.push_back(std::move(value));
  return *this;
}

std::string_view describe(Json::Kind kind) {
  switch (kind) {
    case Json::Kind::Null:
      return "null";
    case Json::Kind::Bool:
      return "true or false";
    case Json::Kind::Number:
      return "a number";
    case Json::Kind::String:
      return "a text";
    case Json::Kind::Array:
      return "a list";
    case Json::Kind::Object:
      return "an object";
  }
  return "null";
}

Result<Json> parseJson(std::string_view text, const std::string& file) {
  if (text.find_first_not_of(" \t\r\n") == std::string_view::npos) {
    return fail(ErrorCode::FileEmpty, "the file is empty", {.file = file});
  }
  TreeBuilder builder(text, file);
  const CountingIterator first(text.data(), builder.taken());
  const CountingIterator last(text.data() + text.size(), builder.taken());
  if (nlohmann::json::sax_parse(first, last, &builder)) return std::move(builder.root);
  return tl::unexpected<Error>(std::move(*builder.error));
}

std::string printJson(const Json& value) {
  std::string out;
  print(value, 0, 0, out);
  return out + "\n";
}

Json::Spot spotOf(const Json& root, std::string_view pointer) {
  const Json* at = &root;
  Json::Spot spot = root.spot;
  while (pointer.starts_with('/')) {
    pointer.remove_prefix(1);
    const std::string_view step = pointer.substr(0, pointer.find('/'));
    pointer.remove_prefix(step.size());
    const Json* next = nullptr;
    if (at->kind == Json::Kind::Object) {
      next = at->find(step);
    } else if (at->kind == Json::Kind::Array) {
      std::size_t index = 0;
      std::from_chars(step.data(), step.data() + step.size(), index);
      if (index < at->items.size()) next = &at->items[index];
    }
    if (next == nullptr) break;
    at = next;
    if (at->spot.line > 0) spot = at->spot;  // a migration's own values have none
  }
  return spot;
}

}  // namespace ecorche::model
