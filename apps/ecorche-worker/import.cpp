// SPDX-License-Identifier: AGPL-3.0-or-later

#include <assimp/mesh.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <ecorche/core/files.h>
#include <ecorche/mesh/import_file.h>
#include <fmt/format.h>

#include <assimp/Importer.hpp>
#include <limits>
#include <utility>
#include <vector>

#include "worker.h"

namespace ecorche::worker {

namespace {

// One mesh of one node, where the node stands in the world.
struct Placed {
  const aiMesh* mesh;
  aiMatrix4x4 toWorld;
  std::string name;
};

std::string partName(const aiNode& node, const aiMesh& mesh) {
  // A node with several meshes is one object with several materials: keep them apart by the meshes'
  // names
  const std::string ofNode = node.mName.C_Str();
  const std::string ofMesh = mesh.mName.C_Str();
  if (ofNode.empty()) return ofMesh;
  return node.mNumMeshes > 1 && !ofMesh.empty() && ofMesh != ofNode ? ofNode + "/" + ofMesh
                                                                    : ofNode;
}

std::vector<Placed> placedMeshes(const aiScene& scene) {
  std::vector<Placed> placed;
  std::vector<std::pair<const aiNode*, aiMatrix4x4>> open{{scene.mRootNode, aiMatrix4x4()}};
  while (!open.empty()) {
    const auto [node, parent] = open.back();
    open.pop_back();
    const aiMatrix4x4 toWorld = parent * node->mTransformation;
    for (unsigned i = 0; i < node->mNumMeshes; ++i) {
      const aiMesh* mesh = scene.mMeshes[node->mMeshes[i]];
      placed.push_back({mesh, toWorld, partName(*node, *mesh)});
    }
    for (unsigned c = node->mNumChildren; c-- > 0;) open.emplace_back(node->mChildren[c], toWorld);
  }
  return placed;
}

// Appends the triangles of one mesh; points and lines are left out.
void append(const Placed& placed, std::vector<double>& xyz, std::vector<std::int32_t>& corners) {
  const auto first = static_cast<std::int32_t>(xyz.size() / 3);
  const aiMatrix4x4& m = placed.toWorld;
  for (unsigned v = 0; v < placed.mesh->mNumVertices; ++v) {
    const aiVector3D& p = placed.mesh->mVertices[v];
    const double x = p.x, y = p.y, z = p.z;
    xyz.push_back(m.a1 * x + m.a2 * y + m.a3 * z + m.a4);
    xyz.push_back(m.b1 * x + m.b2 * y + m.b3 * z + m.b4);
    xyz.push_back(m.c1 * x + m.c2 * y + m.c3 * z + m.c4);
  }
  // A mirroring node turns its triangles inside out
  const bool mirrored = m.Determinant() < 0;
  for (unsigned f = 0; f < placed.mesh->mNumFaces; ++f) {
    const aiFace& face = placed.mesh->mFaces[f];
    if (face.mNumIndices != 3) continue;
    for (const int k : {0, mirrored ? 2 : 1, mirrored ? 1 : 2}) {
      corners.push_back(first + static_cast<std::int32_t>(face.mIndices[k]));
    }
  }
}

}  // namespace

Result<void> importMesh(const Arguments& arguments) {
  if (arguments.size() != 2) return fail(ErrorCode::Internal, "usage: import INPUT OUTPUT");
  Assimp::Importer importer;
  // Geometry only: everything else a scene holds is dropped before it costs anything
  importer.SetPropertyInteger(
      AI_CONFIG_PP_RVC_FLAGS,
      aiComponent_NORMALS | aiComponent_TANGENTS_AND_BITANGENTS | aiComponent_COLORS |
          aiComponent_TEXCOORDS | aiComponent_BONEWEIGHTS | aiComponent_ANIMATIONS |
          aiComponent_TEXTURES | aiComponent_LIGHTS | aiComponent_CAMERAS | aiComponent_MATERIALS);
  const aiScene* scene = importer.ReadFile(
      arguments[0], aiProcess_RemoveComponent | aiProcess_Triangulate |
                        aiProcess_JoinIdenticalVertices | aiProcess_ValidateDataStructure);
  if (scene == nullptr || scene->mRootNode == nullptr) {
    return fail(ErrorCode::FileSyntax,
                fmt::format("the file cannot be read: {}", importer.GetErrorString()));
  }

  std::vector<double> xyz;
  std::vector<std::int32_t> corners;
  mesh::SurfaceMesh out;
  out.name = scene->mName.C_Str();
  for (const Placed& placed : placedMeshes(*scene)) {
    const std::size_t firstFace = corners.size() / 3;
    constexpr std::size_t kMost = std::numeric_limits<std::int32_t>::max();
    if (xyz.size() / 3 + placed.mesh->mNumVertices > kMost ||
        firstFace + placed.mesh->mNumFaces > kMost) {
      return fail(ErrorCode::OutOfMemory, "the file places more than 2 thousand million triangles");
    }
    append(placed, xyz, corners);
    const std::size_t faceCount = corners.size() / 3 - firstFace;
    if (faceCount == 0) continue;
    out.parts.push_back(
        {placed.name, static_cast<std::int32_t>(firstFace), static_cast<std::int32_t>(faceCount)});
  }
  out.V =
      Eigen::Map<const mesh::Positions>(xyz.data(), static_cast<Eigen::Index>(xyz.size() / 3), 3);
  out.F = Eigen::Map<const mesh::Triangles>(corners.data(),
                                            static_cast<Eigen::Index>(corners.size() / 3), 3);
  return writeFileWhole(arguments[1], mesh::encodeImport(out));
}

}  // namespace ecorche::worker
