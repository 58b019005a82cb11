// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <array>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <utility>

#include "core/base/error.h"
#include "procs/sim/sink.h"
#include "procs/sim/truth_files.h"

namespace covey {
namespace {

std::ofstream open(const std::filesystem::path& file) {
  std::filesystem::create_directories(file.parent_path());
  std::ofstream stream(file, std::ios::binary);
  if (!stream) throw_input_error("{}: cannot be written", file.string());
  return stream;
}

void write_text(const std::filesystem::path& file, const std::string& text) {
  std::ofstream stream = open(file);
  stream << text;
  if (!stream.flush()) throw_input_error("{}: the disk refused it", file.string());
}

std::string sensor_head(const std::string& type, const std::string& comment, const SE3& T_B_S) {
  const Eigen::Matrix4d T = T_B_S.matrix();
  std::string rows;
  for (int row = 0; row < 4; ++row) {
    rows += fmt::format("{}{:.12g}, {:.12g}, {:.12g}, {:.12g}", row == 0 ? "[" : ",\n         ", T(row, 0),
                        T(row, 1), T(row, 2), T(row, 3));
  }
  return fmt::format(
      "%YAML:1.0\n\nsensor_type: {}\ncomment: {}\n\n"
      "# Extrinsics with respect to the body-frame.\nT_BS:\n  cols: 4\n  rows: 4\n  data: {}]\n\n",
      type, comment, rows);
}

std::string camera_yaml(const MountedCamera& mounted, const std::string& name) {
  const PinholeCamera& camera = mounted.camera;
  const auto& d = camera.distortion;
  return sensor_head("camera", "simulated " + name, mounted.T_B_C) +
         fmt::format(
             "rate_hz: {}\nresolution: [{}, {}]\ncamera_model: pinhole\n"
             "intrinsics: [{:.12g}, {:.12g}, {:.12g}, {:.12g}]\ndistortion_model: {}\n"
             "distortion_coefficients: [{:.12g}, {:.12g}, {:.12g}, {:.12g}]\n",
             sim::kStereoHz, camera.width, camera.height, camera.fx, camera.fy, camera.cx, camera.cy,
             camera.lens == LensModel::kEquidistant ? "equidistant" : "radial-tangential", d[0], d[1], d[2],
             d[3]);
}

std::string imu_yaml(const ImuNoise& noise) {
  return sensor_head("imu", "IMU", {}) +
         fmt::format(
             "rate_hz: {}\ngyroscope_noise_density: {:.6e}\ngyroscope_random_walk: {:.6e}\n"
             "accelerometer_noise_density: {:.6e}\naccelerometer_random_walk: {:.6e}\n",
             noise.rate_hz, noise.gyro_noise, noise.gyro_walk, noise.accel_noise, noise.accel_walk);
}

class AslSink : public SensorSink {
 public:
  AslSink(const std::filesystem::path& folder, const Rig& rig, const sim::Ride& ride)
      : final_(folder / "mav0"), part_(folder / "mav0.part"), has_right_(rig.right.has_value()) {
    if (std::filesystem::exists(final_))
      throw_input_error("{}: exists already; remove it first", final_.string());
    std::filesystem::remove_all(part_);
    write_text(part_ / "body.yaml", "%YAML:1.0\ncomment: simulated\n");
    write_text(part_ / "imu0/sensor.yaml", imu_yaml(rig.imu));
    imu_ = open(part_ / "imu0/data.csv");
    imu_ << "#timestamp [ns],w_RS_S_x [rad s^-1],w_RS_S_y [rad s^-1],w_RS_S_z [rad s^-1],a_RS_S_x [m s^-2],"
            "a_RS_S_y [m s^-2],a_RS_S_z [m s^-2]\n";
    write_text(part_ / "state_groundtruth_estimate0/sensor.yaml",
               sensor_head("visual-inertial", "the true motion of the IMU", {}));
    write_text(part_ / "state_groundtruth_estimate0/data.csv", format_states(ride));
    start_camera(0, rig.left);
    if (has_right_) start_camera(1, *rig.right);
  }
  ~AslSink() override {
    std::error_code ignored;
    std::filesystem::remove_all(part_, ignored);
  }

  bool wants_depth() const override { return false; }
  void write(const imu_t& imu) override {
    imu_ << fmt::format("{},{:.17g},{:.17g},{:.17g},{:.17g},{:.17g},{:.17g}\n", imu.utime * 1000, imu.gyro[0],
                        imu.gyro[1], imu.gyro[2], imu.accel[0], imu.accel[1], imu.accel[2]);
  }
  void write(const stereo_t& stereo) override {
    write_image(0, stereo, stereo.left);
    if (has_right_) write_image(1, stereo, stereo.right);
  }
  void write(const depth_t&) override {}
  void finish() override {
    for (std::ofstream* stream : {&imu_, &cameras_[0], &cameras_[1]}) {
      if (stream->is_open() && !stream->flush()) throw_input_error("{}: the disk refused it", part_.string());
    }
    std::filesystem::rename(part_, final_);
  }

 private:
  std::filesystem::path camera_folder(int camera) const { return part_ / fmt::format("cam{}", camera); }

  void start_camera(int number, const MountedCamera& mounted) {
    const std::filesystem::path folder = camera_folder(number);
    std::filesystem::create_directories(folder / "data");
    write_text(folder / "sensor.yaml", camera_yaml(mounted, fmt::format("cam{}", number)));
    cameras_[number] = open(folder / "data.csv");
    cameras_[number] << "#timestamp [ns],filename\n";
  }

  void write_image(int camera, const stereo_t& stereo, const std::vector<std::uint8_t>& grey) {
    const std::string name = fmt::format("{}.png", stereo.utime * 1000);
    const cv::Mat image(stereo.height, stereo.width, CV_8UC1, const_cast<std::uint8_t*>(grey.data()));
    const std::string file = (camera_folder(camera) / "data" / name).string();
    // Noise does not compress: the quickest level is as small as the best.
    if (!cv::imwrite(file, image, {cv::IMWRITE_PNG_COMPRESSION, 1}))
      throw_input_error("{}: cannot be written", file);
    cameras_[camera] << fmt::format("{},{}\n", stereo.utime * 1000, name);
  }

  std::filesystem::path final_;
  std::filesystem::path part_;
  bool has_right_;
  std::ofstream imu_;
  std::array<std::ofstream, 2> cameras_;
};

}  // namespace

std::unique_ptr<SensorSink> make_asl_sink(const std::filesystem::path& folder, const Rig& rig,
                                          const sim::Ride& ride) {
  return std::make_unique<AslSink>(folder, rig, ride);
}

}  // namespace covey
