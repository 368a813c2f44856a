#include <ecorche/core/contract.h>
#include <ecorche/core/files.h>
#include <ecorche/exchange/medit.h>
#include <ecorche/exchange/text_rows.h>
#include <fmt/format.h>

#include <algorithm>
#include <map>

namespace ecorche::exchange {

namespace {

using Kind = domain::BoundaryTag::Kind;

std::string nameOf(std::int32_t id, const std::vector<TissueName>& names) {
  const auto at = std::ranges::find(names, id, &TissueName::id);
  return at != names.end() ? at->name : std::to_string(id);
}

std::string nameOf(const std::vector<std::string>& names, std::int32_t index) {
  const auto i = static_cast<std::size_t>(index);
  return i < names.size() ? names[i] : std::to_string(index);
}

FaceReference meaningOf(domain::BoundaryTag tag, const domain::Domain& domain) {
  FaceReference m;
  m.index = tag.index;
  switch (tag.kind) {
    case Kind::Skin:
      m.kind = m.name = "skin";
      break;
    case Kind::Bone:
      m.kind = "bone";
      m.name = nameOf(domain.boneNames, tag.index);
      break;
    case Kind::CutPlane:
      m.kind = "cut-plane";
      m.name = nameOf(domain.cutPlaneNames, tag.index);
      break;
    case Kind::Obstacle:
      m.kind = "obstacle";
      m.name = std::to_string(tag.index);
      break;
    case Kind::Cavity:
      m.kind = "cavity";
      m.name = std::to_string(tag.index);
      break;
  }
  return m;
}

}  // namespace

MarkedFaces markFaces(const envelope::Anatomy& anatomy, const domain::Domain& domain,
                      const std::vector<TissueName>& names) {
  // Interfaces: every inner face between two tissues once, from the side of the higher id
  struct Interface {
    std::int32_t inner, outer, tet, corner;
  };
  std::vector<Interface> interfaces;
  std::map<std::pair<std::int32_t, std::int32_t>, std::int32_t> pairs;
  for (Eigen::Index t = 0; t < anatomy.mesh.T.rows(); ++t) {
    const std::int32_t own = anatomy.label[static_cast<std::size_t>(t)].value;
    for (int k = 0; k < 4; ++k) {
      const std::int32_t n = anatomy.neighbours(t, k);
      if (n < 0) continue;
      const std::int32_t other = anatomy.label[static_cast<std::size_t>(n)].value;
      if (other >= own) continue;
      interfaces.push_back({own, other, static_cast<std::int32_t>(t), k});
      pairs[{own, other}] = 0;
    }
  }
  std::map<domain::BoundaryTag, std::int32_t> tags;
  for (const domain::BoundaryTag tag : anatomy.boundaryTag) tags[tag] = 0;

  MarkedFaces out;
  for (auto& [tag, reference] : tags) {
    reference = static_cast<std::int32_t>(out.meaning.size()) + 1;
    out.meaning.push_back(meaningOf(tag, domain));
    out.meaning.back().reference = reference;
  }
  for (auto& [pair, reference] : pairs) {
    reference = static_cast<std::int32_t>(out.meaning.size()) + 1;
    out.meaning.push_back({reference, "interface", nameOf(pair.first, names),
                           nameOf(pair.second, names), pair.first, pair.second});
  }

  const Eigen::Index boundaryCount = anatomy.boundaryF.rows();
  out.F.resize(boundaryCount + static_cast<Eigen::Index>(interfaces.size()), 3);
  out.reference.reserve(static_cast<std::size_t>(out.F.rows()));
  out.F.topRows(boundaryCount) = anatomy.boundaryF;
  for (const domain::BoundaryTag tag : anatomy.boundaryTag) out.reference.push_back(tags[tag]);
  for (std::size_t i = 0; i < interfaces.size(); ++i) {
    const Interface& face = interfaces[i];
    for (int c = 0; c < 3; ++c) {
      out.F(boundaryCount + static_cast<Eigen::Index>(i), c) =
          anatomy.mesh.T(face.tet, mesh::kTetFace[face.corner][c]);
    }
    out.reference.push_back(pairs[{face.inner, face.outer}]);
  }
  return out;
}

Result<void> writeMedit(const std::filesystem::path& file, const mesh::TetMesh& mesh,
                        const std::vector<TissueId>& tissue, const MarkedFaces& faces,
                        const std::vector<TissueName>& names) {
  EC_REQUIRE_EQ(static_cast<Eigen::Index>(tissue.size()), mesh.T.rows());
  EC_REQUIRE_EQ(static_cast<Eigen::Index>(faces.reference.size()), faces.F.rows());

  std::string out = "MeshVersionFormatted 2\nDimension 3\n";
  for (const TissueName& name : names)
    out += fmt::format("# tetrahedra {}: {}\n", name.id, name.name);
  for (const FaceReference& m : faces.meaning) {
    out += m.kind == "interface"
               ? fmt::format("# triangles {}: interface {} | {}\n", m.reference, m.name, m.other)
               : fmt::format("# triangles {}: {} {}\n", m.reference, m.kind, m.name);
  }

  out += fmt::format("Vertices\n{}\n", mesh.V.rows());
  appendRows(out, mesh.V.rows(), 3 * 26 + 4, [&](std::int64_t v, RowWriter& row) {
    for (int c = 0; c < 3; ++c) {
      row.number(mesh.V(v, c));
      row.put(' ');
    }
    row.put('0');
    row.put('\n');
  });
  out += fmt::format("Triangles\n{}\n", faces.F.rows());
  appendRows(out, faces.F.rows(), 4 * 12, [&](std::int64_t f, RowWriter& row) {
    for (int c = 0; c < 3; ++c) {
      row.integer(faces.F(f, c) + std::int64_t{1});
      row.put(' ');
    }
    row.integer(faces.reference[static_cast<std::size_t>(f)]);
    row.put('\n');
  });
  out += fmt::format("Tetrahedra\n{}\n", mesh.T.rows());
  appendRows(out, mesh.T.rows(), 5 * 12, [&](std::int64_t t, RowWriter& row) {
    for (int c = 0; c < 4; ++c) {
      row.integer(mesh.T(t, c) + std::int64_t{1});
      row.put(' ');
    }
    row.integer(tissue[static_cast<std::size_t>(t)].value);
    row.put('\n');
  });
  out += "End\n";
  return writeFileWhole(file, out);
}

}  // namespace ecorche::exchange
