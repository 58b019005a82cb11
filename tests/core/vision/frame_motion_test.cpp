// SPDX-License-Identifier: BSD-3-Clause
#include "core/vision/frame_motion.h"

#include <catch2/catch.hpp>
#include <random>

using namespace covey;

namespace {

struct Scene {
  std::vector<TrackFlow> flows;
  std::vector<bool> good;
  SE3 T_cur_prev;
};

// 150 points 1 m to 10 m away seen with a fifth of a pixel of noise; a share of them moves elsewhere, every third has no depth.
Scene make_scene(double outliers, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  Scene scene;
  scene.T_cur_prev = {SO3::exp({0.02, -0.05, 0.03}), {0.05, -0.02, 0.04}};
  for (int i = 0; i < 150; ++i) {
    const Eigen::Vector2d from(0.7 * uniform(random), 0.5 * uniform(random));
    const double depth = 5.5 + 4.5 * uniform(random);
    const Eigen::Vector3d p = scene.T_cur_prev * (depth * from.homogeneous());
    const bool good = i >= outliers * 150;
    Eigen::Vector2d to = p.head<2>() / p.z() + 0.2 / 458.0 * Eigen::Vector2d(normal(random), normal(random));
    if (!good) {  // another body, which moves as a whole
      to += Eigen::Vector2d(0.03, -0.04);
    }
    TrackFlow flow{from, to, std::nullopt};
    if (i % 3 != 0) flow.inverse_depth = 1.0 / depth + 0.003 * normal(random);
    scene.flows.push_back(flow);
    scene.good.push_back(good);
  }
  return scene;
}

}  // namespace

TEST_CASE("the camera's motion is found among tracks that move otherwise, from a gyroscope with a bias") {
  for (const double outliers : {0.0, 0.1, 0.3}) {
    const Scene scene = make_scene(outliers, 7);
    const SO3 predicted = scene.T_cur_prev.rotation * SO3::exp({0.004, -0.003, 0.002});
    const auto motion = estimate_frame_motion(scene.flows, predicted, {});
    REQUIRE(motion);
    CHECK((motion->T_cur_prev.rotation.inverse() * scene.T_cur_prev.rotation).log().norm() < 5e-4);
    CHECK((motion->T_cur_prev.translation - scene.T_cur_prev.translation).norm() < 3e-3);
    int lost = 0;
    int kept = 0;
    for (std::size_t i = 0; i < scene.flows.size(); ++i) {
      lost += scene.good[i] && !motion->inliers[i] ? 1 : 0;
      kept += !scene.good[i] && motion->inliers[i] ? 1 : 0;
    }
    CHECK(lost <= 2);
    CHECK(kept <= 2);
  }
}

TEST_CASE("too few tracks with depth, or none that agree, say nothing about the motion") {
  Scene scene = make_scene(0.0, 3);
  for (std::size_t i = 0; i < scene.flows.size(); ++i) {
    if (i > 9) scene.flows[i].inverse_depth.reset();
  }
  CHECK_FALSE(estimate_frame_motion(scene.flows, scene.T_cur_prev.rotation, {}));
  CHECK_FALSE(estimate_frame_motion({}, SO3(), {}));

  std::mt19937 random(1);
  std::uniform_real_distribution<double> uniform(-0.5, 0.5);
  scene = make_scene(0.0, 3);
  for (TrackFlow& flow : scene.flows) flow.to = {uniform(random), uniform(random)};
  CHECK_FALSE(estimate_frame_motion(scene.flows, scene.T_cur_prev.rotation, {}));
}
