#include <fmt/format.h>

#include "damaged/rows.h"
#include "support/shapes.h"

namespace ecorche::test {

namespace {

Made limb(const std::function<void(domain::DomainInput&)>& change) {
  Made out{goodLimb(), goodLimb(), {}};
  change(out.input);
  change(out.truth);
  return out;
}

Made wholeIn(double factor) {
  return limb([=](domain::DomainInput& in) {
    in.skin = inUnits(in.skin, factor);
    for (auto& bone : in.bones) bone = inUnits(bone, factor);
  });
}

}  // namespace

std::vector<Row> togetherRows() {
  RowList rows;

  // Units: what mixes metres with decimetres, inches, centimetres, millimetres
  for (const double factor : {10.0, 25.4, 100.0, 1000.0}) {
    rows.refuse(
        fmt::format("bones {} times too large", factor),
        [=] {
          return withBones({inUnits(goodHumerus(), factor), inUnits(goodUlna(), factor)});
        },
        ErrorCode::UnitsDiffer);
    // That could be meant, so it is told and done
    rows.add(
        fmt::format("skin {} times too large", factor),
        [=] { return withSkin(inUnits(goodSkin(), factor), inUnits(goodSkin(), factor)); },
        {"units"}, 0.0);
    rows.refuse(
        fmt::format("one bone {} times too large", factor),
        [=] {
          return withBones({inUnits(goodHumerus(), factor), goodUlna()});
        },
        ErrorCode::UnitsDiffer);
  }
  rows.add("one bone 1000 times too small",
           [] {
             return withBones({inUnits(goodHumerus(), 1e-3), goodUlna()});
           },
           {"units"});
  rows.add("a sesamoid bone of 3 mm: small, and no fault", [] {
    return withBones({goodHumerus(), goodUlna(), ball({0.03, 0, 0}, 0.0015, "sesamoid")});
  });
  rows.add(
      "all in micrometres", [] { return wholeIn(1e-6); }, {}, 0.0, 1e-6);
  rows.add(
      "all in kilometres", [] { return wholeIn(1e3); }, {}, 0.0, 1e3);
  rows.add("10 km from the origin", [] {
    return limb([](domain::DomainInput& in) {
      in.skin = moved(in.skin, {1e4, -1e4, 1e4});
      for (auto& bone : in.bones) bone = moved(bone, {1e4, -1e4, 1e4});
    });
  });

  // Cut planes
  rows.add("cut in half through vertices", [] {
    return limb([](domain::DomainInput& in) { in.cutPlanes = {{"half", {0, 0, 0}, {1, 0, 0}}}; });
  });
  rows.add("cut aslant in three", [] {
    return limb([](domain::DomainInput& in) {
      in.cutPlanes = {{"a", {0, 0, 0.05}, Vector3(1, 2, -3).normalized()},
                      {"b", {0, 0, -0.05}, Vector3(0.1, 0, 1).normalized()}};
    });
  });
  rows.add("open at the scan's end, and cut before it",
           [] {
             Made out = limb([](domain::DomainInput& in) {
               in.cutPlanes = {{"end", {0, 0, 0.1}, {0, 0, -1}}};
             });
             out.input.skin =
                 without(out.input.skin, [](const Vector3& p) { return p.z() > 0.125; });
             return out;
           },
           {"hole"});
  rows.refuse(
      "cut plane beyond everything",
      [] {
        return limb([](domain::DomainInput& in) {
          in.cutPlanes = {{"far", {5, 0, 0}, {1, 0, 0}}};
        });
      },
      ErrorCode::EmptyDomain);
  rows.refuse(
      "cut plane that leaves no bone and no skin but a film",
      [] {
        return limb([](domain::DomainInput& in) {
          in.cutPlanes = {{"film", {0.05, 0, 0}, {1, 0, 0}}};
        });
      },
      ErrorCode::EmptyDomain);

  // Obstacles and cavities
  rows.add("an obstacle and a cavity", [] {
    return limb([](domain::DomainInput& in) {
      in.obstacles = {ball({0.03, 0, 0}, 0.008, "ligament")};
      in.cavities = {ball({-0.03, 0, 0}, 0.008, "vein")};
    });
  });
  rows.add("an obstacle in a bone and a cavity that comes out of the skin",
           [] {
             return limb([](domain::DomainInput& in) {
               in.obstacles = {ball({0.018, 0, 0.06}, 0.008, "ligament")};
               in.cavities = {ball({-0.045, 0, 0}, 0.012, "wound")};
             });
           },
           {"pokes-out", "united"});
  rows.add(
      "an open obstacle",
      [] {
        Made out = limb([](domain::DomainInput& in) {
          in.obstacles = {ball({0.03, 0, 0}, 0.008, "ligament")};
        });
        out.input.obstacles[0] =
            without(out.input.obstacles[0], [](const Vector3& p) { return p.x() > 0.034; });
        return out;
      },
      {"hole", "wrapped"}, 3e-7);
  rows.add("a cavity outside",
           [] {
             return limb([](domain::DomainInput& in) {
               in.cavities = {ball({-0.2, 0, 0}, 0.012, "nothing")};
             });
           },
           {"outside-skin"});
  rows.refuse(
      "a cavity that takes everything",
      [] {
        return limb([](domain::DomainInput& in) {
          in.cavities = {egg({0, 0, 0}, {0.2, 0.2, 0.3}, 3, "abyss")};
        });
      },
      ErrorCode::EmptyDomain);

  // Everything at once
  rows.add(
      "turned, doubled, exploded and poked through, all at once",
      [] {
        Made out{goodLimb(), goodLimb(), {}};
        out.input.skin = exploded(doubled(flipped(goodSkin(), 0.3, 31), 0.2, true, 32), 0.0, 33);
        out.input.bones = {insideOut(exploded(goodHumerus(), 0.0, 34)),
                           riddled(goodUlna(), 0.02, 35), ball({0.045, 0, 0}, 0.01, "claw")};
        out.truth.bones.push_back(out.input.bones.back());
        return out;
      },
      {"duplicate-faces", "duplicate-vertices", "hole", "inconsistent-orientation", "inward",
       "non-manifold", "pokes-out", "self-intersections"},
      5e-7);
  return std::move(rows.rows);
}

}  // namespace ecorche::test
