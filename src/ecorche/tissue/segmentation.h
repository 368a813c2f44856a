#pragma once

#include <ecorche/tissue/tissue_fields.h>

#include <vector>

namespace ecorche::tissue {

/// The tissue that owns a point where the fields have the given values: the largest [ABLSJ21 §3.5].
///
/// Ties are decided once for the whole program: field i counts as f_i + ε_i with ε_2 ≫ ε_3 ≫ … ≫
/// ε_fat, so of equal fields the muscle of lowest id wins and fat always loses.
///
/// @param f  one value per column of TissueFields::values: fat, then ids from 2
template <class Values>
[[nodiscard]] TissueId ownerOf(const Values& f, bool fatIsCandidate) {
  Eigen::Index best = -1;
  for (Eigen::Index i = 1; i < f.size(); ++i) {
    if (best < 0 || f[i] > f[best]) best = i;
  }
  if (best < 0 || (fatIsCandidate && f[0] > f[best])) best = 0;
  return TissueId(best + 1);
}

/// Owner of every vertex, #V.
[[nodiscard]] std::vector<TissueId> vertexOwners(const TissueFields& fields);

/// Owner of a point given by a tet and barycentric coordinates in it.
[[nodiscard]] TissueId ownerAt(const mesh::TetMesh& mesh, const TissueFields& fields,
                               Eigen::Index tet, const Eigen::Vector4d& barycentric);

/// Volume of every tissue [m³], by id − 1: fat first. Exact for fields that are linear in every
/// tet: the tets are cut where another field takes over.
[[nodiscard]] std::vector<double> tissueVolumes(const mesh::TetMesh& mesh,
                                                const TissueFields& fields);

/// The same of one tissue alone, in a tenth of the time and less.
/// @param owner  of every vertex, as vertexOwners gives
[[nodiscard]] double tissueVolume(const mesh::TetMesh& mesh, const TissueFields& fields,
                                  const std::vector<TissueId>& owner, TissueId tissue);

}  // namespace ecorche::tissue
