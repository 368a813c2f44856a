#include <ecorche/core/contract.h>
#include <ecorche/render/light_rig.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

namespace ecorche::render {
namespace {

using mesh::Vector3;

const Eigen::Vector3f kKeyColour{1.0f, 0.965f, 0.91f};
const Eigen::Vector3f kRimColour{0.86f, 0.93f, 1.0f};
const Eigen::Vector3f kSkyAbove{0.98f, 0.99f, 1.0f};
const Eigen::Vector3f kSkyBelow{0.42f, 0.37f, 0.35f};
constexpr float kKeyShare = 0.60f;  // of what the reference surface receives; the rest is sky
constexpr float kRimIrradiance = 0.30f;

double fraction(double x) { return x - std::floor(x); }

// Two axes across a direction.
void axesAcross(const Vector3& d, Vector3& a, Vector3& b) {
  a = d.unitOrthogonal();
  b = d.cross(a);
}

// The i-th of a low-discrepancy set of directions within a cone [Roberts 2018: the R2 sequence].
Vector3 inCone(const Vector3& axis, double radius, int i) {
  const double u = fraction(0.5 + 0.7548776662466927 * i);
  const double v = fraction(0.5 + 0.5698402909980532 * i);
  const double r = radius * std::sqrt(u);
  const double phi = 2.0 * std::numbers::pi * v;
  Vector3 a, b;
  axesAcross(axis, a, b);
  return (axis + std::tan(r) * (std::cos(phi) * a + std::sin(phi) * b)).normalized();
}

// The i-th of n directions spread evenly over the part of the sphere with dot(direction, axis)
// above `low`.
Vector3 onDome(const Vector3& axis, double low, int i, int n) {
  const double z = 1.0 - (1.0 - low) * (i + 0.5) / n;
  const double phi = 2.0 * std::numbers::pi * fraction(i * (std::numbers::phi - 1.0));
  Vector3 a, b;
  axesAcross(axis, a, b);
  const double r = std::sqrt(std::max(0.0, 1.0 - z * z));
  return (z * axis + r * (std::cos(phi) * a + std::sin(phi) * b)).normalized();
}

}  // namespace

EyeAxes eyeAxes(const Camera& camera) {
  EyeAxes axes;
  const Vector3 away = camera.eye - camera.target;
  EC_REQUIRE(away.norm() > 0.0);
  axes.back = away.normalized();
  Vector3 right = camera.up.cross(axes.back);
  if (right.norm() < 1e-9 * std::max(camera.up.norm(), 1e-300)) right = axes.back.unitOrthogonal();
  axes.right = right.normalized();
  axes.up = axes.back.cross(axes.right);
  return axes;
}

SkyLight skyLight(float exposure) {
  // The reference surface is turned halfway between eye and up: its share of the way from below
  const float height = 0.5f + 0.5f * std::sqrt(0.5f);
  const float received = (kSkyBelow + height * (kSkyAbove - kSkyBelow)).mean();
  const float scale = exposure * (1.0f - kKeyShare) / received;
  return {scale * kSkyAbove, scale * kSkyBelow};
}

std::vector<LightSample> lightsOfPass(const Camera& camera, const LightRigOptions& o, int pass) {
  EC_REQUIRE(pass >= 0 && pass < o.passes);
  const EyeAxes eye = eyeAxes(camera);
  const Vector3 keyAxis = (-0.55 * eye.right + 0.85 * eye.up + 0.75 * eye.back).normalized();
  const Vector3 rimAxis = (0.75 * eye.right + 0.45 * eye.up - 0.45 * eye.back).normalized();
  const Vector3 skyAxis = (0.55 * eye.up + 0.85 * eye.back).normalized();
  const Vector3 reference = (eye.up + eye.back).normalized();

  std::vector<LightSample> lights;
  const auto received = [&](std::size_t from, std::size_t to) {
    float sum = 0.0f;
    for (std::size_t i = from; i < to; ++i)
      sum += lights[i].irradiance.mean() *
             static_cast<float>(std::max(0.0, lights[i].direction.dot(reference)));
    return sum;
  };
  const auto scale = [&](std::size_t from, std::size_t to, float factor) {
    for (std::size_t i = from; i < to; ++i) lights[i].irradiance *= factor;
  };

  for (int k = 0; k < o.keyPerPass; ++k)
    lights.push_back({inCone(keyAxis, 0.20, pass + k * o.passes), kKeyColour, true});
  const std::size_t rimBegin = lights.size();
  scale(0, rimBegin, o.exposure * kKeyShare / std::max(received(0, rimBegin), 1e-6f));
  for (int k = 0; k < o.rimPerPass; ++k)
    lights.push_back({inCone(rimAxis, 0.22, pass + k * o.passes),
                      kRimColour * (o.exposure * kRimIrradiance / static_cast<float>(o.rimPerPass)),
                      true});

  const std::size_t skyBegin = lights.size();
  for (int k = 0; k < o.skyPerPass; ++k) {
    const Vector3 d = onDome(skyAxis, -0.30, pass + k * o.passes, o.passes * o.skyPerPass);
    const float height = 0.5f + 0.5f * static_cast<float>(d.dot(eye.up));
    lights.push_back({d, kSkyBelow + height * (kSkyAbove - kSkyBelow), false});
  }
  if (o.skyPerPass == 0) return lights;
  scale(skyBegin, lights.size(),
        o.exposure * (1.0f - kKeyShare) / std::max(received(skyBegin, lights.size()), 1e-6f));
  return lights;
}

}  // namespace ecorche::render
