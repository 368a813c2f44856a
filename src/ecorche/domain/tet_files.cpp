#include <ecorche/core/byte_stream.h>
#include <ecorche/domain/tet_files.h>

#include <algorithm>

namespace ecorche::domain {

namespace {

using TagVector = Eigen::Matrix<std::int32_t, Eigen::Dynamic, 1>;

void write(ByteWriter& out, const std::vector<std::int32_t>& tags) {
  out.matrix(
      Eigen::Map<const TagVector>(tags.data(), static_cast<Eigen::Index>(tags.size())).eval());
}

std::vector<std::int32_t> readTags(ByteReader& in) {
  const auto tags = in.matrix<TagVector>();
  return {tags.data(), tags.data() + tags.size()};
}

void write(ByteWriter& out, const TaggedSurface& surface) {
  out.matrix(surface.V);
  out.matrix(surface.F);
  write(out, surface.tag);
}

TaggedSurface readSurface(ByteReader& in) {
  TaggedSurface surface;
  surface.V = in.matrix<mesh::Positions>();
  surface.F = in.matrix<mesh::Triangles>();
  surface.tag = readTags(in);
  return surface;
}

template <class Indices>
bool inRange(const Indices& indices, Eigen::Index count) {
  return indices.size() == 0 || (indices.minCoeff() >= 0 && indices.maxCoeff() < count);
}

bool inRange(const TaggedSurface& surface) {
  return inRange(surface.F, surface.V.rows()) &&
         surface.tag.size() == static_cast<std::size_t>(surface.F.rows());
}

constexpr const char* kTruncated = "the file between us and ecorche-worker is not whole";
constexpr const char* kBadIndex = "the file between us and ecorche-worker holds wrong indices";

}  // namespace

std::string encodeTetRequest(const TetRequest& request) {
  ByteWriter out;
  write(out, request.surface);
  out.matrix(request.points);
  out.matrix(request.holes);
  out.text(request.switches);
  return out.bytes();
}

std::string encodeFillRequest(const FillRequest& request) {
  ByteWriter out;
  write(out, request.surface);
  out.value(static_cast<std::uint64_t>(request.cutPlanes.size()));
  for (const CutPlane& plane : request.cutPlanes) {
    out.text(plane.name);
    out.matrix(plane.point);
    out.matrix(plane.normal);
  }
  request.sizing.write(out);
  out.value(request.scale);
  out.value(request.tolerance);
  return out.bytes();
}

std::string encodeTetAnswer(const TetAnswer& answer) {
  ByteWriter out;
  out.matrix(answer.V);
  out.matrix(answer.T);
  out.matrix(answer.F);
  write(out, answer.tag);
  return out.bytes();
}

Result<TetRequest> decodeTetRequest(std::string_view bytes) {
  ByteReader in(bytes);
  TetRequest request;
  request.surface = readSurface(in);
  request.points = in.matrix<mesh::Positions>();
  request.holes = in.matrix<mesh::Positions>();
  request.switches = in.text();
  if (!in.finished()) return fail(ErrorCode::FileTruncated, kTruncated);
  if (!inRange(request.surface)) return fail(ErrorCode::FileSyntax, kBadIndex);
  return request;
}

Result<FillRequest> decodeFillRequest(std::string_view bytes) {
  ByteReader in(bytes);
  FillRequest request;
  request.surface = readSurface(in);
  for (auto left = in.value<std::uint64_t>(); left > 0 && in.ok(); --left) {
    CutPlane& plane = request.cutPlanes.emplace_back();
    plane.name = in.text();
    plane.point = in.matrix<mesh::Vector3>();
    plane.normal = in.matrix<mesh::Vector3>();
  }
  request.sizing = SizingField::read(in);
  request.scale = in.value<double>();
  request.tolerance = in.value<double>();
  if (!in.finished()) return fail(ErrorCode::FileTruncated, kTruncated);
  const bool planesKnown = std::ranges::all_of(request.surface.tag, [&](std::int32_t tag) {
    const BoundaryTag of = unpacked(tag);
    return of.kind != BoundaryTag::Kind::CutPlane ||
           static_cast<std::size_t>(of.index) < request.cutPlanes.size();
  });
  if (!inRange(request.surface) || !planesKnown) return fail(ErrorCode::FileSyntax, kBadIndex);
  return request;
}

Result<TetAnswer> decodeTetAnswer(std::string_view bytes) {
  ByteReader in(bytes);
  TetAnswer answer;
  answer.V = in.matrix<mesh::Positions>();
  answer.T = in.matrix<mesh::Tets>();
  answer.F = in.matrix<mesh::Triangles>();
  answer.tag = readTags(in);
  if (!in.finished()) return fail(ErrorCode::FileTruncated, kTruncated);
  if (!inRange(answer.T, answer.V.rows()) || !inRange(answer.F, answer.V.rows()) ||
      answer.tag.size() != static_cast<std::size_t>(answer.F.rows())) {
    return fail(ErrorCode::FileSyntax, kBadIndex);
  }
  return answer;
}

}  // namespace ecorche::domain
