// SPDX-License-Identifier: BSD-3-Clause
#include "core/geometry/alignment.h"

#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

#include "core/base/error.h"

namespace covey {
namespace {

Eigen::Vector3d mean(const std::vector<Eigen::Vector3d>& points) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const auto& p : points) sum += p;
  return sum / static_cast<double>(points.size());
}

bool is_planar(const std::vector<Eigen::Vector3d>& points) {
  return std::all_of(points.begin(), points.end(), [](const Eigen::Vector3d& p) { return p.z() == 0.0; });
}

// The R in SO(3) that maximises tr(R^T cross).
Eigen::Matrix3d best_rotation(const Eigen::Matrix3d& cross) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(cross, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Vector3d signs = Eigen::Vector3d::Ones();
  if (svd.matrixU().determinant() * svd.matrixV().determinant() < 0.0) signs.z() = -1.0;
  return svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
}

// The same among rotations about z. Unlike the general one it is unique on a line and never flips the plane
// over.
Eigen::Matrix3d best_planar_rotation(const Eigen::Matrix3d& cross) {
  const double angle = std::atan2(cross(1, 0) - cross(0, 1), cross(0, 0) + cross(1, 1));
  return Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()).toRotationMatrix();
}

}  // namespace

Alignment align_points(const std::vector<Eigen::Vector3d>& from, const std::vector<Eigen::Vector3d>& to,
                       bool with_scale) {
  COVEY_CHECK(from.size() == to.size() && !from.empty());
  const Eigen::Vector3d from_mean = mean(from);
  const Eigen::Vector3d to_mean = mean(to);
  Eigen::Matrix3d cross = Eigen::Matrix3d::Zero();
  double from_variance = 0.0;
  for (std::size_t k = 0; k < from.size(); ++k) {
    cross += (to[k] - to_mean) * (from[k] - from_mean).transpose();
    from_variance += (from[k] - from_mean).squaredNorm();
  }
  const Eigen::Matrix3d R =
      is_planar(from) && is_planar(to) ? best_planar_rotation(cross) : best_rotation(cross);

  Alignment alignment;
  alignment.T_to_from.rotation = SO3::from_matrix(R);
  if (with_scale && from_variance > 0.0) alignment.scale = R.cwiseProduct(cross).sum() / from_variance;
  alignment.T_to_from.translation =
      to_mean - alignment.T_to_from.rotation * Eigen::Vector3d(alignment.scale * from_mean);
  double squared = 0.0;
  for (std::size_t k = 0; k < from.size(); ++k) squared += (to[k] - alignment * from[k]).squaredNorm();
  alignment.rms = std::sqrt(squared / static_cast<double>(from.size()));
  return alignment;
}

}  // namespace covey
