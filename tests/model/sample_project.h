#pragma once

#include <string>
#include <string_view>

namespace ecorche::test {

/// A project file that uses every key of schema 1. Lines and columns are counted on by the tests of
/// errors.
inline constexpr std::string_view kFullProject = R"({
  "schema": 1,
  "name": "forearm",
  "unit": "cm",
  "skin": {"file": "skin.obj", "part": "body", "unit": "mm"},
  "bones": [
    {"name": "humerus", "file": "bones.obj", "part": "humerus"},
    {"name": "radius", "file": "bones/radius.stl", "unit": "m"}
  ],
  "cut_planes": [
    {"name": "median", "kind": "symmetry", "point": [0, 0, 0], "normal": [0, 1, 0]},
    {"name": "elbow", "kind": "region", "point": [-20, 0, 0], "normal": [-1, 0, 0]}
  ],
  "settings": {"fat": 0.25, "core_radius": 0.15, "tets": 200000, "surface_tolerance": 0.002},
  "tissues": [
    {"name": "fat", "kind": "fat", "color": "#f0e0a0"},
    {
      "name": "biceps",
      "kind": "muscle",
      "side": "left",
      "group": "arm",
      "layer": 1,
      "color": "#c0504d",
      "keeps_twin": true,
      "core_radius": 0.1,
      "anisotropy": {"lambda2": 2, "lambda3": 0.5, "rotation": 30},
      "curves": [
        {
          "name": "long head",
          "points": [
            {"at": [1, 2, 3], "tissue": 1},
            {"at": [2.5, 3, 5], "tissue": 1.25},
            {"at": [4, 4, 8], "tissue": 0.75}
          ],
          "start": {"on": "bone", "name": "humerus"},
          "end": {"on": "bone", "name": "radius"}
        },
        {
          "name": "short head",
          "points": [
            {"at": [1, 3, 3], "tissue": 1},
            {"at": [4, 4, 7], "tissue": 1}
          ],
          "start": {"on": "plane", "name": "median"},
          "end": {"on": "tissue", "name": "belly"}
        }
      ],
      "attachments": [
        {"role": "origin", "on": "bone", "name": "humerus", "at": [1, 2, 3]},
        {
          "role": "insertion",
          "on": "bone",
          "name": "radius",
          "patch": {"file": "patches.obj", "part": "tuberosity", "unit": "mm"}
        }
      ]
    },
    {
      "name": "belly",
      "kind": "filler",
      "curves": [
        {
          "points": [
            {"at": [0, 0, 0], "tissue": 1},
            {"at": [0, 0, 9], "tissue": 1}
          ]
        }
      ]
    },
    {"name": "spleen", "kind": "obstacle", "file": "spleen.obj"},
    {"name": "abdomen", "kind": "cavity", "group": "gut", "file": "organs.glb", "part": "abdomen"}
  ]
}
)";

/// The sample with one piece of its text replaced.
inline std::string fullProjectWith(std::string_view from, std::string_view to) {
  std::string text(kFullProject);
  const std::size_t at = text.find(from);
  if (at == std::string::npos) return {};
  return text.replace(at, from.size(), to);
}

}  // namespace ecorche::test
