#include <ecorche/core/index.h>
#include <ecorche/mesh/open_sheets.h>
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <utility>

namespace ecorche::mesh {

namespace {

constexpr double kOneWay = 0.7;   // of the areas together, by the sum of area vectors
constexpr double kNarrow = 40.0;  // perimeter² by area: 16 of a square, 48 of a strip of 1 : 10
constexpr double kAlong = 0.05;   // of a sheet's extent: borders that near run along one another
constexpr std::int64_t kMostPairs = 20000000;
constexpr double kMostAlong = 0.6;  // of a sheet's border; more of it along others: cracked off

using Segment = std::array<Vector3, 2>;

double distance(const Vector3& p, const Segment& s) {
  const Vector3 along = s[1] - s[0];
  const double length2 = along.squaredNorm();
  const double t = length2 > 0.0 ? std::clamp((p - s[0]).dot(along) / length2, 0.0, 1.0) : 0.0;
  return (s[0] + t * along - p).norm();
}

struct Piece {
  Box box;
  Vector3 areaVector = Vector3::Zero();
  double area = 0.0;
  double perimeter = 0.0;
  int borders = 0;
  std::vector<Segment> border;

  [[nodiscard]] bool looksLikeSheet() const {
    if (border.empty()) return false;
    if (areaVector.norm() > kOneWay * area) return true;
    return borders == 1 && perimeter * perimeter > kNarrow * area;
  }
  [[nodiscard]] bool mayRunAlong(const Piece& other) const {
    const double reach = kAlong * box.diagonal();
    return !(other.border.empty() || ((other.box.lo - box.hi).array() > reach).any() ||
             ((box.lo - other.box.hi).array() > reach).any());
  }
};

std::vector<Piece> measured(const Positions& V, const Triangles& F, const SurfaceEdges& edges,
                            const FaceComponents& pieces) {
  std::vector<Piece> out(toIndex(pieces.count));
  const auto at = [&](std::int32_t v) -> Vector3 { return V.row(v).transpose(); };
  for (Eigen::Index f = 0; f < F.rows(); ++f) {
    Piece& piece = out[toIndex(pieces.label[toIndex(f)])];
    const Vector3 a = at(F(f, 0));
    const Vector3 own = 0.5 * (at(F(f, 1)) - a).cross(at(F(f, 2)) - a);
    piece.areaVector += own;
    piece.area += own.norm();
    for (int k = 0; k < 3; ++k) piece.box.add(at(F(f, k)));
  }
  // Borders of pieces that touch in a vertex hang together: each edge counts for its own piece
  std::vector<std::int64_t> lastSeen(out.size(), -1);
  std::int64_t number = 0;
  for (const Border& border : borders(edges)) {
    for (const std::int32_t e : border.edges) {
      const std::int32_t face = edges.slot[toIndex(edges.first[toIndex(e)])] / 3;
      const std::size_t p = toIndex(pieces.label[toIndex(face)]);
      Piece& piece = out[p];
      if (std::exchange(lastSeen[p], number) != number) ++piece.borders;
      const auto [a, b] = edges.ends[toIndex(e)];
      piece.border.push_back({at(a), at(b)});
      piece.perimeter += (at(a) - at(b)).norm();
    }
    ++number;
  }
  return out;
}

/// The share of the sheet's border that lies at one of the others' borders.
double shareAlong(const Piece& sheet, const std::vector<const Piece*>& others) {
  const double reach = kAlong * sheet.box.diagonal();
  double along = 0.0;
  for (const Segment& s : sheet.border) {
    const Vector3 middle = 0.5 * (s[0] + s[1]);
    const bool near = std::ranges::any_of(others, [&](const Piece* other) {
      return std::ranges::any_of(other->border,
                                 [&](const Segment& t) { return distance(middle, t) < reach; });
    });
    if (near) along += (s[1] - s[0]).norm();
  }
  return along / sheet.perimeter;
}

}  // namespace

std::vector<char> openSheets(const Positions& V, const Triangles& F, const SurfaceEdges& edges,
                             const FaceComponents& pieces) {
  std::vector<char> sheet(toIndex(pieces.count), 0);
  if (pieces.count < 2) return sheet;
  const std::vector<Piece> list = measured(V, F, edges, pieces);
  std::ranges::transform(list, sheet.begin(), [](const Piece& p) { return p.looksLikeSheet(); });
  if (std::ranges::all_of(sheet, [](char s) { return s != 0; }))
    return std::vector<char>(sheet.size(), 0);

  // What runs along a piece that is no sheet is none either, and so on from piece to piece
  std::vector<char> news(sheet.size());
  std::ranges::transform(sheet, news.begin(), [](char s) { return s == 0; });
  std::vector<double> along(sheet.size(), 0.0);
  for (bool any = true; any;) {
    // Thousands of loose patches: whether they belong to one another would take minutes to tell
    if (std::ranges::count(sheet, 1) * std::ranges::count(news, 1) > kMostPairs)
      return std::vector<char>(sheet.size(), 0);
    any = false;
    std::vector<char> next(sheet.size(), 0);
    for (std::size_t p = 0; p < list.size(); ++p) {
      if (sheet[p] == 0) continue;
      std::vector<const Piece*> others;
      for (std::size_t q = 0; q < list.size(); ++q) {
        if (news[q] != 0 && list[p].mayRunAlong(list[q])) others.push_back(&list[q]);
      }
      if (others.empty()) continue;
      along[p] += shareAlong(list[p], others);
      if (along[p] > kMostAlong) next[p] = 1;
    }
    for (std::size_t p = 0; p < list.size(); ++p) {
      if (next[p] == 0) continue;
      sheet[p] = 0;
      any = true;
    }
    news = std::move(next);
  }
  return sheet;
}

std::string partsNamed(const SurfaceMesh& mesh, const std::vector<char>& chosen) {
  constexpr std::size_t kTold = 3;
  std::vector<std::string> names;
  for (std::size_t p = 0; p < chosen.size(); ++p) {
    if (chosen[p] != 0 && !mesh.parts[p].name.empty()) names.push_back(mesh.parts[p].name);
  }
  std::string out;
  for (std::size_t n = 0; n < std::min(kTold, names.size()); ++n)
    out += fmt::format("{}\"{}\"", n == 0 ? "" : ", ", names[n]);
  if (names.size() > kTold) out += fmt::format(" and {} more", names.size() - kTold);
  return out;
}

}  // namespace ecorche::mesh
