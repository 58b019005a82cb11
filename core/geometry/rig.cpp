// SPDX-License-Identifier: BSD-3-Clause
#include "core/geometry/rig.h"

#include <Eigen/Geometry>
#include <vector>

#include "core/base/config.h"

namespace covey {
namespace {

ImuNoise read_imu(ConfigSection& section) {
  ImuNoise imu;
  section.read("rate_hz", imu.rate_hz, 10.0, 10'000.0);
  section.read("gyro_noise", imu.gyro_noise, 1e-8, 1.0);
  section.read("gyro_walk", imu.gyro_walk, 1e-9, 1.0);
  section.read("accel_noise", imu.accel_noise, 1e-8, 10.0);
  section.read("accel_walk", imu.accel_walk, 1e-9, 10.0);
  return imu;
}

std::vector<double> read_numbers(ConfigSection& section, const std::string& key, std::size_t count) {
  std::vector<double> numbers;
  section.read(key, numbers);
  if (numbers.size() != count) {
    throw_input_error("{}: {} numbers are needed, there are {}", section.where(key), count, numbers.size());
  }
  return numbers;
}

PinholeCamera read_camera(ConfigSection& section) {
  PinholeCamera camera;
  section.read("width", camera.width, 16, 8192);
  section.read("height", camera.height, 16, 8192);
  if (camera.width == 0 || camera.height == 0) {
    throw_input_error("{}: width and height are needed", section.where("width"));
  }
  const std::vector<double> intrinsics = read_numbers(section, "intrinsics", 4);
  camera.fx = intrinsics[0];
  camera.fy = intrinsics[1];
  camera.cx = intrinsics[2];
  camera.cy = intrinsics[3];
  if (!(camera.fx > 0.0 && camera.fy > 0.0)) {
    throw_input_error("{}: focal lengths must be positive", section.where("intrinsics"));
  }
  if (section.has("distortion")) {
    const std::vector<double> distortion = read_numbers(section, "distortion", 4);
    std::copy(distortion.begin(), distortion.end(), camera.distortion.begin());
  }
  return camera;
}

SE3 read_pose(ConfigSection& section, const std::string& key) {
  const std::vector<double> numbers = read_numbers(section, key, 16);
  const Eigen::Matrix4d T = Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(numbers.data());
  const Eigen::Matrix3d R = T.topLeftCorner<3, 3>();
  // Calibrations are written with a few digits: to the nearest rotation, if one is near.
  if ((R.transpose() * R - Eigen::Matrix3d::Identity()).norm() > 1e-3 || R.determinant() < 0.0 ||
      T.row(3) != Eigen::RowVector4d(0, 0, 0, 1)) {
    throw_input_error("{}: not a rigid motion", section.where(key));
  }
  return SE3::from_matrix(T);
}

}  // namespace

Rig read_rig(const std::filesystem::path& file) {
  Config config = Config::load(file);
  ConfigSection& root = config.root();
  Rig rig;
  rig.imu = read_imu(root.section("imu"));
  if (!root.has("left")) throw_input_error("{}: a rig needs the camera 'left'", file.string());
  ConfigSection& left = root.section("left");
  rig.left = {read_camera(left), read_pose(left, "T_B_C")};
  if (root.has("right")) {
    ConfigSection& right = root.section("right");
    rig.right = MountedCamera{read_camera(right), read_pose(right, "T_B_C")};
  }
  if (root.has("depth")) {
    ConfigSection& depth = root.section("depth");
    rig.depth = DepthCamera{read_camera(depth), read_pose(depth, "T_B_C"), 0.3, 10.0};
    depth.read("near_m", rig.depth->near_m, 0.01, 100.0);
    depth.read("far_m", rig.depth->far_m, 0.1, 32.0);
    if (rig.depth->camera.is_distorted()) {
      throw_input_error("{}: depth images must come without distortion", depth.where("distortion"));
    }
  }
  config.check_all_read();
  return rig;
}

}  // namespace covey
