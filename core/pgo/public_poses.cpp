// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/public_poses.h"

#include <algorithm>
#include <cmath>

namespace covey::pgo {
namespace {

constexpr double kLargest = 32767.0;

template <typename T>
SE3 read_pose(const std::vector<T>& values, int k) {
  const T* v = values.data() + 7 * static_cast<std::ptrdiff_t>(k);
  return {SO3::from_quaternion(Eigen::Quaterniond(v[0], v[1], v[2], v[3])),
          Eigen::Vector3d(v[4], v[5], v[6])};
}

template <typename T>
bool quaternions_are_good(const std::vector<T>& values) {
  for (std::size_t k = 0; k + 7 <= values.size(); k += 7) {
    double square = 0.0;
    for (std::size_t i = k; i < k + 4; ++i)
      square += static_cast<double>(values[i]) * static_cast<double>(values[i]);
    if (!(std::abs(square - 1.0) < 0.01)) return false;
  }
  return true;
}

}  // namespace

void append_pose(const SE3& T, std::vector<double>& values) {
  const Eigen::Quaterniond q = T.rotation.canonical_quaternion();
  values.insert(values.end(),
                {q.w(), q.x(), q.y(), q.z(), T.translation.x(), T.translation.y(), T.translation.z()});
}

SE3 pose_at(const std::vector<double>& values, int k) { return read_pose(values, k); }
SE3 pose_at(const std::vector<float>& values, int k) { return read_pose(values, k); }
bool poses_are_good(const std::vector<double>& values) { return quaternions_are_good(values); }
bool poses_are_good(const std::vector<float>& values) { return quaternions_are_good(values); }

void encode_differences(const Lifted& differences, dpgo_update_t& message) {
  double rotation = 0.0;
  double translation = 0.0;
  int rows = 0;
  for (Eigen::Index c = 0; c < differences.cols(); ++c) {
    double& largest = c % 4 == 3 ? translation : rotation;
    largest = std::max(largest, differences.col(c).cwiseAbs().maxCoeff());
  }
  for (int r = 0; r < differences.rows(); ++r) {
    if (differences.row(r).cwiseAbs().maxCoeff() > 0.0) rows = r + 1;
  }
  message.rows = static_cast<std::int8_t>(rows);
  message.rotation_scale = static_cast<float>(rotation / kLargest);
  message.translation_scale = static_cast<float>(translation / kLargest);
  message.values.clear();
  for (Eigen::Index c = 0; c < differences.cols(); ++c) {
    const double scale = c % 4 == 3 ? message.translation_scale : message.rotation_scale;
    for (int r = 0; r < rows; ++r) {
      const double units = scale > 0.0 ? std::round(differences(r, c) / scale) : 0.0;
      message.values.push_back(static_cast<std::int16_t>(std::clamp(units, -kLargest, kLargest)));
    }
  }
  message.n_values = static_cast<std::int32_t>(message.values.size());
}

bool fits(const dpgo_update_t& message, const Lifted& poses) {
  return message.rows <= poses.rows() &&
         (message.rows == 0 || message.n_values == static_cast<std::int64_t>(message.rows) * poses.cols());
}

void add_differences(const dpgo_update_t& message, Lifted& poses) {
  if (message.rows == 0) return;
  std::size_t k = 0;
  for (Eigen::Index c = 0; c < poses.cols(); ++c) {
    const double scale = c % 4 == 3 ? message.translation_scale : message.rotation_scale;
    for (int r = 0; r < message.rows; ++r) poses(r, c) += scale * message.values[k++];
  }
}

}  // namespace covey::pgo
