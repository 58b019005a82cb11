// SPDX-License-Identifier: BSD-3-Clause
#include "core/geometry/camera_fields.h"

#include <algorithm>

namespace covey {

std::vector<double> read_numbers(ConfigSection& section, const std::string& key, std::size_t count) {
  std::vector<double> numbers;
  section.read(key, numbers);
  if (numbers.size() != count) {
    throw_input_error("{}: {} numbers are needed, there are {}", section.where(key), count, numbers.size());
  }
  return numbers;
}

void set_size(PinholeCamera& camera, int width, int height, const std::string& where) {
  constexpr int kLeast = 16;
  constexpr int kMost = 8192;
  if (std::min(width, height) < kLeast || std::max(width, height) > kMost) {
    throw_input_error("{}: {} x {} is no picture; width and height are from {} to {}", where, width, height,
                      kLeast, kMost);
  }
  camera.width = width;
  camera.height = height;
}

void read_intrinsics(ConfigSection& section, const std::string& key, PinholeCamera& camera) {
  const std::vector<double> intrinsics = read_numbers(section, key, 4);
  camera.fx = intrinsics[0];
  camera.fy = intrinsics[1];
  camera.cx = intrinsics[2];
  camera.cy = intrinsics[3];
  if (!(camera.fx > 0.0 && camera.fy > 0.0)) {
    throw_input_error("{}: focal lengths must be positive", section.where(key));
  }
}

void read_lens(ConfigSection& section, const std::string& model, const std::string& coefficients,
               PinholeCamera& camera) {
  std::string name = "radial-tangential";
  section.read(model, name);
  if (name == "equidistant") {
    camera.lens = LensModel::kEquidistant;
  } else if (name != "radial-tangential" && name != "radtan" && name != "none") {
    throw_input_error("{}: '{}' is not radial-tangential, radtan, equidistant or none", section.where(model),
                      name);
  }
  if (!section.has(coefficients)) return;
  const std::size_t count = name == "none" ? 0 : camera.distortion.size();
  const std::vector<double> distortion = read_numbers(section, coefficients, count);
  std::copy(distortion.begin(), distortion.end(), camera.distortion.begin());
}

SE3 pose_from(const std::vector<double>& numbers, const std::string& where) {
  const Eigen::Matrix4d T = Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(numbers.data());
  const Eigen::Matrix3d R = T.topLeftCorner<3, 3>();
  if ((R.transpose() * R - Eigen::Matrix3d::Identity()).norm() > 1e-3 || R.determinant() < 0.0 ||
      T.row(3) != Eigen::RowVector4d(0, 0, 0, 1)) {
    throw_input_error("{}: not a rigid motion", where);
  }
  return SE3::from_matrix(T);
}

}  // namespace covey
