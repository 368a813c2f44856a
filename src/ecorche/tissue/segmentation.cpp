#include <ecorche/core/contract.h>
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

constexpr double kNoVolume = 1e-14;  // of a tet's volume

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

// Shares of one tet after another, exact for linear fields. A field nowhere above another has no
// volume; on skin all muscles are 0, so equal corners are common. Fields equal all over are left to
// the tie rule.
class TetShares {
 public:
  explicit TetShares(const TissueFields& fields)
      : fields_(fields), first_(fields.fatIsCandidate ? 0 : 1), f_(fields.values.cols(), 4) {}

  void look(const mesh::TetMesh& mesh, Eigen::Index t) {
    for (int k = 0; k < 4; ++k) f_.col(k) = fields_.values.row(mesh.T(t, k)).transpose();
    candidates_.clear();
    for (Eigen::Index i = first_; i < f_.rows(); ++i) {
      if (!isBeaten(i)) candidates_.push_back(i);
    }
  }
  [[nodiscard]] const std::vector<Eigen::Index>& candidates() const { return candidates_; }
  [[nodiscard]] bool isBeaten(Eigen::Index i) const {
    for (Eigen::Index o = first_; o < f_.rows(); ++o) {
      if ((f_.row(i).array() <= f_.row(o).array()).all() &&
          (f_.row(i).array() < f_.row(o).array()).any())
        return true;
    }
    return false;
  }
  [[nodiscard]] double shareOf(Eigen::Index i) {
    pieces_.assign(1, SubTet{Eigen::Vector4d::Unit(0), Eigen::Vector4d::Unit(1),
                             Eigen::Vector4d::Unit(2), Eigen::Vector4d::Unit(3)});
    for (const Eigen::Index j : candidates_) {
      if (j == i) continue;
      const Eigen::Vector4d g = (f_.row(i) - f_.row(j)).transpose();
      kept_.clear();
      if (g.isZero(0.0)) {  // equal all over the tet: the tie rule gives it to one of them
        if (i > 0 && (j == 0 || i < j)) continue;
      } else {
        for (const SubTet& piece : pieces_) keepPositive(piece, g, kept_);
        // Slices of no volume would be sliced again by every field that follows
        std::erase_if(kept_, [](const SubTet& piece) { return volumeShare(piece) < kNoVolume; });
      }
      pieces_.swap(kept_);
    }
    double sum = 0.0;
    for (const SubTet& piece : pieces_) sum += volumeShare(piece);
    return sum;
  }

 private:
  const TissueFields& fields_;
  Eigen::Index first_;
  Eigen::MatrixX4d f_;
  std::vector<Eigen::Index> candidates_;
  std::vector<SubTet> pieces_;
  std::vector<SubTet> kept_;
};

constexpr std::int64_t kPart = 4096;  // tets of a sum: the same bytes on any number of threads

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
  const std::int64_t parts = (mesh.T.rows() + kPart - 1) / kPart;
  Eigen::MatrixXd volume = Eigen::MatrixXd::Zero(fields.values.cols(), parts);
  parallelFor(
      parts,
      [&](std::int64_t part) {
        TetShares shares(fields);
        const std::int64_t end = std::min<std::int64_t>(mesh.T.rows(), (part + 1) * kPart);
        for (std::int64_t t = part * kPart; t < end; ++t) {
          const double V = mesh::signedVolume(mesh, t);
          const TissueId first = owner[static_cast<std::size_t>(mesh.T(t, 0))];
          bool one = true;
          for (int k = 1; k < 4; ++k)
            one = one && owner[static_cast<std::size_t>(mesh.T(t, k))] == first;
          if (one) {
            volume(first.value - 1, part) += V;
            continue;
          }
          shares.look(mesh, t);
          for (const Eigen::Index i : shares.candidates()) volume(i, part) += V * shares.shareOf(i);
        }
      },
      1);
  const Eigen::VectorXd sum = volume.rowwise().sum();
  return {sum.begin(), sum.end()};
}

double tissueVolume(const mesh::TetMesh& mesh, const TissueFields& fields,
                    const std::vector<TissueId>& owner, TissueId tissue) {
  EC_REQUIRE_EQ(owner.size(), static_cast<std::size_t>(mesh.V.rows()));
  const Eigen::Index own = tissue.value - 1;
  if (own == 0 && !fields.fatIsCandidate) return 0.0;
  const std::int64_t parts = (mesh.T.rows() + kPart - 1) / kPart;
  std::vector<double> volume(static_cast<std::size_t>(parts), 0.0);
  parallelFor(
      parts,
      [&](std::int64_t part) {
        TetShares shares(fields);
        double& sum = volume[static_cast<std::size_t>(part)];
        const std::int64_t end = std::min<std::int64_t>(mesh.T.rows(), (part + 1) * kPart);
        for (std::int64_t t = part * kPart; t < end; ++t) {
          std::array<TissueId, 4> at;
          for (int k = 0; k < 4; ++k)
            at[static_cast<std::size_t>(k)] = owner[static_cast<std::size_t>(mesh.T(t, k))];
          if (at[0] == at[1] && at[0] == at[2] && at[0] == at[3]) {
            if (at[0] == tissue) sum += mesh::signedVolume(mesh, t);
            continue;
          }
          // Where it is nowhere above what owns a corner it is nowhere on top
          const bool below = std::ranges::any_of(at, [&](TissueId other) {
            if (other == tissue) return false;
            for (int k = 0; k < 4; ++k) {
              const Eigen::Index v = mesh.T(t, k);
              if (fields.values(v, own) >= fields.values(v, other.value - 1)) return false;
            }
            return true;
          });
          if (below) continue;
          shares.look(mesh, t);
          if (std::ranges::find(shares.candidates(), own) != shares.candidates().end())
            sum += mesh::signedVolume(mesh, t) * shares.shareOf(own);
        }
      },
      1);
  double out = 0.0;
  for (const double v : volume) out += v;
  return out;
}

}  // namespace ecorche::tissue
