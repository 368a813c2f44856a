#include <ecorche/core/byte_stream.h>
#include <ecorche/mesh/import_file.h>
#include <fmt/format.h>

namespace ecorche::mesh {

namespace {
constexpr std::uint64_t kMagic = 0x31304d4948434345;  // "ECCHIM01"
}

std::string encodeImport(const SurfaceMesh& mesh) {
  ByteWriter out;
  out.value(kMagic);
  out.text(mesh.name);
  out.matrix(mesh.V);
  out.matrix(mesh.F);
  out.value(static_cast<std::uint64_t>(mesh.parts.size()));
  for (const Part& part : mesh.parts) {
    out.text(part.name);
    out.value(part.firstFace);
    out.value(part.faceCount);
  }
  out.value(kMagic);
  return out.bytes();
}

Result<SurfaceMesh> decodeImport(std::string_view bytes) {
  ByteReader in(bytes);
  const bool ours = in.value<std::uint64_t>() == kMagic;
  SurfaceMesh mesh;
  mesh.name = in.text();
  mesh.V = in.matrix<Positions>();
  mesh.F = in.matrix<Triangles>();
  const auto partCount = in.value<std::uint64_t>();
  for (std::uint64_t p = 0; p < partCount && in.ok(); ++p) {
    Part part;
    part.name = in.text();
    part.firstFace = in.value<std::int32_t>();
    part.faceCount = in.value<std::int32_t>();
    mesh.parts.push_back(std::move(part));
  }
  if (in.value<std::uint64_t>() != kMagic || !ours || !in.finished()) {
    return fail(ErrorCode::FileTruncated, "ecorche-worker left an incomplete result");
  }

  const auto vertexCount = static_cast<std::int32_t>(mesh.V.rows());
  if (mesh.F.size() > 0 && (mesh.F.minCoeff() < 0 || mesh.F.maxCoeff() >= vertexCount)) {
    return fail(ErrorCode::FileSyntax, "a face names a vertex that does not exist");
  }
  std::int64_t next = 0;
  for (const Part& part : mesh.parts) {
    if (part.firstFace != next || part.faceCount < 0) {
      return fail(ErrorCode::FileSyntax,
                  fmt::format("part {} does not follow its neighbour", part.name));
    }
    next += part.faceCount;
  }
  if (!mesh.parts.empty() && next != mesh.F.rows()) {
    return fail(ErrorCode::FileSyntax, "parts do not cover the faces");
  }
  return mesh;
}

}  // namespace ecorche::mesh
