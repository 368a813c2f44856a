#include "support/generated_anatomy.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>

#include "support/generated_domain.h"

namespace ecorche::test {

using domain::BoundaryTag;
using domain::Domain;
using mesh::TetMesh;
using mesh::Vector3;

namespace {

using Random = std::mt19937_64;

double unit(Random& random) {  // in [0, 1), the same on every platform
  return static_cast<double>(random() >> 11) * 0x1p-53;
}

Vector3 pointIn(const mesh::Box& box, Random& random) {
  Vector3 p;
  for (int k = 0; k < 3; ++k) p[k] = box.lo[k] + unit(random) * (box.hi[k] - box.lo[k]);
  return p;
}

double distanceToSegment(const Vector3& p, const Vector3& a, const Vector3& b) {
  const Vector3 d = b - a;
  const double t = std::clamp((p - a).dot(d) / d.squaredNorm(), 0.0, 1.0);
  return (p - a - t * d).norm();
}

/// Keeps the cells of a Kuhn grid for which `keep(x, y, z)` holds, and the vertices they use.
TetMesh cellsOf(const TetMesh& grid, const Eigen::Array3i& cells,
                const std::function<bool(int, int, int)>& keep) {
  std::vector<Eigen::Index> rows;
  Eigen::Index t = 0;
  for (int z = 0; z < cells.z(); ++z) {
    for (int y = 0; y < cells.y(); ++y) {
      for (int x = 0; x < cells.x(); ++x) {
        for (int k = 0; k < 6; ++k, ++t) {
          if (keep(x, y, z)) rows.push_back(t);
        }
      }
    }
  }
  std::vector<std::int32_t> fresh(static_cast<std::size_t>(grid.V.rows()), -1);
  TetMesh out;
  out.T.resize(static_cast<Eigen::Index>(rows.size()), 4);
  out.V.resize(grid.V.rows(), 3);
  std::int32_t count = 0;
  for (std::size_t r = 0; r < rows.size(); ++r) {
    for (int c = 0; c < 4; ++c) {
      std::int32_t& v = fresh[static_cast<std::size_t>(grid.T(rows[r], c))];
      if (v < 0) {
        v = count++;
        out.V.row(v) = grid.V.row(grid.T(rows[r], c));
      }
      out.T(static_cast<Eigen::Index>(r), c) = v;
    }
  }
  out.V.conservativeResize(count, 3);
  return out;
}

Grid boxGrid(std::uint64_t seed, double jitter) {
  Random random(seed);
  Grid grid;
  for (int k = 0; k < 3; ++k) grid.cells[k] = 2 + static_cast<int>(random() % 3);
  grid.jitter = jitter;
  grid.seed = seed;
  return grid;
}

/// Pushes inner vertices against the far face of one of their tets, to a millionth of its height
/// where that turns nothing inside out.
void flatten(TetMesh& mesh, std::uint64_t seed) {
  Random random(seed);
  const mesh::VertexTets around = mesh::vertexTets(mesh.T, mesh.V.rows());
  const auto boundary = mesh::tetBoundary(mesh.T, mesh::tetAdjacency(mesh.T).neighbours);
  std::vector<std::uint8_t> fixed(static_cast<std::size_t>(mesh.V.rows()), 0);
  for (Eigen::Index i = 0; i < boundary.F.size(); ++i)
    fixed[static_cast<std::size_t>(boundary.F.data()[i])] = 1;
  for (std::int32_t v = 0; v < mesh.V.rows(); ++v) {
    if (fixed[static_cast<std::size_t>(v)]) continue;
    const std::int32_t begin = around.first[static_cast<std::size_t>(v)];
    const std::int32_t end = around.first[static_cast<std::size_t>(v) + 1];
    const std::int32_t t = around.tet[static_cast<std::size_t>(begin) +
                                      random() % static_cast<std::uint64_t>(end - begin)];
    Vector3 middle = Vector3::Zero();
    for (int c = 0; c < 4; ++c) {
      if (mesh.T(t, c) != v) middle += mesh.V.row(mesh.T(t, c)).transpose() / 3.0;
    }
    const Eigen::RowVector3d before = mesh.V.row(v);
    const double rest = std::pow(10.0, -6.0 * unit(random));
    mesh.V.row(v) = middle.transpose() + rest * (before - middle.transpose());
    bool fine = true;
    for (std::int32_t i = begin; i < end; ++i) {
      fine = fine && mesh::signedVolume(mesh, around.tet[static_cast<std::size_t>(i)]) > 1e-12;
    }
    if (!fine) mesh.V.row(v) = before;
  }
}

Domain limb(std::uint64_t seed) {
  Random random(seed);
  Grid grid;
  grid.cells = {7, 4, 5};
  grid.jitter = 0.15;
  grid.seed = seed;
  TetMesh mesh = cellsOf(kuhnGrid(grid), grid.cells, [](int x, int y, int z) {
    return !((x == 1 || x == 4 || x == 5) && y >= 1 && y <= 2 && z >= 1 && z <= 3);
  });
  // Bones are told by where their walls lie before the limb is tapered and bent
  Domain out = domainOf(mesh, [](const Vector3& centre, const Vector3&) -> BoundaryTag {
    const bool inside = (centre.array() > 0.02).all() && (centre.array() < 0.98).all();
    if (!inside) {
      if (centre.z() < 1e-9) return {BoundaryTag::Kind::CutPlane, 0};
      return {};
    }
    return {BoundaryTag::Kind::Bone, centre.x() < 3.0 / 7.0 ? 0 : 1};
  });
  const double bend = 0.5 * unit(random);
  const double taper = 0.5 * unit(random);
  for (Eigen::Index v = 0; v < out.mesh.V.rows(); ++v) {
    const double z = out.mesh.V(v, 2);
    out.mesh.V.row(v).head<2>() *= 1.0 - taper * z;
    out.mesh.V(v, 0) += bend * z * z;
  }
  out.volume = mesh::signedVolumes(out.mesh).sum();
  out.boneNames = {"one", "two"};
  out.cutPlaneNames = {"end"};
  return out;
}

}  // namespace

std::string_view name(Shape shape) {
  constexpr std::string_view kNames[kShapeCount] = {"box",   "jittered box", "cylinder", "shell",
                                                    "torus", "limb",         "slivers"};
  return kNames[static_cast<int>(shape)];
}

std::string_view name(FieldKind kind) {
  constexpr std::string_view kNames[kFieldKindCount] = {
      "bumps",     "noise",         "rounded bumps", "rounded noise", "two values",
      "all equal", "half constant", "near ties",     "wild scales"};
  return kNames[static_cast<int>(kind)];
}

Domain generatedDomain(Shape shape, std::uint64_t seed) {
  switch (shape) {
    case Shape::Box:
      return boxDomain(boxGrid(seed, 0.0));
    case Shape::Jittered:
      return boxDomain(boxGrid(seed, 0.2));
    case Shape::Cylinder:
      return cylinderDomain(1.0, 1.5, 4, seed + 1);
    case Shape::Shell:
      return shellDomain(0.5, 1.0, 2);
    case Shape::Torus: {
      Grid grid = boxGrid(seed, 0.2);
      grid.cells = {4, 4, 2};
      return domainOf(cellsOf(kuhnGrid(grid), grid.cells,
                              [](int x, int y, int) { return x < 1 || x > 2 || y < 1 || y > 2; }),
                      allSkin);
    }
    case Shape::Limb:
      return limb(seed);
    case Shape::Slivers: {
      Grid grid = boxGrid(seed, 0.2);
      grid.cells += 1;
      TetMesh mesh = kuhnGrid(grid);
      flatten(mesh, seed);
      return domainOf(std::move(mesh), allSkin);
    }
  }
  return {};
}

tissue::FieldMatrix generatedFields(const mesh::Positions& V, FieldKind kind, int fieldCount,
                                    std::uint64_t seed) {
  Random random(seed * 2654435761U + 17);
  const mesh::Box box = mesh::boundingBox(V);
  const double size = box.diagonal();
  tissue::FieldMatrix fields(V.rows(), fieldCount);

  const auto bumps = [&] {
    fields.col(0).setConstant(0.35);
    for (int i = 1; i < fieldCount; ++i) {
      const Vector3 a = pointIn(box, random);
      const Vector3 b = pointIn(box, random);
      const double width = size * (0.08 + 0.12 * unit(random));
      for (Eigen::Index v = 0; v < V.rows(); ++v) {
        const double d = distanceToSegment(V.row(v).transpose(), a, b);
        fields(v, i) = std::exp(-d * d / (width * width));
      }
    }
  };
  const auto noise = [&] {
    for (Eigen::Index i = 0; i < fields.size(); ++i) fields.data()[i] = unit(random);
  };
  const auto round = [&] { fields = (fields.array() * 16.0).round() / 16.0; };

  switch (kind) {
    case FieldKind::Bumps:
      bumps();
      break;
    case FieldKind::Noise:
      noise();
      break;
    case FieldKind::RoundedBumps:
      bumps();
      round();
      break;
    case FieldKind::RoundedNoise:
      noise();
      round();
      break;
    case FieldKind::TwoValues:
      for (Eigen::Index i = 0; i < fields.size(); ++i)
        fields.data()[i] = static_cast<double>(random() & 1);
      break;
    case FieldKind::AllEqual:
      fields.setConstant(0.5);
      break;
    case FieldKind::HalfConstant: {
      bumps();
      const double middle = box.centre().x();
      for (Eigen::Index v = 0; v < V.rows(); ++v) {
        if (V(v, 0) > middle) fields.row(v).setConstant(0.5);
      }
      break;
    }
    case FieldKind::NearTies:
      for (Eigen::Index v = 0; v < V.rows(); ++v) {
        const double base = 0.5 + 0.25 * std::sin(7.0 * V(v, 0) / size + 3.0 * V(v, 1) / size);
        for (int i = 0; i < fieldCount; ++i) {
          fields(v, i) = base + 0x1p-52 * static_cast<double>(random() % 5);
        }
      }
      break;
    case FieldKind::WildScales:
      noise();
      for (Eigen::Index v = 0; v < V.rows(); ++v)
        fields.row(v) *= std::pow(10.0, 300.0 * unit(random) - 150.0);
      break;
  }
  return fields;
}

GeneratedAnatomy generatedAnatomy(std::uint64_t seed) {
  const auto shape = static_cast<Shape>(seed % kShapeCount);
  const auto kind = static_cast<FieldKind>(seed % kFieldKindCount);
  const int fieldCount = 2 + static_cast<int>((seed * 5 + seed / 8) % 8);
  GeneratedAnatomy out;
  out.name = fmt::format("{}, {} of {}, seed {}", name(shape), name(kind), fieldCount, seed);
  out.domain = generatedDomain(shape, seed);
  out.fields.values = generatedFields(out.domain.mesh.V, kind, fieldCount, seed);
  out.fields.fatIsCandidate = seed % 11 != 3;
  out.fields.maxValue = out.fields.values.maxCoeff();
  out.smooth = kind == FieldKind::Bumps;
  return out;
}

tissue::FieldMatrix benchFields(const mesh::Positions& V, int muscleCount, std::uint64_t seed) {
  Random random(seed);
  const mesh::Box inner{Vector3::Constant(0.05), Vector3::Constant(0.95)};
  tissue::FieldMatrix fields(V.rows(), muscleCount + 1);
  fields.col(0).setConstant(0.35);
  for (int i = 1; i <= muscleCount; ++i) {
    Vector3 a, b;
    do {
      a = pointIn(inner, random);
      b = pointIn(inner, random);
    } while ((b - a).norm() < 0.25 || (b - a).norm() > 0.6);
    const double width = 0.075 + 0.05 * unit(random);
    for (Eigen::Index v = 0; v < V.rows(); ++v) {
      const double d = distanceToSegment(V.row(v).transpose(), a, b);
      fields(v, i) = std::exp(-d * d / (width * width));
    }
  }
  return fields;
}

}  // namespace ecorche::test
