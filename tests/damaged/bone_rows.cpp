#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "damaged/rows.h"
#include "support/shapes.h"

namespace ecorche::test {

namespace {

/// Two bones end to end whose boxes share this share of a bone's length.
std::vector<SurfaceMesh> interpenetrating(double share) {
  const double half = 0.05;
  const double shift = half * (1.0 - share);
  return {egg({0, 0, shift}, {0.016, 0.015, half}, 3, "humerus"),
          egg({0.001, 0.0005, -shift}, {0.015, 0.016, half}, 3, "ulna")};
}

SurfaceMesh block(const Vector3& lo, const Vector3& hi, const char* name) {
  SurfaceMesh m = box(lo, hi);
  m.name = name;
  return m;
}

}  // namespace

std::vector<Row> boneRows() {
  RowList rows;

  // The state of one bone
  rows.add("bone inside out",
           [] {
             return withBones({insideOut(goodHumerus()), goodUlna()}, {goodHumerus(), goodUlna()});
           },
           {"inward"});
  rows.add("bone half turned",
           [] {
             return withBones({flipped(goodHumerus(), 0.5, 21), goodUlna()},
                              {goodHumerus(), goodUlna()});
           },
           {"inconsistent-orientation", "inward"});
  rows.add(
      "bone open at one end",
      [] {
        return withBones(
            {without(goodHumerus(), [](const Vector3& p) { return p.z() > 0.095; }), goodUlna()},
            {goodHumerus(), goodUlna()});
      },
      {"hole"}, 2e-6);
  rows.add("bone of loose triangles",
           [] {
             return withBones({exploded(goodHumerus(), 0.0, 22), goodUlna()},
                              {goodHumerus(), goodUlna()});
           },
           {"duplicate-vertices"});
  rows.add(
      "bone in two patches, 0.1 mm apart",
      [] {
        return withBones({cracked(goodHumerus(), 0.05, 1e-4), goodUlna()},
                         {goodHumerus(), goodUlna()});
      },
      {"hole", "wrapped"}, 5e-7);
  rows.add(
      "bone riddled with holes",
      [] {
        return withBones({riddled(goodHumerus(), 0.1, 23), goodUlna()},
                         {goodHumerus(), goodUlna()});
      },
      {"hole", "non-manifold", "self-intersections", "wrapped"}, 2e-6);
  rows.add("bone every face twice",
           [] {
             return withBones({doubled(goodHumerus(), 1.0, true, 24), goodUlna()},
                              {goodHumerus(), goodUlna()});
           },
           {"duplicate-faces"});
  rows.add(
      "bone with noise of 1 mm",
      [] {
        return withBones({noisy(goodHumerus(), 1e-3, 25), goodUlna()},
                         {noisy(goodHumerus(), 1e-3, 25), goodUlna()});
      },
      {}, 5e-7);
  rows.add("bone of 80,000 faces", [] {
    return withBones({subdivided(goodHumerus(), 3), goodUlna()}, {goodHumerus(), goodUlna()});
  });
  rows.add("bone of 20 faces", [] {
    const SurfaceMesh coarse = egg({0, 0, 0.06}, {0.018, 0.016, 0.05}, 0, "humerus");
    return withBones({coarse, goodUlna()});
  });
  rows.add(
      "bone as one open sheet",
      [] {
        SurfaceMesh sheet = without(goodHumerus(), [](const Vector3& p) { return p.x() < 0.004; });
        return withBones({sheet, goodUlna()}, {goodUlna()});
      },
      {"hole", "wrapped"}, 2e-6);
  rows.add("bone with crumbs",
           [] {
             return withBones(
                 {withCrumbs(goodHumerus(), 50, 5e-5, {0.03, 0, 0.05}, 0.004, 26), goodUlna()},
                 {goodHumerus(), goodUlna()});
           },
           {"speck"});
  rows.refuse(
      "bone with a vertex that is no number",
      [] {
        SurfaceMesh m = goodHumerus();
        m.V(3, 0) = std::numeric_limits<double>::quiet_NaN();
        return withBones({m, goodUlna()});
      },
      ErrorCode::NonFiniteVertex);
  rows.refuse(
      "bone without faces",
      [] {
        SurfaceMesh m = goodHumerus();
        m.F.resize(0, 3);
        return withBones({m, goodUlna()});
      },
      ErrorCode::MeshWithoutFaces);
  rows.add(
      "bone of a thousand pieces",
      [] {
        std::vector<SurfaceMesh> pieces;
        for (int k = 0; k < 1000; ++k) {
          const Vector3 at(0.02 * (k % 10) / 10.0 - 0.01, 0.02 * (k / 10 % 10) / 10.0 - 0.01,
                           0.03 * (k / 100) / 10.0 + 0.02);
          pieces.push_back(egg(at, {0.0007, 0.0007, 0.0007}, 0, "piece"));
        }
        const SurfaceMesh all = together(pieces, "humerus");
        return withBones({all, goodUlna()});
      },
      {"full-density"}, 1.5e-6);

  // Bones among one another
  for (const int percent : {1, 3, 5, 10, 20, 30}) {
    rows.add(fmt::format("bones in one another by {} %", percent),
             [=] { return withBones(interpenetrating(percent / 100.0)); }, {"united"});
  }
  rows.add("bones that touch in a point", [] { return withBones(interpenetrating(0.0)); });
  rows.add("bones that share a face",
           [] {
             return withBones({block({-0.015, -0.015, 0}, {0.015, 0.015, 0.06}, "humerus"),
                               block({-0.015, -0.015, -0.06}, {0.015, 0.015, 0}, "ulna")});
           },
           {"united"});
  rows.add("bones that share part of a face",
           [] {
             return withBones({block({-0.015, -0.015, 0}, {0.015, 0.015, 0.06}, "humerus"),
                               block({-0.01, -0.012, -0.06}, {0.012, 0.01, 0}, "ulna")});
           },
           {"united"});
  rows.add("bones that share an edge",
           [] {
             return withBones({block({-0.015, -0.01, 0}, {0, 0.01, 0.06}, "humerus"),
                               block({0, -0.01, -0.06}, {0.015, 0.01, 0}, "ulna")});
           },
           {"united"});
  rows.add("bones 2 µm apart", [] {
    return withBones({block({-0.015, -0.015, 1e-6}, {0.015, 0.015, 0.06}, "humerus"),
                      block({-0.015, -0.015, -0.06}, {0.015, 0.015, -1e-6}, "ulna")});
  });
  rows.add("the same bone twice",
           [] {
             SurfaceMesh again = goodHumerus();
             again.name = "humerus again";
             return withBones({goodHumerus(), again, goodUlna()});
           },
           {"united"});
  rows.add("the same bone twice, the second a little larger",
           [] {
             SurfaceMesh again = scaled(goodHumerus(), 1.001);
             again.name = "humerus again";
             return withBones({goodHumerus(), again, goodUlna()});
           },
           {"united"});
  rows.add("spongy bone in compact bone",
           [] {
             SurfaceMesh spongy = scaled(goodHumerus(), 0.8);
             spongy.name = "spongy";
             return withBones({goodHumerus(), spongy, goodUlna()});
           },
           {"united"});
  rows.add("spongy bone in the hollow of compact bone",
           [] {
             SurfaceMesh spongy = scaled(goodHumerus(), 0.75);
             spongy.name = "spongy";
             return withBones(
                 {together({goodHumerus(), insideOut(scaled(goodHumerus(), 0.8))}, "humerus"),
                  spongy, goodUlna()},
                 {goodHumerus(), goodUlna()});
           },
           {"cavity", "closed-pocket"});
  rows.add("fifty bones in a heap",
           [] {
             std::vector<SurfaceMesh> bones;
             for (int k = 0; k < 50; ++k) {
               const Vector3 at(0.016 * std::cos(2.4 * k), 0.016 * std::sin(2.4 * k),
                                0.002 * k - 0.05);
               bones.push_back(ball(at, 0.0072 + 0.0003 * (k % 5), ""));
               bones.back().name = fmt::format("carpal {}", k + 1);
             }
             return withBones(bones);
           },
           {"united"});

  // Bones and the skin
  rows.add("bone halfway out",
           [] {
             return withBones({moved(goodHumerus(), {0.045, 0, 0}), goodUlna()});
           },
           {"pokes-out"});
  rows.add("bone right through",
           [] {
             return withBones({egg({0, 0, 0.03}, {0.08, 0.01, 0.01}, 3, "spear"), goodUlna()});
           },
           {"pokes-out"});
  rows.add("bone a hair out of the skin",
           [] {
             return withBones({egg({0.0302, 0, 0}, {0.02, 0.012, 0.03}, 4, "rib"), goodUlna()});
           },
           {"pokes-out"});
  rows.add("bone outside",
           [] {
             return withBones({moved(goodHumerus(), {0.2, 0, 0}), goodUlna()});
           },
           {"outside-skin"});
  rows.refuse(
      "all bones outside",
      [] {
        return withBones({moved(goodHumerus(), {0.2, 0, 0}), moved(goodUlna(), {0.2, 0, 0})});
      },
      ErrorCode::BonesOutsideSkin);
  rows.refuse(
      "bone around the skin",
      [] {
        return withBones({egg({0, 0, 0}, {0.1, 0.1, 0.2}, 3, "shell")});
      },
      ErrorCode::EmptyDomain);
  rows.refuse(
      "bone that is the skin",
      [] {
        SurfaceMesh m = goodSkin();
        m.name = "twin";
        return withBones({m});
      },
      ErrorCode::EmptyDomain);
  rows.refuse(
      "bone that cuts the tissue off from the skin",
      [] {
        return withBones(
            {together({scaled(goodSkin(), 0.9), insideOut(scaled(goodSkin(), 0.8))}, "armour")});
      },
      ErrorCode::ComponentWithoutSkin);
  rows.add("no bones", [] { return withBones({}); });
  return std::move(rows.rows);
}

}  // namespace ecorche::test
