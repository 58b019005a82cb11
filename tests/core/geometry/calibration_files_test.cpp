// SPDX-License-Identifier: BSD-3-Clause
#include "core/geometry/calibration_files.h"

#include <unistd.h>

#include <catch2/catch.hpp>
#include <fstream>

#include "core/base/error.h"

namespace covey {
namespace {

using Catch::Matchers::Contains;

// A folder that lives as long as the test.
struct Folder {
  Folder()
      : path(std::filesystem::temp_directory_path() / ("covey_calibration_" + std::to_string(getpid()))) {
    std::filesystem::create_directories(path);
  }
  ~Folder() { std::filesystem::remove_all(path); }
  std::filesystem::path write(const std::string& name, const std::string& text) const {
    std::filesystem::create_directories((path / name).parent_path());
    std::ofstream(path / name) << text;
    return path / name;
  }
  std::filesystem::path path;
};

// As Kalibr writes it. The second camera is 0.1 m to the right of the first, which looks along body x.
const std::string kChain = R"(cam0:
  T_cam_imu:
  - [0.0, -1.0, 0.0, 0.02]
  - [0.0, 0.0, -1.0, 0.0]
  - [1.0, 0.0, 0.0, -0.05]
  - [0.0, 0.0, 0.0, 1.0]
  cam_overlaps: [1]
  camera_model: pinhole
  distortion_coeffs: [0.0035, 0.0007, -0.002, 0.0002]
  distortion_model: equidistant
  intrinsics: [190.9, 190.8, 254.9, 256.9]
  resolution: [512, 510]
  rostopic: /cam0/image_raw
  timeshift_cam_imu: 0.0001
cam1:
  T_cn_cnm1:
  - [1.0, 0.0, 0.0, -0.1]
  - [0.0, 1.0, 0.0, 0.0]
  - [0.0, 0.0, 1.0, 0.0]
  - [0.0, 0.0, 0.0, 1.0]
  cam_overlaps: [0]
  camera_model: pinhole
  distortion_coeffs: [-0.28, 0.07, 0.0002, 0.00002]
  distortion_model: radtan
  intrinsics: [190.4, 190.4, 252.6, 254.9]
  resolution: [512, 510]
  rostopic: /cam1/image_raw
)";

std::string changed(std::string text, const std::string& from, const std::string& to) {
  return text.replace(text.find(from), from.size(), to);
}

TEST_CASE("Kalibr's chain of cameras and its IMU make a rig") {
  const Folder folder;
  folder.write("camchain.yaml", kChain);
  folder.write("imu.yaml",
               "imu0:\n  T_i_b: [[1, 0, 0, 0]]\n  rostopic: /imu0\n  update_rate: 400.0\n"
               "  gyroscope_noise_density: 0.0002\n  gyroscope_random_walk: 4.0e-06\n"
               "  accelerometer_noise_density: 0.003\n  accelerometer_random_walk: 0.0004\n");
  const Rig rig = read_rig(
      folder.write("rig.yaml", "kalibr: camchain.yaml\nkalibr_imu: imu.yaml\nimu: {gyro_range: 17.4}\n"));
  CHECK(rig.left.camera.lens == LensModel::kEquidistant);
  CHECK(rig.left.camera.width == 512);
  CHECK(rig.left.camera.height == 510);
  CHECK(rig.left.camera.fy == 190.8);
  CHECK(rig.left.camera.distortion[3] == 0.0002);
  const Eigen::Vector3d left = rig.left.T_B_C.translation;
  CHECK((left - Eigen::Vector3d(0.05, 0.02, 0.0)).norm() < 1e-12);
  CHECK((rig.left.T_B_C.rotation * Eigen::Vector3d::UnitZ() - Eigen::Vector3d::UnitX()).norm() < 1e-12);
  REQUIRE(rig.right);
  CHECK(rig.right->camera.lens == LensModel::kRadialTangential);
  const SE3 T_L_R = rig.left.T_B_C.inverse() * rig.right->T_B_C;
  CHECK((T_L_R.translation - Eigen::Vector3d(0.1, 0.0, 0.0)).norm() < 1e-12);
  CHECK(rig.imu.rate_hz == 400.0);
  CHECK(rig.imu.accel_walk == 0.0004);
  CHECK(rig.imu.gyro_range == 17.4);
}

TEST_CASE("A rig is read from EuRoC's folder, and may be told to do without its right camera") {
  const Folder folder;
  const std::string camera =
      "%YAML:1.0\n\nsensor_type: camera\ncomment: cam\nT_BS:\n  cols: 4\n  rows: 4\n"
      "  data: [0, 0, 1, 0.1, -1, 0, 0, 0.2, 0, -1, 0, 0, 0, 0, 0, 1]\nrate_hz: 20\nresolution: [752, 480]\n"
      "camera_model: pinhole\nintrinsics: [458.6, 457.2, 367.2, 248.3]\n"
      "distortion_model: radial-tangential\ndistortion_coefficients: [-0.28, 0.07, 0.0002, 0.00001]\n";
  for (const char* name : {"mav0/cam0/sensor.yaml", "mav0/cam1/sensor.yaml"}) folder.write(name, camera);
  folder.write(
      "mav0/imu0/sensor.yaml",
      "%YAML:1.0\nsensor_type: imu\ncomment: IMU\nT_BS: {cols: 4, rows: 4, data: [1]}\nrate_hz: 200\n"
      "gyroscope_noise_density: 1.7e-04\ngyroscope_random_walk: 1.9e-05\n"
      "accelerometer_noise_density: 2.0e-3\naccelerometer_random_walk: 3.0e-3\n");
  const Rig rig = read_rig(folder.write("rig.yaml", "euroc: mav0\n"));
  CHECK(rig.left.camera.fx == 458.6);
  CHECK(rig.left.T_B_C.translation.y() == 0.2);
  CHECK(rig.imu.gyro_noise == 1.7e-4);
  CHECK(rig.right);
  CHECK_FALSE(read_rig(folder.write("rig.yaml", "euroc: mav0\nmono: true\n")).right);
}

TEST_CASE("What is wrong in a chain of cameras is named") {
  const Folder folder;
  const auto refuses = [&](const std::string& text, const std::string& word) {
    CHECK_THROWS_WITH(read_kalibr_cameras(folder.write("chain.yaml", text)), Contains(word));
  };
  refuses("imu0: {}\n", "cam0");
  refuses(changed(kChain, "pinhole", "omni"), "camera_model");
  refuses(changed(kChain, "equidistant", "fov"), "distortion_model");
  refuses(changed(kChain, "[512, 510]", "[512]"), "resolution");
  refuses(changed(kChain, "0.0001", "0.03"), "timeshift_cam_imu");
  refuses(changed(kChain, "T_cn_cnm1", "T_cn"), "T_cam_imu");
  refuses(changed(kChain, "[0.0, -1.0, 0.0, 0.02]", "[0.0, -2.0, 0.0, 0.02]"), "rigid");
}

}  // namespace
}  // namespace covey
