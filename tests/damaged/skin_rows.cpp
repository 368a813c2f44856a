#include <cmath>
#include <limits>

#include <ecorche/mesh/mending.h>

#include "damaged/rows.h"

namespace ecorche::test {

namespace {

/// A part of the surface within this distance of a point.
Place near(const Vector3& at, double radius) {
  return [=](const Vector3& p) { return (p - at).norm() < radius; };
}
Place above(double z) {
  return [=](const Vector3& p) { return p.z() > z; };
}

const Vector3 kFlank(0.05, 0, 0);  // on the skin, half-way up

SurfaceMesh withVertex(SurfaceMesh m, double x) {
  m.V(17, 1) = x;
  return m;
}

SurfaceMesh withUnusedVertex(SurfaceMesh m, double x) {
  m.V.conservativeResize(m.V.rows() + 1, 3);
  m.V.bottomRows(1) << x, 0, 0;
  return m;
}

}  // namespace

std::vector<Row> skinRows() {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  constexpr double kInf = std::numeric_limits<double>::infinity();
  RowList rows;

  rows.add("nothing wrong", [] { return withSkin(goodSkin()); });
  // Sides
  rows.add("skin inside out", [] { return withSkin(insideOut(goodSkin())); }, {"inward"});
  rows.add("a third of the faces turned", [] { return withSkin(flipped(goodSkin(), 0.33, 1)); },
           {"inconsistent-orientation", "inward"});
  rows.add("half of the faces turned", [] { return withSkin(flipped(goodSkin(), 0.5, 2)); },
           {"inconsistent-orientation"});
  // Holes
  rows.add("hole of one face",
           [] {
             SurfaceMesh m = goodSkin();
             m.F.conservativeResize(m.F.rows() - 1, 3);
             return withSkin(m);
           },
           {"hole"});
  rows.add(
      "hole of 1.5 cm", [] { return withSkin(without(goodSkin(), near(kFlank, 0.0045))); },
      {"hole", "non-manifold", "self-intersections"}, 1e-7);
  rows.refuse(
      "hole of 6 cm", [] { return withSkin(without(goodSkin(), near(kFlank, 0.03))); },
      ErrorCode::SkinNotClosed);
  rows.refuse(
      "open at the scan's end", [] { return withSkin(without(goodSkin(), above(0.12))); },
      ErrorCode::SkinNotClosed);
  rows.add(
      "3 % of the faces missing", [] { return withSkin(riddled(goodSkin(), 0.03, 3)); },
      {"hole", "non-manifold", "self-intersections"}, 5e-7);
  // Cracks
  rows.add("every face on its own", [] { return withSkin(exploded(goodSkin(), 0.0, 4)); },
           {"duplicate-vertices"});
  rows.add("every face on its own, 1 µm off",
           [] { return withSkin(exploded(goodSkin(), 1e-6, 4)); }, {"crack"});
  rows.add("cut apart and put together again",
           [] { return withSkin(cracked(goodSkin(), 0.01, 0.0)); }, {"duplicate-vertices"});
  rows.add("a crack of 2 µm all around", [] { return withSkin(cracked(goodSkin(), 0.01, 2e-6)); },
           {"crack"});
  rows.refuse(
      "a crack of 1 mm all around", [] { return withSkin(cracked(goodSkin(), 0.01, 1e-3)); },
      ErrorCode::SkinNotClosed);
  rows.add("T-junctions", [] { return withSkin(withTJunctions(goodSkin(), 9)); }, {"t-junctions"});
  // Faces that should not be there
  rows.add("every face twice", [] { return withSkin(doubled(goodSkin(), 1.0, false, 5)); },
           {"duplicate-faces"});
  rows.add("every face twice, back to back",
           [] { return withSkin(doubled(goodSkin(), 1.0, true, 5)); }, {"duplicate-faces"});
  rows.add("a tenth of the faces twice", [] { return withSkin(doubled(goodSkin(), 0.1, true, 6)); },
           {"duplicate-faces"});
  rows.add("faces without area",
           [] {
             SurfaceMesh m = goodSkin();
             const auto count = m.F.rows();
             m.F.conservativeResize(count + 2, 3);
             m.F.row(count) << m.F(0, 0), m.F(0, 1), m.F(0, 1);
             m.F.row(count + 1) << m.F(5, 0), m.F(5, 0), m.F(5, 0);
             return withSkin(m);
           },
           {"degenerate-faces"});
  rows.add("needles", [] { return withSkin(withNeedles(goodSkin(), 7)); });
  rows.add("crumbs around it",
           [] {
             return withSkin(withCrumbs(goodSkin(), 30, 1e-4, {0.1, 0, 0}, 0.02, 7));
           },
           {"speck"});
  rows.add("crumbs inside it",
           [] {
             return withSkin(withCrumbs(goodSkin(), 30, 1e-4, {0.03, 0, 0}, 0.005, 8));
           },
           {"speck"});
  rows.add("three hundred crumbs of 5 mm, around it and inside, as of a scan",
           [] {
             const SurfaceMesh around = withCrumbs(goodSkin(), 200, 5e-3, {0.15, 0, 0}, 0.09, 15);
             return withSkin(withCrumbs(around, 100, 5e-3, {0.034, 0, 0}, 0.008, 16));
           },
           {"speck"});
  rows.add("twenty hair cards",
           [] {
             return withSkin(withSheets(goodSkin(), 20, 0.03, {0, 0, 0.15}, 0.02, 17));
           },
           {"sheet"});
  rows.refuse(
      "hair cards, and open at the scan's end",
      [] {
        return withSkin(
            withSheets(without(goodSkin(), above(0.12)), 20, 0.03, {0.05, 0, 0}, 0.02, 17));
      },
      ErrorCode::SkinNotClosed);
  rows.add("unused vertices", [] { return withSkin(withUnusedVertex(goodSkin(), 3.0)); },
           {"unused-vertices"});
  rows.add("an unused vertex that is no number",
           [] { return withSkin(withUnusedVertex(goodSkin(), kNaN)); }, {"unused-vertices"});
  // Numbers
  rows.refuse(
      "a vertex that is no number", [] { return withSkin(withVertex(goodSkin(), kNaN)); },
      ErrorCode::NonFiniteVertex);
  rows.refuse(
      "a vertex at infinity", [] { return withSkin(withVertex(goodSkin(), kInf)); },
      ErrorCode::NonFiniteVertex);
  rows.refuse(
      "no faces",
      [] {
        SurfaceMesh m = goodSkin();
        m.F.resize(0, 3);
        return withSkin(m);
      },
      ErrorCode::MeshWithoutFaces);
  rows.refuse(
      "all vertices at one place", [] { return withSkin(scaled(goodSkin(), 0.0)); },
      ErrorCode::MeshWithoutFaces);
  rows.refuse(
      "flat as a sheet of paper",
      [] {
        SurfaceMesh m = goodSkin();
        m.V.col(0).setZero();
        return withSkin(m);
      },
      ErrorCode::SkinNotClosed);
  // Shape
  rows.add(
      "noise of 0.2 mm", [] { return withSkin(noisy(goodSkin(), 2e-4, 9)); }, {}, 2e-6);
  rows.add(
      "noise of 2 mm: it cuts itself",
      [] { return withSkin(noisy(goodSkin(), 2e-3, 10), noisy(goodSkin(), 2e-3, 10)); },
      {"self-intersections"}, 5e-6);
  rows.add("decimated to 80 faces", [] {
    const SurfaceMesh m = egg({0, 0, 0}, {0.05, 0.045, 0.15}, 1, "skin");
    return withSkin(m, m);
  });
  rows.add("330,000 faces",
           [] {
             const SurfaceMesh m = subdivided(goodSkin(), 3);
             return withSkin(m);
           },
           {"dense"});
  rows.add("a dent that comes out behind",
           [] {
             const SurfaceMesh m = pushed(goodSkin(), near(kFlank, 0.012), {-0.104, 0, 0});
             return withSkin(m, m);
           },
           {"pokes-out", "self-intersections"});
  rows.add("a fold", [] {
    const SurfaceMesh m = pushed(goodSkin(), near(kFlank, 0.014), {-0.004, 0.0, 0.03});
    return withSkin(m, m);
  });
  rows.add("a pocket, as a mouth", [] {
    const SurfaceMesh m = pocketed(goodSkin(), kFlank, 0.018, 0.02);
    return withSkin(m, m);
  });
  rows.add("two halves through one another",
           [] {
             const SurfaceMesh a = egg({0, 0, 0.02}, {0.05, 0.045, 0.13}, 3, "skin");
             const SurfaceMesh b = egg({0, 0, -0.021}, {0.049, 0.046, 0.13}, 3, "skin");
             Made m = withSkin(together({a, b}, "skin"), together({a, b}, "skin"));
             return m;
           },
           {"self-intersections"});
  // Shells
  rows.add("an eyeball within",
           [] {
             return withSkin(
                 together({goodSkin(), egg({0.03, 0, 0}, {0.008, 0.008, 0.008}, 2, "eye")}, "skin"),
                 goodSkin());
           },
           {"inner-shell"});
  rows.add("two coats, one within the other",
           [] {
             return withSkin(together({goodSkin(), scaled(goodSkin(), 0.97)}, "skin"), goodSkin());
           },
           {"inner-shell"});
  rows.refuse(
      "a thick shell: the inside is hollow",
      [] {
        return withSkin(together({goodSkin(), insideOut(scaled(goodSkin(), 0.97))}, "skin"));
      },
      ErrorCode::BonesOutsideSkin);
  rows.add("a wall across the middle",
           [] {
             const SurfaceMesh m = ringedEgg({0, 0, 0}, {0.05, 0.045, 0.15}, 31, 32, "skin");
             return withSkin(withInnerWall(m, 0.0), m);
           },
           {"inner-wall"});
  rows.add("a second body beside it", [] {
    const SurfaceMesh both =
        together({goodSkin(), egg({0.2, 0, 0}, {0.02, 0.02, 0.02}, 3, "hat")}, "skin");
    return withSkin(both, both);
  });

  // What is asked for
  const auto asked = [](SurfaceMesh damaged, SurfaceMesh meant, mesh::Mending how) {
    RunContext run;
    auto mended = mesh::mendSurface(damaged, how, run);
    Made out = withSkin(mended ? std::move(mended->mesh) : std::move(damaged), std::move(meant));
    if (mended) out.asked = std::move(mended->findings);
    return out;
  };
  using mesh::Mending;
  rows.add(
      "hole of 6 cm, to be filled",
      [=] {
        return asked(without(goodSkin(), near(kFlank, 0.03)), goodSkin(), Mending::FillHoles);
      },
      {"hole"}, 1.5e-5);
  rows.add(
      "open at the scan's end, to be filled",
      [=] {
        // What is meant is cut off there
        Made out = asked(without(goodSkin(), above(0.12)), goodSkin(), Mending::FillHoles);
        out.truth.cutPlanes = {{"end", {0, 0, 0.12}, {0, 0, -1}}};
        return out;
      },
      {"hole"}, 1e-5);
  rows.add(
      "hair cards, and open at the scan's end, to be filled",
      [=] {
        Made out =
            asked(withSheets(without(goodSkin(), above(0.12)), 20, 0.03, {0.05, 0, 0}, 0.02, 17),
                  goodSkin(), Mending::FillHoles);
        out.truth.cutPlanes = {{"end", {0, 0, 0.12}, {0, 0, -1}}};
        return out;
      },
      {"hole", "sheet"}, 1e-5);
  rows.add(
      "open at the scan's end, to be wrapped",
      [=] {
        Made out = asked(without(goodSkin(), above(0.12)), goodSkin(), Mending::Wrap);
        out.truth.cutPlanes = {{"end", {0, 0, 0.12}, {0, 0, -1}}};
        return out;
      },
      {"hole", "wrap"}, 2.5e-5);
  rows.add(
      "a crack of 1 mm all around, to be wrapped",
      [=] {
        return asked(cracked(goodSkin(), 0.01, 1e-3), cracked(goodSkin(), 0.01, 1e-3),
                     Mending::Wrap);
      },
      {"hole", "wrap"}, 2e-5);
  rows.add("a thick shell, to be taken from outside",
           [=] {
             return asked(together({goodSkin(), insideOut(scaled(goodSkin(), 0.97))}, "skin"),
                          goodSkin(), Mending::OuterHull);
           },
           {"outer-hull"});
  rows.add(
      "noise and holes, to be wrapped",
      [=] {
        return asked(riddled(noisy(goodSkin(), 1e-3, 12), 0.05, 13), goodSkin(), Mending::Wrap);
      },
      {"hole", "non-manifold", "sheet", "wrap"}, 3e-5);
  rows.add(
      "a skin with a wall of its own thickness, to be wrapped",
      [=] {
        return asked(together({goodSkin(), insideOut(scaled(goodSkin(), 0.97))}, "skin"),
                     goodSkin(), Mending::Wrap);
      },
      {"wrap"}, 2e-5);
  return std::move(rows.rows);
}

}  // namespace ecorche::test
