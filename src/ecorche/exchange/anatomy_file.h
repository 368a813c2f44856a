#pragma once

#include <ecorche/core/ids.h>
#include <ecorche/mesh/tet_mesh.h>

#include <cstdint>
#include <string>
#include <vector>

namespace ecorche::exchange {

struct TissueName {
  std::int32_t id = 0;
  std::string name;
  auto operator<=>(const TissueName&) const = default;
};

/// What a triangle's reference number in a MEDIT file stands for.
struct FaceReference {
  std::int32_t reference = 0;  ///< from 1, without gaps
  std::string kind;            ///< "skin", "bone", "cut-plane", "obstacle", "cavity" or "interface"
  std::string name;   ///< of the bone, plane, …; of an interface the tissue on the inner side
  std::string other;  ///< of an interface the tissue on the outer side; empty otherwise
  std::int32_t index = 0;       ///< of the bone, plane …; of an interface the inner tissue's id
  std::int32_t otherIndex = 0;  ///< of an interface the outer tissue's id
  auto operator<=>(const FaceReference&) const = default;
};

/// The anatomy as a file carries it: the readers' answer, and what `check` looks at.
struct AnatomyFile {
  mesh::TetMesh mesh;
  std::vector<std::int32_t> tissue;  ///< #T
  std::vector<TissueName> names;     ///< ascending ids; empty where the format has none
  mesh::Directions tetFiber;         ///< #T×3; no rows where the format has none
  mesh::Directions vertexFiber;      ///< #V×3; no rows where the format has none
  std::vector<std::uint8_t> tendon;  ///< #T; empty where there is none
  mesh::Triangles F;  ///< boundary and interface triangles; no rows where the format has none
  std::vector<std::int32_t> reference;  ///< #F
};

}  // namespace ecorche::exchange
