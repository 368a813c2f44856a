#include <ecorche/core/byte_stream.h>
#include <ecorche/core/claim.h>
#include <ecorche/core/files.h>
#include <ecorche/domain/domain_cache.h>
#include <ecorche/domain/tagged_surface.h>
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

namespace ecorche::domain {

namespace fs = std::filesystem;

namespace {

constexpr std::uint32_t kMagic = 0x44434531;  // "1ECD"
constexpr std::int64_t kVersion = 11;         // raise with every change of what comes out
constexpr std::uintmax_t kCacheLimit = std::uintmax_t{4} << 30;

fs::path folder() { return cacheFolder() / "domains"; }

void hashMesh(Hasher& hash, const mesh::SurfaceMesh& mesh) {
  hash.text(mesh.name);
  hash.matrix(mesh.V);
  hash.matrix(mesh.F);
}

std::string checksum(std::string_view bytes) {
  Hasher hash;
  hash.bytes(bytes.data(), bytes.size());
  return hash.hex();
}

void put(ByteWriter& out, const Finding& f) {
  out.value(static_cast<std::int32_t>(f.severity));
  out.text(f.kind);
  out.text(f.object);
  out.text(f.message);
  out.value(static_cast<std::int32_t>(f.point.has_value()));
  out.matrix(f.point ? *f.point : Eigen::Vector3d(Eigen::Vector3d::Zero()));
  out.value(f.size);
}

Finding getFinding(ByteReader& in) {
  Finding f;
  f.severity = static_cast<Severity>(std::clamp(in.value<std::int32_t>(), 0, 3));
  f.kind = in.text();
  f.object = in.text();
  f.message = in.text();
  const bool has = in.value<std::int32_t>() != 0;
  const auto p = in.matrix<Eigen::Vector3d>();
  if (has) f.point = p;
  f.size = in.value<double>();
  return f;
}

template <class T>
Eigen::Matrix<T, Eigen::Dynamic, 1> asColumn(const std::vector<T>& v) {
  return Eigen::Map<const Eigen::Matrix<T, Eigen::Dynamic, 1>>(v.data(),
                                                               static_cast<Eigen::Index>(v.size()));
}
template <class T>
std::vector<T> getColumn(ByteReader& in) {
  const auto m = in.matrix<Eigen::Matrix<T, Eigen::Dynamic, 1>>();
  return std::vector<T>(m.data(), m.data() + m.size());
}

template <class Indices>
bool inRange(const Indices& indices, std::int64_t count, std::int32_t least = 0) {
  return indices.size() == 0 || (indices.minCoeff() >= least && indices.maxCoeff() < count);
}

// Sizes agree and every index names something
bool isWhole(const Domain& d) {
  const auto vertices = d.mesh.V.rows();
  const auto tets = d.mesh.T.rows();
  const auto faces = static_cast<std::size_t>(d.boundaryF.rows());
  return inRange(d.mesh.T, vertices) && d.neighbours.rows() == tets &&
         inRange(d.neighbours, tets, -1) && inRange(d.boundaryF, vertices) &&
         d.boundaryTet.size() == faces && d.boundaryTag.size() == faces &&
         std::ranges::all_of(d.boundaryTet, [&](std::int32_t t) { return t >= 0 && t < tets; }) &&
         d.onSkin.size() == static_cast<std::size_t>(vertices);
}

std::string encode(const DomainBuild& build) {
  const Domain& d = build.domain;
  const DomainReport& r = build.report;
  ByteWriter out;
  out.matrix(d.mesh.V);
  out.matrix(d.mesh.T);
  out.matrix(d.neighbours);
  out.matrix(d.boundaryF);
  out.matrix(asColumn(d.boundaryTet));
  std::vector<std::int32_t> tags;
  for (const BoundaryTag tag : d.boundaryTag) tags.push_back(packed(tag));
  out.matrix(asColumn(tags));
  out.matrix(asColumn(d.onSkin));
  for (const auto* names : {&d.boneNames, &d.cutPlaneNames}) {
    out.value(static_cast<std::uint64_t>(names->size()));
    for (const std::string& n : *names) out.text(n);
  }
  out.value(d.skinDiagonal);
  out.value(d.volume);
  out.value(static_cast<std::uint64_t>(r.findings.size()));
  for (const Finding& f : r.findings) put(out, f);
  out.value(static_cast<std::uint64_t>(r.deviations.size()));
  for (const SurfaceDeviation& s : r.deviations) {
    out.text(s.name);
    for (const double x : {s.maxFromInput, s.meanFromInput, s.maxToInput, s.meanToInput})
      out.value(x);
  }
  for (const double x : {r.maxDeviation, r.tolerance, r.volume, r.minDihedralDeg, r.maxDihedralDeg})
    out.value(x);
  for (const std::int64_t x :
       {r.requestedTets, r.tets, r.vertices, r.freeVertices, r.boundaryFaces, r.poorTets,
        r.bonesUsed, r.bonesLeftOut, static_cast<std::int64_t>(r.wraps),
        static_cast<std::int64_t>(r.components), static_cast<std::int64_t>(r.fallback)}) {
    out.value(x);
  }
  out.text(r.mesher);
  out.text(r.fallbackReason);
  return out.bytes();
}

std::optional<DomainBuild> decode(std::string_view bytes) {
  ByteReader in(bytes);
  DomainBuild out;
  Domain& d = out.domain;
  DomainReport& r = out.report;
  d.mesh.V = in.matrix<mesh::Positions>();
  d.mesh.T = in.matrix<mesh::Tets>();
  d.neighbours = in.matrix<mesh::TetNeighbours>();
  d.boundaryF = in.matrix<mesh::Triangles>();
  d.boundaryTet = getColumn<std::int32_t>(in);
  for (const std::int32_t code : getColumn<std::int32_t>(in))
    d.boundaryTag.push_back(unpacked(code));
  d.onSkin = getColumn<std::uint8_t>(in);
  for (auto* names : {&d.boneNames, &d.cutPlaneNames}) {
    const auto count = in.value<std::uint64_t>();
    for (std::uint64_t i = 0; i < count && in.ok(); ++i) names->push_back(in.text());
  }
  d.skinDiagonal = in.value<double>();
  d.volume = in.value<double>();
  const auto findingCount = in.value<std::uint64_t>();
  for (std::uint64_t i = 0; i < findingCount && in.ok(); ++i) r.findings.push_back(getFinding(in));
  const auto deviationCount = in.value<std::uint64_t>();
  for (std::uint64_t i = 0; i < deviationCount && in.ok(); ++i) {
    SurfaceDeviation s;
    s.name = in.text();
    for (double* x : {&s.maxFromInput, &s.meanFromInput, &s.maxToInput, &s.meanToInput})
      *x = in.value<double>();
    r.deviations.push_back(std::move(s));
  }
  for (double* x : {&r.maxDeviation, &r.tolerance, &r.volume, &r.minDihedralDeg, &r.maxDihedralDeg})
    *x = in.value<double>();
  for (std::int64_t* x : {&r.requestedTets, &r.tets, &r.vertices, &r.freeVertices, &r.boundaryFaces,
                          &r.poorTets, &r.bonesUsed, &r.bonesLeftOut}) {
    *x = in.value<std::int64_t>();
  }
  r.wraps = static_cast<int>(in.value<std::int64_t>());
  r.components = static_cast<int>(in.value<std::int64_t>());
  r.fallback = in.value<std::int64_t>() != 0;
  r.mesher = in.text();
  r.fallbackReason = in.text();
  r.fromCache = true;
  if (!in.finished() || !isWhole(d)) return std::nullopt;
  return out;
}

void keepWithinLimit() {
  struct Entry {
    fs::path path;
    fs::file_time_type time;
    std::uintmax_t size;
  };
  std::error_code ec;
  std::vector<Entry> entries;
  std::uintmax_t total = 0;
  for (const auto& e : fs::directory_iterator(folder(), ec)) {
    if (e.path().extension() != ".ecd") continue;
    const std::uintmax_t size = e.file_size(ec);
    if (ec) continue;
    entries.push_back({e.path(), e.last_write_time(ec), size});
    total += size;
  }
  std::ranges::sort(entries, {}, &Entry::time);
  for (const Entry& e : entries) {
    if (total <= kCacheLimit) break;
    fs::remove(e.path, ec);
    total -= e.size;
  }
}

}  // namespace

std::string cacheKey(const DomainInput& input, const DomainOptions& options) {
  Hasher hash;
  hash.number(kVersion);
  hashMesh(hash, input.skin);
  for (const auto* list : {&input.bones, &input.obstacles, &input.cavities}) {
    hash.number(static_cast<std::int64_t>(list->size()));
    for (const auto& m : *list) hashMesh(hash, m);
  }
  hash.number(static_cast<std::int64_t>(input.cutPlanes.size()));
  for (const CutPlane& p : input.cutPlanes) {
    hash.text(p.name);
    hash.matrix(p.point);
    hash.matrix(p.normal);
  }
  hash.number(static_cast<std::int64_t>(input.lengths.size()));
  for (const WantedLength& w : input.lengths) {
    hash.matrix(w.point);
    hash.number(w.length);
  }
  hash.number(options.tets.value_or(-1));
  hash.number(options.edgeLength.value_or(-1.0));
  hash.number(options.surfaceToleranceRel);
  hash.number(options.gradation);
  return hash.hex();
}

std::string sealed(std::string_view body) {
  ByteWriter out;
  out.value(kMagic);
  out.text(checksum(body));
  out.text(body);
  return out.bytes();
}

std::string encodeCached(const DomainBuild& build) { return sealed(encode(build)); }

std::optional<DomainBuild> decodeCached(std::string_view bytes) {
  ByteReader in(bytes);
  const bool ours = in.value<std::uint32_t>() == kMagic;
  const std::string sum = in.text();
  const std::string body = in.text();
  if (!ours || !in.finished() || checksum(body) != sum) return std::nullopt;
  return decode(body);
}

std::optional<DomainBuild> loadCached(const std::string& key, Findings& findings) {
  const fs::path file = folder() / (key + ".ecd");
  std::error_code ec;
  if (!fs::exists(file, ec)) return std::nullopt;
  const auto bytes = readFile(file);
  std::optional<DomainBuild> out;
  if (bytes) out = decodeCached(*bytes);
  if (!out) {
    fs::remove(file, ec);
    findings.push_back(
        {.severity = Severity::Warning,
         .kind = "cache-damaged",
         .message = fmt::format("{} was damaged; it was removed and the domain made anew",
                                file.string())});
    return std::nullopt;
  }
  fs::last_write_time(file, fs::file_time_type::clock::now(), ec);
  return out;
}

void storeCached(const std::string& key, const DomainBuild& build) {
  std::error_code ec;
  fs::create_directories(folder(), ec);
  removeUnclaimed(folder(), ".");  // of killed processes, whatever domain they were storing
  if (writeFileWhole(folder() / (key + ".ecd"), encodeCached(build))) keepWithinLimit();
}

}  // namespace ecorche::domain
