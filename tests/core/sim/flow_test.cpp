// SPDX-License-Identifier: BSD-3-Clause
// Motion, IMU and cameras told against each other by what a tracker sees in the pictures.
#include <algorithm>
#include <catch2/catch.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

#include "core/geometry/alignment.h"
#include "core/imu/preintegration.h"
#include "core/sim/cameras.h"
#include "core/sim/drive.h"
#include "core/sim/imu.h"
#include "core/sim/routes.h"

namespace covey::sim {
namespace {

constexpr double kDegree = M_PI / 180.0;
const std::filesystem::path kSensors = std::filesystem::path(COVEY_SOURCE_DIR) / "configs/sensors";

struct Track {
  Eigen::Vector2d from;  // px
  Eigen::Vector2d to;
};

// Corners of the first picture that are found in the second and found back from there.
std::vector<Track> track(const stereo_t& first, const stereo_t& second) {
  const auto picture = [](const stereo_t& stereo) {
    return cv::Mat(stereo.height, stereo.width, CV_8UC1, const_cast<std::uint8_t*>(stereo.left.data()));
  };
  std::vector<cv::Point2f> corners;
  cv::goodFeaturesToTrack(picture(first), corners, 300, 0.02, 12.0);
  std::vector<cv::Point2f> found;
  std::vector<cv::Point2f> back;
  std::vector<unsigned char> forward_ok;
  std::vector<unsigned char> back_ok;
  std::vector<float> error;
  const cv::TermCriteria fine(cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 40, 0.003);
  cv::calcOpticalFlowPyrLK(picture(first), picture(second), corners, found, forward_ok, error, {21, 21}, 4,
                           fine);
  cv::calcOpticalFlowPyrLK(picture(second), picture(first), found, back, back_ok, error, {21, 21}, 4, fine);
  std::vector<Track> tracks;
  for (std::size_t k = 0; k < corners.size(); ++k) {
    if (forward_ok[k] == 0 || back_ok[k] == 0 || cv::norm(back[k] - corners[k]) > 0.2) continue;
    tracks.push_back({{corners[k].x, corners[k].y}, {found[k].x, found[k].y}});
  }
  return tracks;
}

Eigen::Vector3d bearing(const PinholeCamera& camera, const Eigen::Vector2d& pixel) {
  return camera.undistort(pixel).value().homogeneous().normalized();
}

// The rotation that takes the second picture's bearings to the first's, without the fifth that fits it worst.
SO3 rotation_of(const PinholeCamera& camera, const std::vector<Track>& tracks) {
  std::vector<Eigen::Vector3d> from;
  std::vector<Eigen::Vector3d> to;
  for (const Track& one : tracks) {
    to.push_back(bearing(camera, one.from));
    from.push_back(bearing(camera, one.to));
  }
  const SO3 rough = align_points(from, to).T_to_from.rotation;
  std::vector<std::size_t> order(from.size());
  for (std::size_t k = 0; k < order.size(); ++k) order[k] = k;
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return (rough * from[a] - to[a]).norm() < (rough * from[b] - to[b]).norm();
  });
  std::vector<Eigen::Vector3d> good_from;
  std::vector<Eigen::Vector3d> good_to;
  for (std::size_t k = 0; k < order.size() * 4 / 5; ++k) {
    good_from.push_back(from[order[k]]);
    good_to.push_back(to[order[k]]);
  }
  return align_points(good_from, good_to).T_to_from.rotation;
}

TEST_CASE("what the gyroscope integrates is what the pictures turn by") {
  const MeshWorld room = make_room({.seed = 1, .texture_side = 256});
  Rig rig = read_rig(kSensors / "euroc.yaml");
  rig.left.T_B_C.translation.setZero();  // turning only
  rig.depth.reset();
  SensorCameras cameras(room, rig, {.read_noise = 0.0, .shot_noise = 0.0});
  const SO3 R_W_C = SO3::from_matrix((Eigen::Matrix3d() << 0, 0, 1, -1, 0, 0, 0, -1, 0).finished());
  const SO3 R_W_B = R_W_C * rig.left.T_B_C.rotation.inverse();
  for (const Eigen::Vector3d& omega_B :
       {Eigen::Vector3d(0.5, 0, 0), Eigen::Vector3d(0, 0.5, 0), Eigen::Vector3d(0, 0, -0.5)}) {
    const Motion motion{0, 100'000, [&](Utime t) {
                          MotionState state;
                          state.T_W_B = {R_W_B * SO3::exp(to_seconds(t) * omega_B), {0.0, 0.5, 1.5}};
                          state.omega_B = omega_B;
                          return state;
                        }};
    const ImuNoise quiet{200.0, 0.0, 0.0, 0.0, 0.0};
    const ImuRecord imu = simulate_imu(motion, {quiet, 0.0, 0.0}, 1);
    const SO3 turned = Preintegration(quiet, {}, imu.samples).increment().dR;
    const auto tracks =
        track(cameras.stereo(motion.at(0).T_W_B, 0), cameras.stereo(motion.at(100'000).T_W_B, 100'000));
    REQUIRE(tracks.size() > 60);
    const SO3 R_B_C = rig.left.T_B_C.rotation;
    const SO3 seen = R_B_C * rotation_of(rig.left.camera, tracks) * R_B_C.inverse();
    CHECK((turned.inverse() * seen).log().norm() < 0.02 * kDegree);
  }
}

TEST_CASE("pictures, depth and motion of a drive fit each other") {
  const MeshWorld town = make_town({.seed = 1, .blocks = 2, .block_m = 14.0, .texture_side = 256});
  const Rig rig = read_rig(kSensors / "rover.yaml");
  SensorCameras cameras(town, rig, {.depth_noise_m = 0.0});
  const auto routes = choose_routes(town.roads, {.lengths_m = {driven_length({}, 30.0)}});
  const Motion motion = drive(routes[0], {}, 0, 30.0, 1);
  std::vector<double> errors;
  for (const Utime t : {8'000'000, 15'000'000, 22'000'000}) {
    const SE3 T_W_B = motion.at(t).T_W_B;
    const SE3 T_W_next = motion.at(t + 50'000).T_W_B;
    const depth_t depth = cameras.depth(T_W_B, t);
    const SE3 T_next_C = rig.left.T_B_C.inverse() * T_W_next.inverse() * T_W_B * rig.left.T_B_C;
    for (const Track& one : track(cameras.stereo(T_W_B, t), cameras.stereo(T_W_next, t + 50'000))) {
      // The depth camera stands where the left one does.
      const Eigen::Vector3d ray = rig.left.camera.undistort(one.from).value().homogeneous();
      const auto pixel = rig.depth->camera.project(ray);
      if (!pixel || !rig.depth->camera.contains(*pixel)) continue;
      const auto column = static_cast<int>(std::lround(pixel->x()));
      const auto row = static_cast<int>(std::lround(pixel->y()));
      const double z = 1e-3 * depth.depth_mm[static_cast<std::size_t>(row) * depth.width + column];
      if (z == 0.0) continue;
      const Eigen::Vector2d expected = rig.left.camera.project(T_next_C * Eigen::Vector3d(z * ray)).value();
      errors.push_back((one.to - expected).norm());
    }
  }
  REQUIRE(errors.size() > 150);
  std::sort(errors.begin(), errors.end());
  CHECK(errors[errors.size() / 2] < 0.15);
}

}  // namespace
}  // namespace covey::sim
