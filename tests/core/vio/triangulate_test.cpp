// SPDX-License-Identifier: BSD-3-Clause
#include "core/vio/triangulate.h"

#include <catch2/catch.hpp>

#include "tests/core/vio/tracks.h"

using namespace covey;
using namespace covey::vio;
using covey::testing::RandomGeometry;
using covey::testing::stereo_rig;

namespace {

constexpr double kSigma = 1.0 / 458.0;

std::optional<Eigen::Vector2d> project(const MountedCamera& camera, const SE3& T_O_B,
                                       const Eigen::Vector3d& p_O) {
  const Eigen::Vector3d p_C = (T_O_B * camera.T_B_C).inverse() * p_O;
  if (p_C.z() < 0.1) return std::nullopt;
  return Eigen::Vector2d(p_C.head<2>() / p_C.z());
}

TrackObservation see(const Rig& rig, const SE3& T_O_B, const Eigen::Vector3d& p_O, bool right) {
  TrackObservation seen{7, *project(rig.left, T_O_B, p_O), std::nullopt, kSigma};
  if (right) seen.right = project(*rig.right, T_O_B, p_O);
  return seen;
}

Eigen::Vector3d position(const Landmark& landmark) {
  return landmark.T_O_A * (Eigen::Vector3d(landmark.l.x(), landmark.l.y(), 1.0) / landmark.l.z());
}

}  // namespace

TEST_CASE("triangulate: one stereo view, or two single views far enough apart, give the point") {
  RandomGeometry random;
  const Rig rig = stereo_rig();
  const StereoRig stereo(rig);
  for (int trial = 0; trial < 100; ++trial) {
    const SE3 T_O_B = random.pose();
    const SE3 T_O_B2 = T_O_B * SE3{SO3::exp(random.vector<3>(0.05)), {0.0, 0.4, 0.1}};
    const Eigen::Vector3d p_O =
        T_O_B * rig.left.T_B_C * Eigen::Vector3d(random.uniform(-1, 1), random.uniform(-1, 1), 4.0);
    const TrackObservation both = see(rig, T_O_B, p_O, true);
    const View one[] = {{T_O_B, &both}};
    const auto from_one = triangulate(stereo, one, 4.0);
    REQUIRE(from_one);
    REQUIRE((position(*from_one) - p_O).norm() < 1e-6);
    const TrackObservation first = see(rig, T_O_B, p_O, false);
    const TrackObservation second = see(rig, T_O_B2, p_O, false);
    const View two[] = {{T_O_B, &first}, {T_O_B2, &second}};
    const auto from_two = triangulate(stereo, two, 4.0);
    REQUIRE(from_two);
    REQUIRE((position(*from_two) - p_O).norm() < 1e-6);
    REQUIRE((from_two->T_O_A.translation - (T_O_B2 * rig.left.T_B_C).translation).norm() < 1e-9);
  }
}

TEST_CASE("triangulate: far points are landmarks, unknown depth, bad matches and points behind are not") {
  const Rig rig = stereo_rig();
  const StereoRig stereo(rig);
  const SE3 T_O_B;
  const Eigen::Vector3d far = rig.left.T_B_C * Eigen::Vector3d(100.0, 20.0, 5000.0);
  const TrackObservation far_seen = see(rig, T_O_B, far, true);
  const View far_view[] = {{T_O_B, &far_seen}};
  const auto landmark = triangulate(stereo, far_view, 4.0);
  REQUIRE(landmark);
  REQUIRE(landmark->l.z() == Approx(1.0 / 5000.0).margin(1e-6));

  const TrackObservation alone = see(rig, T_O_B, far, false);
  const View alone_view[] = {{T_O_B, &alone}, {T_O_B, &alone}};
  REQUIRE_FALSE(triangulate(stereo, alone_view, 4.0));

  const Eigen::Vector3d near = rig.left.T_B_C * Eigen::Vector3d(0.2, 0.1, 3.0);
  TrackObservation across = see(rig, T_O_B, near, true);
  across.right->y() += 20.0 * kSigma;  // off the epipolar line
  const View across_view[] = {{T_O_B, &across}};
  REQUIRE_FALSE(triangulate(stereo, across_view, 4.0));

  TrackObservation crossed = see(rig, T_O_B, near, true);
  crossed.right->x() = crossed.left.x() + 0.2;  // negative disparity
  const View crossed_view[] = {{T_O_B, &crossed}};
  REQUIRE_FALSE(triangulate(stereo, crossed_view, 100.0));
}
