#include <ecorche/domain/pockets.h>
#include <ecorche/mesh/surface_query.h>
#include <ecorche/mesh/surface_topology.h>

#include <algorithm>
#include <optional>

namespace ecorche::domain {

namespace {

struct Piece {
  double volume = 0.0;  // negative: what lies in it is no domain
  mesh::Box box;
  bool skin = false;
  std::vector<Eigen::Index> faces;
  std::optional<mesh::SurfaceQuery> query;
};

std::vector<Piece> piecesOf(const TaggedSurface& surface, const mesh::FaceComponents& labels) {
  std::vector<Piece> out(static_cast<std::size_t>(labels.count));
  for (Eigen::Index f = 0; f < surface.F.rows(); ++f) {
    Piece& piece = out[static_cast<std::size_t>(labels.label[static_cast<std::size_t>(f)])];
    piece.faces.push_back(f);
    piece.skin = piece.skin ||
                 unpacked(surface.tag[static_cast<std::size_t>(f)]).kind == BoundaryTag::Kind::Skin;
    for (int k = 0; k < 3; ++k) piece.box.add(surface.V.row(surface.F(f, k)).transpose());
  }
  for (Piece& piece : out) {
    const mesh::Triangles F = surface.F(piece.faces, Eigen::all);
    piece.volume = mesh::signedVolume(surface.V.rowwise() - piece.box.centre().transpose(), F);
  }
  return out;
}

bool around(const mesh::Box& outer, const mesh::Box& inner) {
  return (outer.lo.array() <= inner.lo.array()).all() &&
         (outer.hi.array() >= inner.hi.array()).all();
}

}  // namespace

std::vector<Pocket> dropPockets(TaggedSurface& surface) {
  const mesh::FaceComponents labels = mesh::components(surface.F);
  std::vector<Piece> pieces = piecesOf(surface, labels);
  const auto outward = [&](std::size_t p) { return pieces[p].volume > 0.0; };
  const bool any = std::ranges::any_of(
      pieces, [](const Piece& piece) { return !piece.skin && piece.volume > 0.0; });
  if (!any) return {};

  // What is no domain belongs to the smallest part around it
  const auto holds = [&](Piece& outer, const Piece& inner) {
    if (!around(outer.box, inner.box)) return false;
    if (!outer.query) {
      const mesh::Triangles F = surface.F(outer.faces, Eigen::all);
      outer.query.emplace(surface.V, F);
    }
    return outer.query->inside(surface.V.row(surface.F(inner.faces.front(), 0)).transpose());
  };
  std::vector<std::size_t> home(pieces.size());
  std::vector<double> volume(pieces.size());  // of parts, without what is no domain in them
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    home[i] = i;
    if (outward(i)) {
      volume[i] += pieces[i].volume;
      continue;
    }
    for (std::size_t o = 0; o < pieces.size(); ++o) {
      const bool smaller = home[i] == i || pieces[o].volume < pieces[home[i]].volume;
      if (outward(o) && smaller && holds(pieces[o], pieces[i])) home[i] = o;
    }
    if (home[i] != i) volume[home[i]] += pieces[i].volume;
  }
  double largest = 0.0;
  for (std::size_t p = 0; p < pieces.size(); ++p) {
    if (pieces[p].skin && outward(p)) largest = std::max(largest, volume[p]);
  }

  std::vector<Pocket> pockets;
  std::vector<char> gone(pieces.size(), 0);
  for (std::size_t p = 0; p < pieces.size(); ++p) {
    const Piece& piece = pieces[p];
    if (piece.skin || !outward(p) || volume[p] >= largest) continue;
    gone[p] = 1;
    Pocket pocket{volume[p], piece.box.centre(), {}};
    for (const Eigen::Index f : piece.faces)
      pocket.tags.push_back(surface.tag[static_cast<std::size_t>(f)]);
    std::ranges::sort(pocket.tags);
    const auto repeated = std::ranges::unique(pocket.tags);
    pocket.tags.erase(repeated.begin(), repeated.end());
    pockets.push_back(std::move(pocket));
  }
  if (pockets.empty()) return pockets;
  TaggedSurface kept{surface.V, mesh::Triangles(surface.F.rows(), 3), {}};
  for (Eigen::Index f = 0; f < surface.F.rows(); ++f) {
    const auto at = static_cast<std::size_t>(f);
    if (gone[home[static_cast<std::size_t>(labels.label[at])]] != 0) continue;
    kept.F.row(std::ssize(kept.tag)) = surface.F.row(f);
    kept.tag.push_back(surface.tag[at]);
  }
  kept.F.conservativeResize(std::ssize(kept.tag), 3);
  surface = compacted(kept);
  return pockets;
}

}  // namespace ecorche::domain
