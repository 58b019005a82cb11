// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/measured_noise.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "core/geometry/alignment.h"
#include "core/pgo/start.h"
#include "core/sim/grid.h"

namespace covey::pgo {
namespace {

constexpr double kDegree = 0.017453292519943295;

struct World {
  PoseGraph graph;  // kappa and tau from the covariances with their floor
  MeasuredNoise noise;
  Poses truth;
  std::vector<bool> right;  // per edge
};

// Sigmas as a visual-inertial front end and stereo verification have them: odometry is best in roll and pitch, which gravity
// shows, and drifts in yaw and along the way; a closure is worst in depth, along the first camera's axis.
Vector6d odometry_sigmas() {
  Vector6d sigmas;
  sigmas << 0.03, 0.008, 0.008, 0.03 * kDegree, 0.03 * kDegree, 0.3 * kDegree;
  return sigmas;
}
Vector6d closure_sigmas() {
  Vector6d sigmas;
  sigmas << 0.2, 0.04, 0.04, 0.4 * kDegree, 0.4 * kDegree, 0.8 * kDegree;
  return sigmas;
}

// The drives and the closures of the world `grid`, measured anew with noise of those covariances.
World make_world(std::uint64_t seed, int keyframes = 120) {
  const sim::GridWorld grid = sim::make_grid({.robots = 3, .keyframes = keyframes, .seed = seed});
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  const auto draw = [&](const Vector6d& sigmas) {
    return SE3::exp(sigmas.cwiseProduct(Vector6d::NullaryExpr([&] { return normal(random); })));
  };
  World world{grid.graph, {}, {}, grid.right};
  for (const Trajectory& robot : grid.truth) {
    for (const StampedPose& pose : robot) world.truth.push_back(pose.pose);
  }
  const std::vector<int> offsets = world.graph.offsets();
  for (std::size_t e = 0; e < world.graph.edges.size(); ++e) {
    Edge& edge = world.graph.edges[e];
    const bool odometry = edge.kind == EdgeKind::kOdometry;
    const Vector6d sigmas = odometry ? odometry_sigmas() : closure_sigmas();
    const Matrix6d covariance = sigmas.cwiseAbs2().asDiagonal();
    if (grid.right[e]) {
      const SE3& T_from = world.truth[offsets[edge.from.robot] + edge.from.index];
      const SE3& T_to = world.truth[offsets[edge.to.robot] + edge.to.index];
      edge.measurement = T_from.inverse() * T_to * draw(sigmas);
    }
    edge.known_inlier = odometry;
    world.noise.covariances.push_back(covariance);
    const Precision precision = precision_of(deciding_covariance(covariance, {}));
    edge.kappa = precision.kappa;
    edge.tau = precision.tau;
  }
  for (const SE3& T_W_K : world.truth) {
    const Eigen::Vector3d tilt =
        0.2 * kDegree * Eigen::Vector3d(normal(random), normal(random), normal(random));
    const Eigen::Vector3d down_K = T_W_K.rotation.inverse() * Eigen::Vector3d(0.0, 0.0, -1.0);
    world.noise.gravity.push_back({SO3::exp(tilt) * down_K, 0.2 * kDegree});
  }
  return world;
}

double ate(const World& world, const Poses& poses) {
  std::vector<Eigen::Vector3d> estimate;
  std::vector<Eigen::Vector3d> truth;
  for (const SE3& T : poses) estimate.push_back(T.translation);
  for (const SE3& T : world.truth) truth.push_back(T.translation);
  return align_points(estimate, truth).rms;
}

int wrong_decisions(const World& world, const std::vector<double>& weights) {
  int wrong = 0;
  for (std::size_t e = 0; e < weights.size(); ++e) wrong += (weights[e] == 1.0) != world.right[e] ? 1 : 0;
  return wrong;
}

MeasuredNoise without_gravity(MeasuredNoise noise) {
  for (Gravity& gravity : noise.gravity) gravity.sigma = 0.0;
  return noise;
}

TEST_CASE("full covariances and gravity give better poses than one kappa and tau for each edge") {
  double isotropic = 0.0;
  double floored = 0.0;
  double full = 0.0;
  double with_gravity = 0.0;
  int wrong_isotropic = 0;
  int wrong_full = 0;
  for (const std::uint64_t seed : {1, 2, 3, 4, 5, 6}) {
    const World world = make_world(seed);
    const Poses start = robust_start(world.graph, {.min_inliers = 1}).poses;
    const CentralResult one = solve_robust(world.graph, start, {.barc2 = 16.812});
    const MeasuredResult two = solve_measured(world.graph, without_gravity(world.noise), start, {});
    const MeasuredResult three = solve_measured(world.graph, world.noise, start, {});
    const MeasuredResult deciding =
        solve_measured(world.graph, without_gravity(world.noise), start, {.odometry_floor = 1.0});
    floored += ate(world, deciding.central.poses) / 6.0;
    isotropic += ate(world, one.poses) / 6.0;
    full += ate(world, two.central.poses) / 6.0;
    with_gravity += ate(world, three.central.poses) / 6.0;
    wrong_isotropic += wrong_decisions(world, one.weights);
    wrong_full += wrong_decisions(world, three.central.weights);
    REQUIRE(three.central.converged);
  }
  CAPTURE(isotropic, floored, full, with_gravity, wrong_isotropic, wrong_full);
  REQUIRE(floored < isotropic);
  REQUIRE(full < 0.9 * isotropic);
  REQUIRE(with_gravity < full);
  REQUIRE(wrong_full <= wrong_isotropic);
}

TEST_CASE("covariances that are too sure of themselves reject right closures unless they have a floor") {
  World world = make_world(1);
  for (Matrix6d& covariance : world.noise.covariances) covariance /= 100.0;
  const Poses start = robust_start(world.graph, {.min_inliers = 1}).poses;
  const int sure = wrong_decisions(
      world, solve_measured(world.graph, world.noise, start, {.noise = {.floor_translation_sigma = 0.0}})
                 .central.weights);
  const int floored =
      wrong_decisions(world, solve_measured(world.graph, world.noise, start, {}).central.weights);
  CAPTURE(sure, floored);
  REQUIRE(floored < sure / 2);
}

TEST_CASE("gravity turns the whole upright and leaves place and yaw of the gauge") {
  const World world = make_world(2, 60);
  Poses start = robust_start(world.graph, {.min_inliers = 1}).poses;
  const SE3 tilted{SO3::exp({0.05, -0.04, 0.3}), {5.0, 3.0, 1.0}};
  for (SE3& T : start) T = tilted * T;
  MeasuredNoise noise = world.noise;
  // The gauge's own direction says how W lies, so it is told wrong by 3 degrees: all others together know better.
  noise.gravity[0].down_K = start[0].rotation.inverse() * Eigen::Vector3d(0.0, 0.0, -1.0);
  const MeasuredResult result = solve_measured(world.graph, noise, start, {});
  REQUIRE((result.central.poses[0].translation - start[0].translation).norm() < 1e-3);
  double off = 0.0;
  for (std::size_t k = 0; k < world.truth.size(); ++k) {
    const Eigen::Vector3d down_K = world.truth[k].rotation.inverse() * Eigen::Vector3d(0.0, 0.0, -1.0);
    const double cosine = -(result.central.poses[k].rotation * down_K).z();
    off = std::max(off, std::acos(std::min(1.0, cosine)));
  }
  REQUIRE(off < 0.5 * kDegree);
  const Eigen::Vector3d turned = (start[0].rotation.inverse() * result.central.poses[0].rotation).log();
  REQUIRE(std::abs(turned.dot(noise.gravity[0].down_K)) < 1e-3);
}

}  // namespace
}  // namespace covey::pgo
