// SPDX-License-Identifier: BSD-3-Clause
#include "core/vio/window.h"

#include <catch2/catch.hpp>

#include "tests/core/vio/tracks.h"

using namespace covey;
using namespace covey::vio;
using covey::testing::add_imu_errors;
using covey::testing::AnalyticMotion;
using covey::testing::RandomGeometry;
using covey::testing::sample_imu;
using covey::testing::stereo_rig;
using covey::testing::TrackSim;
using covey::testing::TrackSimOptions;

namespace {

constexpr Utime kKeyframeSpacing = 200'000;

// Keyframes from the truth, disturbed; the window holds all that options.window lets it.
struct World {
  Rig rig = stereo_rig();
  AnalyticMotion motion;
  RandomGeometry random{9};
  TrackSim sim;
  std::vector<ImuSample> imu;
  Utime now = 0;

  explicit World(const TrackSimOptions& options = {}) : sim(rig, options) {
    imu = sample_imu(motion, 0, 40 * kKeyframeSpacing, 5000);
    add_imu_errors(rig.imu, {}, random, imu);
  }
  NavState guess() {
    NavState state = motion.state(now);
    Vector6d xi;
    xi << random.vector<3>(0.005), random.vector<3>(0.001);
    state.T_W_B = state.T_W_B * SE3::exp(xi);
    state.v_W += random.vector<3>(0.05);
    return state;
  }
  void begin(Window& window) { window.begin(sim.see(now, motion.state(now).T_W_B), motion.state(now), {}); }
  void add(Window& window) {
    const auto first = static_cast<std::size_t>(now / 5000);
    now += kKeyframeSpacing;
    window.add(sim.see(now, motion.state(now).T_W_B), guess(),
               {imu.begin() + first, imu.begin() + first + 41});
  }
  double error_m(const Window& window) const {
    return (window.newest_state().T_W_B.translation - motion.state(window.newest_utime()).T_W_B.translation)
        .norm();
  }
};

// What the linear prior knows of moving the whole window at once: J N, N's columns a metre along x, y and z and a radian about the vertical through the newest
// keyframe, at the points where the prior is linear.
Eigen::MatrixXd knowledge_of_gauge(const Window& window) {
  const graph::Graph& graph = window.graph();
  for (const graph::FactorId id : graph.ids()) {
    const auto* prior = dynamic_cast<const graph::LinearPrior*>(&graph.factor(id));
    if (!prior) continue;
    const Eigen::Vector3d pivot = window.newest_state().T_W_B.translation;
    Eigen::MatrixXd N = Eigen::MatrixXd::Zero(prior->jacobian().cols(), 4);
    Eigen::Index row = 0;
    for (std::size_t k = 0; k < prior->keys().size(); ++k) {
      const graph::Key key = prior->keys()[k];
      if (key.kind == 'x') {
        const SE3 T = graph.held().get<SE3>(key);
        const Eigen::Matrix3d R_B_O = T.rotation.inverse().matrix();
        N.block<3, 3>(row, 0) = R_B_O;
        N.block<3, 1>(row, 3) = R_B_O * Eigen::Vector3d::UnitZ().cross(T.translation - pivot);
        N.block<3, 1>(row + 3, 3) = R_B_O.col(2);
      } else if (key.kind == 'v') {
        N.block<3, 1>(row, 3) = Eigen::Vector3d::UnitZ().cross(graph.held().get<graph::Vector<3>>(key));
      }
      row += prior->types()[k].tangent;
    }
    return prior->jacobian() * N;
  }
  return {};
}

}  // namespace

TEST_CASE("Window: its prior never learns where it is nor which way is north") {
  World world;
  Window window(world.rig, {});
  // Nothing is said of either at the start, so that what the prior knows of them is false.
  const double nothing = 1e4;
  window.begin(world.sim.see(0, world.motion.state(0).T_W_B), world.guess(),
               {.position_m = nothing, .yaw_rad = nothing});
  for (int k = 0; k < 35; ++k) {
    world.add(window);
    window.optimise(6);
    window.discard_outliers();
    window.slide();
  }
  const Eigen::MatrixXd known = knowledge_of_gauge(window);
  REQUIRE(known.cols() == 4);
  CHECK(known.leftCols<3>().colwise().norm().maxCoeff() < 0.1);  // 1 / m
  CHECK(known.col(3).norm() < 0.1);                              // 1 / rad
}

TEST_CASE("Window: optimising disturbed keyframes finds them and says how well") {
  World world;
  Window window(world.rig, {});
  world.begin(window);
  for (int k = 0; k < 7; ++k) world.add(window);
  REQUIRE(window.landmarks_in_newest() > 40);
  const double before = world.error_m(window);
  const auto result = window.optimise(20);
  REQUIRE(result.converged);
  REQUIRE(world.error_m(window) < std::min(0.015, before));
  // Whitened residuals: the cost is about their number less that of the unknowns.
  double residuals = 0.0;
  for (const graph::FactorId id : window.graph().ids()) residuals += window.graph().factor(id).residual_dim();
  const double freedom = residuals - 15.0 * static_cast<double>(window.size()) -
                         3.0 * static_cast<double>(window.landmarks().size());
  REQUIRE(result.final_cost < 1.3 * freedom);
  REQUIRE(result.final_cost > 0.6 * freedom);
  const auto covariance = window.covariance();
  REQUIRE(covariance);
  const double sigma = std::sqrt(covariance->diagonal().head<3>().maxCoeff());
  REQUIRE(sigma < 0.01);
  REQUIRE(world.error_m(window) < 4.0 * sigma);
  const auto pair = window.pose_covariance(window.utime(2));
  REQUIRE(pair);
  REQUIRE(pair->bottomRightCorner<6, 6>().isApprox(covariance->topLeftCorner<6, 6>(), 1e-6));
  REQUIRE_FALSE(window.pose_covariance(-1));
}

TEST_CASE("Window: sliding keeps what was known, and the window small") {
  World world;
  Window window(world.rig, {});
  world.begin(window);
  for (int k = 0; k < 30; ++k) {
    world.add(window);
    window.optimise(6);
    window.discard_outliers();
    window.slide();
    REQUIRE(window.size() <= 10);
    REQUIRE(world.error_m(window) < 0.03);
  }
  REQUIRE(window.size() == 10);
  const auto covariance = window.covariance();
  REQUIRE(covariance);
  const double sigma = std::sqrt(covariance->diagonal().head<3>().maxCoeff());
  REQUIRE(sigma < 0.03);
  REQUIRE(world.error_m(window) < 4.0 * sigma);
}

TEST_CASE("Window: views that are off go, the others stay") {
  World world({.outliers = 0.15});
  VioOptions options;
  options.gate = 4.0;
  Window window(world.rig, options);
  world.begin(window);
  for (int k = 0; k < 6; ++k) world.add(window);
  window.optimise(20);
  const std::size_t before = window.landmarks().size();
  const int gone = window.discard_outliers();
  REQUIRE(gone > 0);
  REQUIRE(window.landmarks().size() == before - static_cast<std::size_t>(gone));
  REQUIRE(window.landmarks().size() > before / 2);
  window.optimise(20);
  REQUIRE(world.error_m(window) < 0.01);
}

TEST_CASE("Window: goes on without tracks") {
  World world;
  Window window(world.rig, {});
  world.begin(window);
  for (int k = 0; k < 15; ++k) {
    if (k > 4) world.sim.lose_all();
    world.add(window);
    window.optimise(6);
    window.slide();
  }
  REQUIRE(window.size() == 10);
  REQUIRE(window.newest_state().T_W_B.translation.allFinite());
  REQUIRE(window.covariance());
}

TEST_CASE("Window: who stands still and always sees the same does not drift") {
  World world({.sigma_px = 1.0, .room_m = {24.0, 24.0, 8.0}});
  const SE3 T_W_B = world.motion.state(0).T_W_B;
  std::vector<ImuSample> rest;
  for (Utime t = 0; t <= 60 * kKeyframeSpacing; t += 5000)
    rest.push_back({t, Eigen::Vector3d::Zero(), T_W_B.rotation.inverse() * Eigen::Vector3d(-kGravity)});
  add_imu_errors(world.rig.imu, {}, world.random, rest);
  Window window(
      world.rig,
      {.view_variance = 1.0, .view_lasting = 0.0, .way_share = 0.0});  // errors are independent here
  window.begin(world.sim.see(0, T_W_B), {T_W_B, Eigen::Vector3d::Zero(), {}}, {});
  double sigma = 0.0;
  for (int k = 0; k < 60; ++k) {
    const Utime until = (k + 1) * kKeyframeSpacing;
    window.add(world.sim.see(until, T_W_B), window.newest_state(),
               {rest.begin() + 40 * k, rest.begin() + 40 * k + 41});
    window.optimise(6);
    window.discard_outliers();
    const auto covariance = window.covariance();
    REQUIRE(covariance);
    sigma = std::sqrt(covariance->diagonal().head<3>().maxCoeff());
    window.slide();
    CHECK(window.landmarks_in_newest() > 50);
  }
  CAPTURE(sigma);
  CHECK(sigma < 0.02);  // 0.13 where the IMU alone ties the window to the past
  CHECK((window.newest_state().T_W_B.translation - T_W_B.translation).norm() < 3.0 * sigma);
}
