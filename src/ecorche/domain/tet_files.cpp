#include <ecorche/core/byte_stream.h>
#include <ecorche/domain/tet_files.h>

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

template <class Indices>
bool inRange(const Indices& indices, Eigen::Index count) {
  return indices.size() == 0 || (indices.minCoeff() >= 0 && indices.maxCoeff() < count);
}

constexpr const char* kTruncated = "the file between us and ecorche-worker is not whole";
constexpr const char* kBadIndex = "the file between us and ecorche-worker holds wrong indices";

}  // namespace

std::string encodeTetRequest(const TetRequest& request) {
  ByteWriter out;
  out.matrix(request.surface.V);
  out.matrix(request.surface.F);
  write(out, request.surface.tag);
  out.matrix(request.points);
  out.matrix(request.holes);
  out.text(request.switches);
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
  request.surface.V = in.matrix<mesh::Positions>();
  request.surface.F = in.matrix<mesh::Triangles>();
  request.surface.tag = readTags(in);
  request.points = in.matrix<mesh::Positions>();
  request.holes = in.matrix<mesh::Positions>();
  request.switches = in.text();
  if (!in.finished()) return fail(ErrorCode::FileTruncated, kTruncated);
  if (!inRange(request.surface.F, request.surface.V.rows()) ||
      request.surface.tag.size() != static_cast<std::size_t>(request.surface.F.rows())) {
    return fail(ErrorCode::FileSyntax, kBadIndex);
  }
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
