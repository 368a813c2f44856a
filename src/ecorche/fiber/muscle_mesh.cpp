#include <ecorche/core/contract.h>
#include <ecorche/fiber/muscle_mesh.h>

#include <algorithm>

namespace ecorche::fiber {

using mesh::kTetFace;
using mesh::Vector3;

Vector3 MuscleMesh::centroid(std::int64_t t) const {
  Vector3 sum = Vector3::Zero();
  for (int k = 0; k < 4; ++k) sum += mesh.V.row(mesh.T(t, k)).transpose();
  return 0.25 * sum;
}

std::vector<std::vector<std::int32_t>> tetsByTissue(const envelope::Anatomy& anatomy) {
  std::vector<std::vector<std::int32_t>> out;
  for (std::size_t t = 0; t < anatomy.label.size(); ++t) {
    const auto id = static_cast<std::size_t>(anatomy.label[t].value);
    if (id >= out.size()) out.resize(id + 1);
    out[id].push_back(static_cast<std::int32_t>(t));
  }
  return out;
}

std::vector<std::int32_t> placesInTissue(const std::vector<std::vector<std::int32_t>>& tets,
                                         std::size_t tetCount) {
  std::vector<std::int32_t> out(tetCount, -1);
  for (const auto& ofTissue : tets) {
    for (std::size_t i = 0; i < ofTissue.size(); ++i) {
      out[static_cast<std::size_t>(ofTissue[i])] = static_cast<std::int32_t>(i);
    }
  }
  return out;
}

std::vector<std::int32_t> boundaryOfSlot(const envelope::Anatomy& anatomy) {
  std::vector<std::int32_t> out(4 * anatomy.label.size(), -1);
  for (std::size_t f = 0; f < anatomy.boundaryTet.size(); ++f) {
    const std::int32_t t = anatomy.boundaryTet[f];
    for (int k = 0; k < 4; ++k) {
      // The corner that is not on the face
      const auto face = anatomy.boundaryF.row(static_cast<Eigen::Index>(f));
      const std::int32_t v = anatomy.mesh.T(t, k);
      if (face[0] != v && face[1] != v && face[2] != v) {
        out[4 * static_cast<std::size_t>(t) + static_cast<std::size_t>(k)] =
            static_cast<std::int32_t>(f);
      }
    }
  }
  return out;
}

namespace {

void labelComponents(MuscleMesh& m) {
  const auto tetCount = static_cast<std::size_t>(m.mesh.T.rows());
  m.component.assign(tetCount, -1);
  std::vector<std::int32_t> open;
  for (std::size_t seed = 0; seed < tetCount; ++seed) {
    if (m.component[seed] >= 0) continue;
    const auto id = static_cast<std::int32_t>(m.componentVolume.size());
    double volume = 0.0;
    m.component[seed] = id;
    open.push_back(static_cast<std::int32_t>(seed));
    while (!open.empty()) {
      const std::int32_t t = open.back();
      open.pop_back();
      volume += m.volume[t];
      for (int k = 0; k < 4; ++k) {
        const std::int32_t n = m.neighbours(t, k);
        if (n >= 0 && m.component[static_cast<std::size_t>(n)] < 0) {
          m.component[static_cast<std::size_t>(n)] = id;
          open.push_back(n);
        }
      }
    }
    m.componentVolume.push_back(volume);
  }
}

}  // namespace

MuscleMesh extractMuscle(const envelope::Anatomy& anatomy, TissueId tissue,
                         const std::vector<std::int32_t>& tets,
                         const std::vector<std::int32_t>& placeInTissue,
                         const std::vector<std::int32_t>& boundaryOf) {
  MuscleMesh m;
  m.tissue = tissue;
  m.tetId = tets;
  const auto tetCount = static_cast<Eigen::Index>(tets.size());

  // Vertices keep the anatomy's order, so that results do not depend on the order of tets
  std::vector<std::int32_t> local(static_cast<std::size_t>(anatomy.mesh.V.rows()), -1);
  for (const std::int32_t t : tets) {
    for (int k = 0; k < 4; ++k) local[static_cast<std::size_t>(anatomy.mesh.T(t, k))] = 0;
  }
  for (std::size_t v = 0; v < local.size(); ++v) {
    if (local[v] < 0) continue;
    local[v] = static_cast<std::int32_t>(m.vertexId.size());
    m.vertexId.push_back(static_cast<std::int32_t>(v));
  }
  m.mesh.V.resize(static_cast<Eigen::Index>(m.vertexId.size()), 3);
  for (std::size_t v = 0; v < m.vertexId.size(); ++v) {
    m.mesh.V.row(static_cast<Eigen::Index>(v)) = anatomy.mesh.V.row(m.vertexId[v]);
  }
  m.mesh.T.resize(tetCount, 4);
  m.volume.resize(tetCount);
  for (Eigen::Index t = 0; t < tetCount; ++t) {
    for (int k = 0; k < 4; ++k)
      m.mesh.T(t, k) =
          local[static_cast<std::size_t>(anatomy.mesh.T(tets[static_cast<std::size_t>(t)], k))];
    m.volume[t] = mesh::signedVolume(m.mesh, t);
  }

  // Neighbours inside the muscle; the rest is its surface
  m.neighbours.setConstant(tetCount, 4, -1);
  for (Eigen::Index t = 0; t < tetCount; ++t) {
    const std::int32_t global = tets[static_cast<std::size_t>(t)];
    for (int k = 0; k < 4; ++k) {
      const std::int32_t n = anatomy.neighbours(global, k);
      if (n >= 0 && anatomy.label[static_cast<std::size_t>(n)] == tissue) {
        m.neighbours(t, k) = placeInTissue[static_cast<std::size_t>(n)];
        continue;
      }
      MuscleFace face;
      for (int c = 0; c < 3; ++c) face.v[static_cast<std::size_t>(c)] = m.mesh.T(t, kTetFace[k][c]);
      face.tet = static_cast<std::int32_t>(t);
      if (n >= 0) {
        face.beyond = anatomy.label[static_cast<std::size_t>(n)];
      } else {
        face.boundary =
            boundaryOf[4 * static_cast<std::size_t>(global) + static_cast<std::size_t>(k)];
        EC_REQUIRE(face.boundary >= 0);
      }
      m.surface.push_back(face);
    }
  }
  labelComponents(m);
  return m;
}

}  // namespace ecorche::fiber
