// SPDX-License-Identifier: BSD-3-Clause
#include "core/geometry/calibration_files.h"

#include <cmath>
#include <optional>

#include "core/geometry/camera_fields.h"

namespace covey {
namespace {

constexpr double kLargestShiftS = 0.002;  // a tenth of a degree at 1 rad/s

// What says nothing to us may be there.
void ignore(ConfigSection& section, std::initializer_list<const char*> keys) {
  YAML::Node anything;
  for (const char* key : keys) section.read(key, anything);
}

void read_resolution(ConfigSection& section, PinholeCamera& camera) {
  const std::vector<double> size = read_numbers(section, "resolution", 2);
  set_size(camera, static_cast<int>(size[0]), static_cast<int>(size[1]), section.where("resolution"));
}

void check_pinhole(ConfigSection& section) {
  std::string model = "pinhole";
  section.read("camera_model", model);
  if (model != "pinhole")
    throw_input_error("{}: '{}' is not known; it must be pinhole", section.where("camera_model"), model);
}

// A matrix as a list of its rows; nothing where it is not there.
std::optional<SE3> read_rows(ConfigSection& section, const std::string& key) {
  if (!section.has(key)) return std::nullopt;
  std::vector<std::vector<double>> rows;
  section.read(key, rows);
  std::vector<double> numbers;
  for (const auto& row : rows) numbers.insert(numbers.end(), row.begin(), row.end());
  if (numbers.size() != 16) throw_input_error("{}: not 4 rows of 4 numbers", section.where(key));
  return pose_from(numbers, section.where(key));
}

void check_shift(ConfigSection& section) {
  double shift_s = 0.0;
  section.read("timeshift_cam_imu", shift_s);
  if (std::abs(shift_s) > kLargestShiftS) {
    throw_input_error("{}: {} s is too much; take it off the pictures' stamps first",
                      section.where("timeshift_cam_imu"), shift_s);
  }
}

ImuNoise read_densities(ConfigSection& root, const std::string& rate) {
  ImuNoise imu;
  root.read(rate, imu.rate_hz, 10.0, 10'000.0);
  root.read("gyroscope_noise_density", imu.gyro_noise, 1e-8, 1.0);
  root.read("gyroscope_random_walk", imu.gyro_walk, 1e-9, 1.0);
  root.read("accelerometer_noise_density", imu.accel_noise, 1e-8, 10.0);
  root.read("accelerometer_random_walk", imu.accel_walk, 1e-9, 10.0);
  return imu;
}

}  // namespace

std::vector<MountedCamera> read_kalibr_cameras(const std::filesystem::path& file) {
  Config config = Config::load(file);
  ConfigSection& root = config.root();
  std::vector<MountedCamera> cameras;
  for (std::string name = "cam0"; root.has(name); name = "cam" + std::to_string(cameras.size())) {
    ConfigSection& section = root.section(name);
    MountedCamera mounted;
    check_pinhole(section);
    read_resolution(section, mounted.camera);
    read_intrinsics(section, "intrinsics", mounted.camera);
    read_lens(section, "distortion_model", "distortion_coeffs", mounted.camera);
    check_shift(section);
    const auto T_C_B = read_rows(section, "T_cam_imu");
    const auto T_C_before = read_rows(section, "T_cn_cnm1");
    if (T_C_B) {
      mounted.T_B_C = T_C_B->inverse();
    } else if (T_C_before && !cameras.empty()) {
      mounted.T_B_C = cameras.back().T_B_C * T_C_before->inverse();
    } else {
      throw_input_error("{}: where the camera sits is needed", section.where("T_cam_imu"));
    }
    ignore(section, {"cam_overlaps", "rostopic"});
    cameras.push_back(mounted);
  }
  if (cameras.empty()) throw_input_error("{}: there is no camera 'cam0' in it", file.string());
  config.check_all_read();
  return cameras;
}

ImuNoise read_kalibr_imu(const std::filesystem::path& file) {
  Config config = Config::load(file);
  // imu.yaml as one writes it has the keys at its root, imu-*.yaml as Kalibr writes it under imu0.
  ConfigSection& root = config.root().has("imu0") ? config.root().section("imu0") : config.root();
  const ImuNoise imu = read_densities(root, "update_rate");
  ignore(root, {"rostopic", "T_i_b", "time_offset", "model"});
  config.check_all_read();
  return imu;
}

MountedCamera read_euroc_camera(const std::filesystem::path& file) {
  Config config = Config::load(file);
  ConfigSection& root = config.root();
  MountedCamera mounted;
  check_pinhole(root);
  read_resolution(root, mounted.camera);
  read_intrinsics(root, "intrinsics", mounted.camera);
  read_lens(root, "distortion_model", "distortion_coefficients", mounted.camera);
  ConfigSection& pose = root.section("T_BS");
  mounted.T_B_C = pose_from(read_numbers(pose, "data", 16), pose.where("data"));
  ignore(pose, {"cols", "rows"});
  ignore(root, {"sensor_type", "comment", "rate_hz"});
  config.check_all_read();
  return mounted;
}

ImuNoise read_euroc_imu(const std::filesystem::path& file) {
  Config config = Config::load(file);
  ConfigSection& root = config.root();
  const ImuNoise imu = read_densities(root, "rate_hz");
  ignore(root, {"sensor_type", "comment", "T_BS"});
  config.check_all_read();
  return imu;
}

}  // namespace covey
