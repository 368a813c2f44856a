#include <ecorche/model/migrations.h>

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

namespace ecorche::model {

std::span<const Migration> migrations() { return {}; }

Result<void> migrate(Json& root, int newest, std::span<const Migration> steps,
                     const std::string& file) {
  const auto at = [&](Json::Spot spot) {
    return Place{.file = file, .line = spot.line, .column = spot.column};
  };
  if (root.kind != Json::Kind::Object) {
    return fail(ErrorCode::WrongType,
                fmt::format("a project is an object, this is {}", describe(root.kind)),
                at(root.spot));
  }
  Json* const schema = root.find("schema");
  if (schema == nullptr) {
    return fail(ErrorCode::MissingKey,
                fmt::format("\"schema\" is missing; this program writes \"schema\": {}", newest),
                at(root.spot));
  }
  int version = 0;
  const char* const end = schema->text.data() + schema->text.size();
  if (schema->kind != Json::Kind::Number) {
    return fail(ErrorCode::WrongType,
                fmt::format("\"schema\" is {}; it must be a whole number", describe(schema->kind)),
                at(schema->spot));
  }
  if (std::from_chars(schema->text.data(), end, version).ptr != end || version < 1) {
    return fail(ErrorCode::ValueOutOfRange,
                fmt::format("there is no schema {}; they count from 1", schema->text),
                at(schema->spot));
  }
  if (version > newest) {
    return fail(ErrorCode::SchemaTooNew,
                fmt::format("the project was written by a newer program (schema {}, this one knows "
                            "{}); update this program",
                            version, newest),
                at(schema->spot));
  }
  for (; version < newest; ++version) {
    const auto step = std::ranges::find(steps, version, &Migration::from);
    if (step == steps.end()) {
      return fail(ErrorCode::Internal,
                  fmt::format("no way leads from schema {} to {}", version, version + 1),
                  at(schema->spot));
    }
    if (auto done = step->apply(root); !done) {
      Error error = done.error();
      error.place.file = file;
      return tl::unexpected<Error>(std::move(error));
    }
  }
  if (Json* const now = root.find("schema")) now->text = std::to_string(newest);
  return {};
}

}  // namespace ecorche::model
