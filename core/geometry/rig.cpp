// SPDX-License-Identifier: BSD-3-Clause
#include "core/geometry/rig.h"

#include <limits>
#include <vector>

#include "core/base/config.h"
#include "core/geometry/calibration_files.h"
#include "core/geometry/camera_fields.h"

namespace covey {
namespace {

void read_imu(ConfigSection& section, ImuNoise& imu) {
  section.read("rate_hz", imu.rate_hz, 10.0, 10'000.0);
  section.read("gyro_noise", imu.gyro_noise, 1e-8, 1.0);
  section.read("gyro_walk", imu.gyro_walk, 1e-9, 1.0);
  section.read("accel_noise", imu.accel_noise, 1e-8, 10.0);
  section.read("accel_walk", imu.accel_walk, 1e-9, 10.0);
  section.read("gyro_range", imu.gyro_range, 0.1, std::numeric_limits<double>::infinity());
  section.read("accel_range", imu.accel_range, 1.0, std::numeric_limits<double>::infinity());
}

MountedCamera read_camera(ConfigSection& section) {
  MountedCamera mounted;
  int width = 0;
  int height = 0;
  section.read("width", width);
  section.read("height", height);
  set_size(mounted.camera, width, height, section.where("width"));
  read_intrinsics(section, "intrinsics", mounted.camera);
  read_lens(section, "distortion_model", "distortion", mounted.camera);
  mounted.T_B_C = pose_from(read_numbers(section, "T_B_C", 16), section.where("T_B_C"));
  return mounted;
}

// One or two cameras and the IMU out of files of other tools, which are named relative to this one.
bool read_elsewhere(ConfigSection& root, const std::filesystem::path& folder, Rig& rig) {
  std::string kalibr;
  std::string euroc;
  root.read("kalibr", kalibr);
  root.read("euroc", euroc);
  if (!kalibr.empty()) {
    const std::vector<MountedCamera> cameras = read_kalibr_cameras(folder / kalibr);
    rig.left = cameras[0];
    if (cameras.size() > 1) rig.right = cameras[1];
  } else if (!euroc.empty()) {
    rig.left = read_euroc_camera(folder / euroc / "cam0/sensor.yaml");
    const std::filesystem::path right = folder / euroc / "cam1/sensor.yaml";
    if (std::filesystem::exists(right)) rig.right = read_euroc_camera(right);
    rig.imu = read_euroc_imu(folder / euroc / "imu0/sensor.yaml");
  }
  return !kalibr.empty() || !euroc.empty();
}

}  // namespace

Rig read_rig(const std::filesystem::path& file) {
  Config config = Config::load(file);
  ConfigSection& root = config.root();
  Rig rig;
  const bool elsewhere = read_elsewhere(root, file.parent_path(), rig);
  std::string kalibr_imu;
  root.read("kalibr_imu", kalibr_imu);
  if (!kalibr_imu.empty()) rig.imu = read_kalibr_imu(file.parent_path() / kalibr_imu);
  read_imu(root.section("imu"), rig.imu);
  if (!elsewhere) {
    if (!root.has("left")) throw_input_error("{}: a rig needs the camera 'left'", file.string());
    rig.left = read_camera(root.section("left"));
    if (root.has("right")) rig.right = read_camera(root.section("right"));
  }
  bool mono = false;
  root.read("mono", mono);
  if (mono) rig.right.reset();
  if (root.has("depth")) {
    ConfigSection& depth = root.section("depth");
    const MountedCamera mounted = read_camera(depth);
    rig.depth = DepthCamera{mounted.camera, mounted.T_B_C, 0.3, 10.0};
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
