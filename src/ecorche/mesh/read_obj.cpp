#include <ecorche/mesh/read_lines.h>
#include <ecorche/mesh/read_obj.h>
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <unordered_map>

namespace ecorche::mesh {

namespace {

// Faces from here on belong to this object and group.
struct Run {
  std::size_t firstPolygon;
  std::string object;
  std::string group;
};

class ObjParser {
 public:
  ObjParser(std::string_view bytes, const std::string& file, RunContext& run)
      : lines_(bytes, file, LineReader::Continuation::Backslash), file_(file), run_(run) {
    soup_.xyz.reserve(bytes.size() / 24);
    soup_.corners.reserve(bytes.size() / 16);
    soup_.size.reserve(bytes.size() / 48);
  }

  Result<SurfaceMesh> parse() {
    LineWatch watch(lines_, run_);
    while (lines_.next()) {
      if (watch.cancelled()) return readingCancelled(file_);
      const std::string_view key = lines_.word();
      if (key == "v") {
        if (auto ok = readPoint(lines_, soup_.xyz); !ok) return passOn(ok);
      } else if (key == "f") {
        if (auto ok = face(); !ok) return passOn(ok);
      } else if (key == "o") {
        runs_.push_back({soup_.size.size(), std::string(lines_.rest()), ""});
      } else if (key == "g") {
        const std::string object = runs_.empty() ? "" : runs_.back().object;
        runs_.push_back({soup_.size.size(), object, std::string(lines_.rest())});
      } else if (std::isalpha(static_cast<unsigned char>(key[0])) == 0) {
        return lines_.fault("this is no line of an OBJ file");
      }
    }
    if (forward_.index > vertexCount()) {
      return fail(ErrorCode::FileSyntax, noSuchVertex(forward_.index),
                  {.file = file_, .line = forward_.line});
    }
    nameParts();
    return finishedMesh(soup_, file_);
  }

 private:
  [[nodiscard]] std::int64_t vertexCount() const {
    return static_cast<std::int64_t>(soup_.xyz.size() / 3);
  }
  [[nodiscard]] std::string noSuchVertex(std::int64_t index) const {
    return fmt::format("the face names vertex {}, but there are {}", index, vertexCount());
  }

  // Corners are v, v/vt, v//vn or v/vt/vn; only v matters.
  Result<void> face() {
    const std::size_t first = soup_.corners.size();
    for (std::string_view word = lines_.word(); !word.empty(); word = lines_.word()) {
      std::int64_t index = 0;
      const auto [end, ec] = std::from_chars(word.data(), word.data() + word.size(), index);
      if (ec != std::errc() || (end != word.data() + word.size() && *end != '/') || index == 0) {
        return lines_.fault(
            "a corner of a face should be a vertex number, counted from 1 or, negative, from the "
            "last");
      }
      if (index < 0) {
        index += vertexCount() + 1;
        if (index <= 0) return lines_.fault("the face counts back to before the first vertex");
      } else if (index > vertexCount()) {
        if (index > kMostElements) return lines_.fault(noSuchVertex(index));
        if (index > forward_.index) forward_ = {index, lines_.line()};
      }
      soup_.corners.push_back(static_cast<std::int32_t>(index - 1));
    }
    const std::size_t size = soup_.corners.size() - first;
    if (size < 3) return lines_.missing("three corners for a face");
    soup_.size.push_back(static_cast<std::int32_t>(size));
    return {};
  }

  void nameParts() {
    if (runs_.empty()) return;
    if (runs_.front().firstPolygon > 0) runs_.insert(runs_.begin(), {0, "", ""});
    const auto end = [&](std::size_t r) {
      return r + 1 < runs_.size() ? runs_[r + 1].firstPolygon : soup_.size.size();
    };

    // Objects name the parts if two of them have faces
    const std::string* object = nullptr;
    bool byObject = false;
    for (std::size_t r = 0; r < runs_.size(); ++r) {
      if (end(r) == runs_[r].firstPolygon) continue;
      if (object != nullptr && *object != runs_[r].object) byObject = true;
      object = &runs_[r].object;
    }

    std::unordered_map<std::string, std::int32_t> known;
    soup_.part.resize(soup_.size.size());
    for (std::size_t r = 0; r < runs_.size(); ++r) {
      const Run& run = runs_[r];
      std::string name = byObject || run.group.empty() ? run.object : run.group;
      if (name.empty()) name = "default";
      const auto [at, isNew] =
          known.try_emplace(name, static_cast<std::int32_t>(soup_.partNames.size()));
      if (isNew) soup_.partNames.push_back(name);
      std::fill(soup_.part.begin() + static_cast<std::ptrdiff_t>(run.firstPolygon),
                soup_.part.begin() + static_cast<std::ptrdiff_t>(end(r)), at->second);
    }
  }

  struct Forward {
    std::int64_t index = 0;  // the largest vertex number met before its vertex
    int line = 0;
  };

  LineReader lines_;
  const std::string& file_;
  RunContext& run_;
  PolygonSoup soup_;
  std::vector<Run> runs_;
  Forward forward_;
};

}  // namespace

Result<SurfaceMesh> parseObj(std::string_view bytes, const std::string& file, RunContext& run) {
  return ObjParser(bytes, file, run).parse();
}

}  // namespace ecorche::mesh
