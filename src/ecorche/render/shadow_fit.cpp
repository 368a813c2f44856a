#include <ecorche/render/shadow_fit.h>

#include <Eigen/Geometry>
#include <algorithm>

namespace ecorche::render {
namespace {

// True unless all three corners lie beyond one side of the picture.
bool mayShow(const Eigen::Vector3f* corner, const Eigen::Matrix4f& m) {
  int beyond[4] = {0, 0, 0, 0};
  for (int k = 0; k < 3; ++k) {
    const Eigen::Vector4f c = m * corner[k].homogeneous();
    const float w = 1.02f * c.w();
    beyond[0] += c.x() > w;
    beyond[1] += c.x() < -w;
    beyond[2] += c.y() > w;
    beyond[3] += c.y() < -w;
  }
  return *std::max_element(beyond, beyond + 4) < 3;
}

constexpr std::size_t kEnoughPoints = 30'000;

}  // namespace

ShadowFocus shadowFocus(const std::vector<Eigen::Vector3f>& corners,
                        const Eigen::Matrix4f& worldToClip) {
  ShadowFocus focus;
  for (std::size_t i = 0; i + 2 < corners.size(); i += 3)
    if (mayShow(&corners[i], worldToClip))
      focus.points.insert(focus.points.end(), &corners[i], &corners[i] + 3);
  if (focus.points.empty()) focus.points = corners;
  if (focus.points.empty()) focus.points.push_back(Eigen::Vector3f::Zero());

  focus.lo = focus.hi = focus.points.front();
  for (const Eigen::Vector3f& p : focus.points) {
    focus.lo = focus.lo.cwiseMin(p);
    focus.hi = focus.hi.cwiseMax(p);
  }
  const std::size_t stride = focus.points.size() / kEnoughPoints + 1;
  for (std::size_t i = 0; i * stride < focus.points.size(); ++i)
    focus.points[i] = focus.points[i * stride];
  focus.points.resize((focus.points.size() + stride - 1) / stride);
  if (focus.lo == focus.hi) focus.hi += Eigen::Vector3f::Constant(1e-6f);
  return focus;
}

ShadowMap shadowMap(const ShadowFocus& focus, const mesh::Vector3& towardsLight, int size) {
  const Eigen::Vector3f back = towardsLight.cast<float>().normalized();
  const Eigen::Vector3f right = back.unitOrthogonal();
  const Eigen::Vector3f up = back.cross(right);
  Eigen::Matrix3f axes;
  axes << right.transpose(), up.transpose(), back.transpose();

  Eigen::Vector3f lo = axes * focus.points.front();
  Eigen::Vector3f hi = lo;
  for (const Eigen::Vector3f& p : focus.points) {
    const Eigen::Vector3f q = axes * p;
    lo = lo.cwiseMin(q);
    hi = hi.cwiseMax(q);
  }
  // Points were thinned out: leave some room around, and two texels
  const float slack =
      0.02f * (hi - lo).head<2>().maxCoeff() + 2.0f * static_cast<float>(focus.diameter()) / size;
  const float half = 0.5f * std::max(hi.x() - lo.x(), hi.y() - lo.y()) + slack;
  const Eigen::Vector3f middle = 0.5f * (lo + hi);
  const float depthHalf = 0.5f * static_cast<float>(focus.depth());

  ShadowMap map;
  map.worldToClip.setIdentity();
  map.worldToClip.row(0).head<3>() = axes.row(0) / half;
  map.worldToClip.row(1).head<3>() = axes.row(1) / half;
  map.worldToClip.row(2).head<3>() = -axes.row(2) / depthHalf;
  map.worldToClip(0, 3) = -middle.x() / half;
  map.worldToClip(1, 3) = -middle.y() / half;
  map.worldToClip(2, 3) = middle.z() / depthHalf;

  Eigen::Matrix4f toUnit = Eigen::Matrix4f::Identity();
  toUnit.diagonal().head<3>().setConstant(0.5f);
  toUnit.col(3).head<3>().setConstant(0.5f);
  map.worldToTexture = toUnit * map.worldToClip;
  return map;
}

}  // namespace ecorche::render
