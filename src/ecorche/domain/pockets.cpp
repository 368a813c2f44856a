#include <ecorche/domain/pockets.h>
#include <ecorche/mesh/nesting.h>
#include <ecorche/mesh/surface_topology.h>

#include <Eigen/Geometry>
#include <algorithm>

namespace ecorche::domain {

namespace {

struct Piece {
  double volume = 0.0;  // negative: what lies in it is no domain
  mesh::Box box;
  bool skin = false;
  std::vector<Eigen::Index> faces;
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
    const mesh::Vector3 centre = piece.box.centre();
    for (const Eigen::Index f : piece.faces) {
      const auto corner = [&](int k) -> mesh::Vector3 {
        return surface.V.row(surface.F(f, k)).transpose() - centre;
      };
      piece.volume += corner(0).dot(corner(1).cross(corner(2))) / 6.0;
    }
  }
  return out;
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
  std::vector<char> isPart(pieces.size());
  std::vector<char> isNone(pieces.size());
  for (std::size_t p = 0; p < pieces.size(); ++p) {
    isPart[p] = outward(p);
    isNone[p] = !outward(p);
  }
  const auto heldBy = mesh::holders(surface.V, surface.F, labels, isPart, isNone);
  std::vector<std::size_t> home(pieces.size());
  std::vector<double> volume(pieces.size());  // of parts, without what is no domain in them
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    home[i] = i;
    for (const std::int32_t holder : heldBy[i]) {
      const auto o = static_cast<std::size_t>(holder);
      if (home[i] == i || pieces[o].volume < pieces[home[i]].volume) home[i] = o;
    }
    if (outward(i) || home[i] != i) volume[home[i]] += pieces[i].volume;
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
