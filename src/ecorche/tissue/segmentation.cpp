#include <ecorche/core/parallel.h>
#include <ecorche/tissue/segmentation.h>

#include <Eigen/LU>
#include <algorithm>
#include <array>

namespace ecorche::tissue {

namespace {

// A tet inside a tet, by barycentric coordinates of its corners.
using SubTet = std::array<Eigen::Vector4d, 4>;

double volumeShare(const SubTet& tet) {
  Eigen::Matrix4d M;
  for (int k = 0; k < 4; ++k) M.col(k) = tet[static_cast<std::size_t>(k)];
  return std::abs(M.determinant());
}

constexpr double kNothing = 1e-14;  // of a tet's volume

// The part of a tet where a linear function with values g at the outer tet's corners is positive,
// as at most three tets
void keepPositive(const SubTet& tet, const Eigen::Vector4d& g, std::vector<SubTet>& out) {
  std::array<double, 4> at{};
  std::array<std::size_t, 4> in{};
  std::array<std::size_t, 4> outside{};
  std::size_t inCount = 0;
  std::size_t outCount = 0;
  for (std::size_t k = 0; k < 4; ++k) {
    at[k] = g.dot(tet[k]);
    if (at[k] > 0.0) {
      in[inCount++] = k;
    } else {
      outside[outCount++] = k;
    }
  }
  const auto cut = [&](std::size_t i, std::size_t o) -> Eigen::Vector4d {
    const double s = at[i] / (at[i] - at[o]);
    return (1.0 - s) * tet[i] + s * tet[o];
  };
  // A prism a b c – a' b' c' is three tets
  const auto prism = [&](const Eigen::Vector4d& a, const Eigen::Vector4d& b,
                         const Eigen::Vector4d& c, const Eigen::Vector4d& a2,
                         const Eigen::Vector4d& b2, const Eigen::Vector4d& c2) {
    out.push_back({a, b, c, c2});
    out.push_back({a, b, b2, c2});
    out.push_back({a, a2, b2, c2});
  };
  switch (inCount) {
    case 4:
      out.push_back(tet);
      break;
    case 3: {
      const std::size_t o = outside[0];
      prism(tet[in[0]], tet[in[1]], tet[in[2]], cut(in[0], o), cut(in[1], o), cut(in[2], o));
      break;
    }
    case 2: {
      const std::size_t o = outside[0];
      const std::size_t p = outside[1];
      prism(tet[in[0]], cut(in[0], o), cut(in[0], p), tet[in[1]], cut(in[1], o), cut(in[1], p));
      break;
    }
    case 1: {
      const std::size_t i = in[0];
      out.push_back({tet[i], cut(i, outside[0]), cut(i, outside[1]), cut(i, outside[2])});
      break;
    }
    default:
      break;
  }
}

}  // namespace

std::vector<TissueId> vertexOwners(const TissueFields& fields) {
  std::vector<TissueId> owner(static_cast<std::size_t>(fields.values.rows()));
  parallelFor(fields.values.rows(), [&](std::int64_t v) {
    owner[static_cast<std::size_t>(v)] = ownerOf(fields.values.row(v), fields.fatIsCandidate);
  });
  return owner;
}

TissueId ownerAt(const mesh::TetMesh& mesh, const TissueFields& fields, Eigen::Index tet,
                 const Eigen::Vector4d& barycentric) {
  Eigen::RowVectorXd f = Eigen::RowVectorXd::Zero(fields.values.cols());
  for (int k = 0; k < 4; ++k) f += barycentric[k] * fields.values.row(mesh.T(tet, k));
  return ownerOf(f, fields.fatIsCandidate);
}

std::vector<double> tissueVolumes(const mesh::TetMesh& mesh, const TissueFields& fields) {
  const std::vector<TissueId> owner = vertexOwners(fields);
  const auto fieldCount = static_cast<Eigen::Index>(fields.values.cols());
  // A fixed number of parts, added up in order: the same bytes on any number of threads
  constexpr std::int64_t kPart = 4096;
  const std::int64_t parts = (mesh.T.rows() + kPart - 1) / kPart;
  Eigen::MatrixXd volume = Eigen::MatrixXd::Zero(fieldCount, parts);
  parallelFor(
      parts,
      [&](std::int64_t part) {
        std::vector<Eigen::Index> candidates;
        std::vector<SubTet> pieces;
        std::vector<SubTet> kept;
        const std::int64_t end = std::min<std::int64_t>(mesh.T.rows(), (part + 1) * kPart);
        for (std::int64_t t = part * kPart; t < end; ++t) {
          const double V = mesh::signedVolume(mesh, t);
          std::array<TissueId, 4> at;
          for (int k = 0; k < 4; ++k)
            at[static_cast<std::size_t>(k)] = owner[static_cast<std::size_t>(mesh.T(t, k))];
          if (std::ranges::all_of(at, [&](TissueId id) { return id == at[0]; })) {
            volume(at[0].value - 1, part) += V;
            continue;
          }
          // A field nowhere above another has no volume here; on skin all muscles are 0, so equal
          // corners are common. Fields equal all over are left to the tie rule below.
          Eigen::MatrixX4d f(fieldCount, 4);
          for (int k = 0; k < 4; ++k) f.col(k) = fields.values.row(mesh.T(t, k)).transpose();
          candidates.clear();
          const Eigen::Index first = fields.fatIsCandidate ? 0 : 1;
          for (Eigen::Index i = first; i < fieldCount; ++i) {
            bool beaten = false;
            for (Eigen::Index o = first; o < fieldCount && !beaten; ++o) {
              beaten = (f.row(i).array() <= f.row(o).array()).all() &&
                       (f.row(i).array() < f.row(o).array()).any();
            }
            if (!beaten) candidates.push_back(i);
          }
          for (const Eigen::Index i : candidates) {
            pieces.assign(1, SubTet{Eigen::Vector4d::Unit(0), Eigen::Vector4d::Unit(1),
                                    Eigen::Vector4d::Unit(2), Eigen::Vector4d::Unit(3)});
            for (const Eigen::Index j : candidates) {
              if (j == i) continue;
              const Eigen::Vector4d g = (f.row(i) - f.row(j)).transpose();
              kept.clear();
              if (g.isZero(0.0)) {  // equal all over the tet: the tie rule gives it to one of them
                if (i > 0 && (j == 0 || i < j)) continue;
              } else {
                for (const SubTet& piece : pieces) keepPositive(piece, g, kept);
                // Slices of no volume would be sliced again by every field that follows
                std::erase_if(kept,
                              [](const SubTet& piece) { return volumeShare(piece) < kNothing; });
              }
              pieces.swap(kept);
            }
            for (const SubTet& piece : pieces) volume(i, part) += V * volumeShare(piece);
          }
        }
      },
      1);
  const Eigen::VectorXd sum = volume.rowwise().sum();
  return {sum.begin(), sum.end()};
}

}  // namespace ecorche::tissue
