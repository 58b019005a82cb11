// SPDX-License-Identifier: BSD-3-Clause
#include "core/vio/triangulate.h"

#include <algorithm>
#include <cmath>

namespace covey::vio {
namespace {

constexpr double kNearest = 0.2;  // m

struct InverseDepth {
  double information = 0.0;
  double weighted = 0.0;

  // q = q_0 + w q_1 is seen at m.
  void add(const Eigen::Vector3d& q_0, const Eigen::Vector3d& q_1, const Eigen::Vector2d& m, double sigma) {
    const Eigen::Vector2d slope = q_1.head<2>() - q_1.z() * m;
    const Eigen::Vector2d offset = q_0.head<2>() - q_0.z() * m;
    const double weight = 1.0 / (sigma * sigma * q_0.z() * q_0.z());
    information += weight * slope.squaredNorm();
    weighted -= weight * slope.dot(offset);
  }
};

const View& choose_chart(std::span<const View> views) {
  for (std::size_t k = views.size(); k-- > 0;) {
    if (views[k].seen->right) return views[k];
  }
  return views.back();
}

}  // namespace

std::optional<Landmark> triangulate(const StereoRig& rig, std::span<const View> views, double gate,
                                    double max_sigma) {
  const View& chart = choose_chart(views);
  Landmark landmark{chart.T_O_B * rig.T_L_B.inverse(), {chart.seen->left.x(), chart.seen->left.y(), 0.0}};
  const Eigen::Vector3d direction(chart.seen->left.x(), chart.seen->left.y(), 1.0);
  InverseDepth sum;
  const auto add = [&](const SE3& T_C_B, const View& view, const Eigen::Vector2d& m) {
    const SE3 T_C_A = T_C_B * view.T_O_B.inverse() * landmark.T_O_A;
    const Eigen::Vector3d q_0 = T_C_A.rotation * direction;
    if (q_0.z() > 0.1) sum.add(q_0, T_C_A.translation, m, view.seen->sigma);
  };
  for (const View& view : views) {
    if (view.seen != chart.seen) add(rig.T_L_B, view, view.seen->left);
    if (view.seen->right) add(rig.T_R_B, view, *view.seen->right);
  }
  if (!(sum.information > 1.0 / (max_sigma * max_sigma))) return std::nullopt;
  const double sigma = 1.0 / std::sqrt(sum.information);
  landmark.l.z() = sum.weighted / sum.information;
  if (!(landmark.l.z() > -3.0 * sigma && landmark.l.z() < 1.0 / kNearest)) return std::nullopt;
  landmark.l.z() = std::max(landmark.l.z(), 0.0);

  for (const View& view : views) {
    if (!agrees(rig, view.T_O_B, landmark, *view.seen, gate)) return std::nullopt;
  }
  return landmark;
}

}  // namespace covey::vio
