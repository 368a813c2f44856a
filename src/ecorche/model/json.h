#pragma once

#include <ecorche/core/result.h>

#include <string>
#include <string_view>
#include <vector>

namespace ecorche::model {

/// A JSON value that knows where in its file it began. Numbers keep their text, so that no digit is
/// lost on the way through a unit; objects keep the order of their keys.
struct Json {
  enum class Kind { Null, Bool, Number, String, Array, Object };
  struct Spot {
    int line = 0;    ///< from 1; 0: not from a file
    int column = 0;  ///< from 1, in characters
  };
  struct Key {
    std::string name;
    Spot spot;
  };

  Kind kind = Kind::Null;
  bool boolean = false;
  std::string text;         ///< of a string, or of a number as it stands in the file
  std::vector<Json> items;  ///< of an array; of an object beside its keys
  std::vector<Key> keys;    ///< of an object
  Spot spot;

  [[nodiscard]] static Json number(std::string text);
  [[nodiscard]] static Json string(std::string text);
  [[nodiscard]] static Json truth(bool value);
  [[nodiscard]] static Json array(std::vector<Json> items = {});
  [[nodiscard]] static Json object();

  /// Value under a key of an object; null where there is none or this is no object.
  [[nodiscard]] const Json* find(std::string_view key) const;
  [[nodiscard]] Json* find(std::string_view key);
  /// Appends a key. @returns this
  Json& add(std::string key, Json value);
};

/// "an object", "a number" … for messages.
[[nodiscard]] std::string_view describe(Json::Kind kind);

/// Reads one JSON value; nothing may follow it. A byte order mark is skipped; nesting ends at 64.
/// @param file  for the place in errors only
/// @errors FileEmpty, FileTruncated (the text ends too early), FileSyntax, DuplicateName (a key
/// given twice)
[[nodiscard]] Result<Json> parseJson(std::string_view text, const std::string& file);

/// Two spaces of indentation; what fits on a line of 100 characters and holds no list of objects
/// stays on one line.
[[nodiscard]] std::string printJson(const Json& value);

/// Where a JSON pointer ("/tissues/3/curves/0") leads; as far as it goes, where its end does not
/// exist.
[[nodiscard]] Json::Spot spotOf(const Json& root, std::string_view pointer);

}  // namespace ecorche::model
