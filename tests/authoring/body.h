#pragma once

#include <ecorche/authoring/attachments.h>
#include <ecorche/authoring/snap.h>

#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "authoring/shapes.h"

namespace ecorche::test {

using authoring::BoneSurface;
using authoring::boneSurface;
using authoring::MuscleSites;
using mesh::Vector3;

/// A lumpy body with some bones in it, apart from one another and from the skin.
struct Body {
  mesh::SurfaceMesh skinMesh;
  std::vector<BoneSurface> bones;
  std::vector<MuscleSites> table;

  explicit Body(std::uint32_t seed) {
    std::mt19937 random(seed);
    const auto within = [&](double lo, double hi) {
      return std::uniform_real_distribution<double>(lo, hi)(random);
    };
    const Vector3 lumps(within(1, 4), within(1, 4), within(1, 4));
    skinMesh = ball(4, [&](const Vector3& p) -> Vector3 {
      const double r = 1.0 + 0.08 * std::sin(3.0 * p.dot(lumps));
      return r * p.cwiseProduct(Vector3(1.6, 1.0, 1.2));
    });
    const mesh::SurfaceQuery skin(skinMesh);
    const int wanted = 4 + static_cast<int>(seed % 5);
    for (int trial = 0; trial < 400 && static_cast<int>(bones.size()) < wanted; ++trial) {
      const Vector3 centre(within(-1.3, 1.3), within(-0.8, 0.8), within(-1, 1));
      const Vector3 axes(within(0.08, 0.35), within(0.08, 0.2), within(0.08, 0.35));
      const auto mesh =
          ball(3, [&](const Vector3& p) -> Vector3 { return centre + p.cwiseProduct(axes); });
      double room = 1.0;
      for (Eigen::Index v = 0; v < mesh.V.rows(); ++v) {
        const Vector3 p = mesh.V.row(v);
        room = std::min(room, skin.inside(p) ? skin.distance(p) : 0.0);
        for (const BoneSurface& other : bones)
          room = std::min(room, other.surface->signedDistance(p));
      }
      if (room < 0.08) continue;
      bones.push_back(
          boneSurface("bone" + std::string(1, 'a' + static_cast<char>(bones.size())), mesh));
    }
    // Muscles from any place on one bone to any place on another
    for (int m = 0; m < 8; ++m) {
      MuscleSites muscle{"m" + std::to_string(m), {}};
      const std::size_t first = random() % bones.size();
      const std::size_t second = (first + 1 + random() % (bones.size() - 1)) % bones.size();
      for (const std::size_t b : {first, second}) {
        const Vector3 off = Vector3(within(-1, 1), within(-1, 1), within(-1, 1)).normalized();
        const Vector3 at = bones[b].surface->closest(bones[b].box.centre() + 0.5 * off).point;
        muscle.sites.push_back(
            {.muscle = muscle.muscle, .bone = bones[b].name, .at = at, .patchFile = {}});
      }
      table.push_back(std::move(muscle));
    }
  }
};

}  // namespace ecorche::test
