#include <ecorche/core/contract.h>
#include <ecorche/core/parallel.h>
#include <ecorche/envelope/tissue_surface.h>

#include <Eigen/Dense>
#include <algorithm>
#include <map>
#include <numeric>

namespace ecorche::envelope {

std::vector<TissueSurface> tissueSurfaces(const Anatomy& anatomy,
                                          const std::vector<std::string>& names) {
  const auto tetCount = static_cast<std::size_t>(anatomy.mesh.T.rows());
  std::vector<std::array<std::int32_t, 4>> boundaryAt(tetCount, {-1, -1, -1, -1});
  for (std::size_t b = 0; b < anatomy.boundaryTet.size(); ++b) {
    const std::int32_t t = anatomy.boundaryTet[b];
    for (int k = 0; k < 4; ++k) {
      const std::int32_t opposite = anatomy.mesh.T(t, k);
      if ((anatomy.boundaryF.row(static_cast<Eigen::Index>(b)).array() != opposite).all()) {
        boundaryAt[static_cast<std::size_t>(t)][static_cast<std::size_t>(k)] =
            static_cast<std::int32_t>(b);
      }
    }
  }
  std::vector<std::vector<std::int32_t>> slots(names.size());  // 4·tet + corner by tissue
  for (std::size_t t = 0; t < tetCount; ++t) {
    const TissueId own = anatomy.label[t];
    EC_REQUIRE(own.value >= 1 && static_cast<std::size_t>(own.value) <= names.size());
    for (int k = 0; k < 4; ++k) {
      const std::int32_t n = anatomy.neighbours(static_cast<Eigen::Index>(t), k);
      if (n < 0 || anatomy.label[static_cast<std::size_t>(n)] != own) {
        slots[static_cast<std::size_t>(own.value - 1)].push_back(static_cast<std::int32_t>(4 * t) +
                                                                 k);
      }
    }
  }

  std::vector<TissueSurface> out(names.size());
  parallelFor(
      static_cast<std::int64_t>(names.size()),
      [&](std::int64_t i) {
        TissueSurface& s = out[static_cast<std::size_t>(i)];
        const auto& mine = slots[static_cast<std::size_t>(i)];
        s.tissue = TissueId(i + 1);
        s.mesh.name = names[static_cast<std::size_t>(i)];
        s.mesh.F.resize(static_cast<Eigen::Index>(mine.size()), 3);
        for (std::size_t f = 0; f < mine.size(); ++f) {
          for (int c = 0; c < 3; ++c) {
            s.vertex.push_back(anatomy.mesh.T(mine[f] / 4, mesh::kTetFace[mine[f] % 4][c]));
          }
        }
        std::vector<std::int32_t> corner = s.vertex;
        std::ranges::sort(s.vertex);
        s.vertex.erase(std::unique(s.vertex.begin(), s.vertex.end()), s.vertex.end());
        s.mesh.V.resize(static_cast<Eigen::Index>(s.vertex.size()), 3);
        for (std::size_t v = 0; v < s.vertex.size(); ++v) {
          s.mesh.V.row(static_cast<Eigen::Index>(v)) = anatomy.mesh.V.row(s.vertex[v]);
        }
        for (std::size_t f = 0; f < mine.size(); ++f) {
          for (std::size_t c = 0; c < 3; ++c) {
            const auto at = std::ranges::lower_bound(s.vertex, corner[3 * f + c]);
            s.mesh.F(static_cast<Eigen::Index>(f), static_cast<Eigen::Index>(c)) =
                static_cast<std::int32_t>(at - s.vertex.begin());
          }
          const std::int32_t t = mine[f] / 4;
          const int k = mine[f] % 4;
          s.tet.push_back(t);
          const std::int32_t n = anatomy.neighbours(t, k);
          Beyond beyond{kNoTissue, {}};
          if (n >= 0) {
            beyond.tissue = anatomy.label[static_cast<std::size_t>(n)];
          } else {
            const std::int32_t b =
                boundaryAt[static_cast<std::size_t>(t)][static_cast<std::size_t>(k)];
            beyond.tag = anatomy.boundaryTag[static_cast<std::size_t>(b)];
          }
          s.beyond.push_back(beyond);
        }
      },
      1);
  return out;
}

std::vector<Attachment> attachmentsOf(const TissueSurface& surface) {
  std::map<domain::BoundaryTag, Attachment> byTag;
  for (std::size_t f = 0; f < surface.beyond.size(); ++f) {
    const Beyond& beyond = surface.beyond[f];
    using Kind = domain::BoundaryTag::Kind;
    if (beyond.tissue != kNoTissue) continue;
    if (beyond.tag.kind != Kind::Bone && beyond.tag.kind != Kind::CutPlane) continue;
    const auto row = static_cast<Eigen::Index>(f);
    const mesh::Vector3 a = surface.mesh.V.row(surface.mesh.F(row, 0)).transpose();
    const mesh::Vector3 b = surface.mesh.V.row(surface.mesh.F(row, 1)).transpose();
    const mesh::Vector3 c = surface.mesh.V.row(surface.mesh.F(row, 2)).transpose();
    const double area = 0.5 * (b - a).cross(c - a).norm();
    Attachment& patch = byTag[beyond.tag];
    patch.tag = beyond.tag;
    patch.area += area;
    patch.centroid += area * (a + b + c) / 3.0;
  }
  std::vector<Attachment> out;
  for (auto& [tag, patch] : byTag) {
    if (patch.area > 0.0) patch.centroid /= patch.area;
    out.push_back(patch);
  }
  return out;
}

std::vector<TissueMeasure> measureTissues(const Anatomy& anatomy, std::size_t tissueCount) {
  std::vector<TissueMeasure> out(tissueCount);
  const Eigen::VectorXd volume = mesh::signedVolumes(anatomy.mesh);
  std::vector<std::uint8_t> seen(static_cast<std::size_t>(anatomy.mesh.T.rows()), 0);
  std::vector<std::int32_t> stack;
  for (std::int32_t t = 0; t < anatomy.mesh.T.rows(); ++t) {
    TissueMeasure& m =
        out[static_cast<std::size_t>(anatomy.label[static_cast<std::size_t>(t)].value - 1)];
    m.volume += volume[t];
    ++m.tets;
    if (seen[static_cast<std::size_t>(t)] != 0) continue;
    ++m.components;
    stack.assign(1, t);
    seen[static_cast<std::size_t>(t)] = 1;
    while (!stack.empty()) {
      const std::int32_t a = stack.back();
      stack.pop_back();
      for (int k = 0; k < 4; ++k) {
        const std::int32_t n = anatomy.neighbours(a, k);
        if (n < 0 || seen[static_cast<std::size_t>(n)] != 0 ||
            anatomy.label[static_cast<std::size_t>(n)] !=
                anatomy.label[static_cast<std::size_t>(a)]) {
          continue;
        }
        seen[static_cast<std::size_t>(n)] = 1;
        stack.push_back(n);
      }
    }
  }
  return out;
}

mesh::Directions fieldNormals(const TissueSurface& surface, const Anatomy& anatomy,
                              const domain::Domain& domain, const tissue::TissueFields& fields) {
  mesh::Directions normals = mesh::vertexNormals(surface.mesh.V, surface.mesh.F);
  if (surface.mesh.empty()) return normals;
  const auto own = static_cast<Eigen::Index>(surface.tissue.value - 1);

  // Gradients of f_own averaged to the domain's vertices around the surface, and those of its
  // neighbours, on demand
  const mesh::VertexTets around = mesh::vertexTets(domain.mesh.T, domain.mesh.V.rows());
  std::map<std::pair<std::int32_t, Eigen::Index>, mesh::Vector3> cache;
  const auto gradientAt = [&](std::int32_t v, Eigen::Index column) -> const mesh::Vector3& {
    const auto known = cache.find({v, column});
    if (known != cache.end()) return known->second;
    mesh::Vector3 sum = mesh::Vector3::Zero();
    double weight = 0.0;
    for (std::int32_t i = around.first[static_cast<std::size_t>(v)];
         i < around.first[static_cast<std::size_t>(v) + 1]; ++i) {
      const std::int32_t t = around.tet[static_cast<std::size_t>(i)];
      Eigen::Matrix3d edges;
      Eigen::Vector3d rise;
      const mesh::Vector3 a = domain.mesh.V.row(domain.mesh.T(t, 0)).transpose();
      for (int c = 1; c < 4; ++c) {
        edges.row(c - 1) = domain.mesh.V.row(domain.mesh.T(t, c)) - a.transpose();
        rise[c - 1] =
            fields.values(domain.mesh.T(t, c), column) - fields.values(domain.mesh.T(t, 0), column);
      }
      const double volume = std::abs(edges.determinant());
      const mesh::Vector3 g = edges.inverse() * rise;
      if (!g.allFinite()) continue;
      sum += volume * g;
      weight += volume;
    }
    if (weight > 0.0) sum /= weight;
    return cache.emplace(std::pair{v, column}, sum).first->second;
  };

  // At each vertex: the mean over its interface faces' neighbours, weighted by the faces' angle
  // through their count
  std::vector<mesh::Vector3> sum(surface.vertex.size(), mesh::Vector3::Zero());
  std::vector<std::uint8_t> onBoundary(surface.vertex.size(), 0);
  const auto offset = static_cast<std::int32_t>(domain.mesh.V.rows());
  for (std::size_t f = 0; f < surface.beyond.size(); ++f) {
    const auto row = static_cast<Eigen::Index>(f);
    for (int c = 0; c < 3; ++c) {
      const auto local = static_cast<std::size_t>(surface.mesh.F(row, c));
      if (surface.beyond[f].tissue == kNoTissue) {
        onBoundary[local] = 1;
        continue;
      }
      const auto other = static_cast<Eigen::Index>(surface.beyond[f].tissue.value - 1);
      const std::int32_t v = surface.vertex[local];
      mesh::Vector3 g = mesh::Vector3::Zero();
      if (v < offset) {
        g = gradientAt(v, other) - gradientAt(v, own);
      } else {
        const auto& origin = anatomy.origin[static_cast<std::size_t>(v - offset)];
        for (std::size_t k = 0; k < 4; ++k) {
          if (origin.corner[k] >= 0) {
            g += origin.weight[k] *
                 (gradientAt(origin.corner[k], other) - gradientAt(origin.corner[k], own));
          }
        }
      }
      const double length = g.norm();
      if (length > 0.0) sum[local] += g / length;
    }
  }
  for (std::size_t v = 0; v < sum.size(); ++v) {
    const double length = sum[v].norm();
    // Where the surface meets bone or skin its own normal counts too; a normal that disagrees with
    // the facets is not used
    if (onBoundary[v] != 0 || length == 0.0) continue;
    const mesh::Vector3 n = sum[v] / length;
    if (n.dot(normals.row(static_cast<Eigen::Index>(v)).transpose()) > 0.2) {
      normals.row(static_cast<Eigen::Index>(v)) = n.transpose();
    }
  }
  return normals;
}

}  // namespace ecorche::envelope
