// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/experiment.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <random>
#include <utility>

#include "core/base/error.h"

namespace covey::pgo {
namespace {

PoseId pose_at(const std::vector<int>& offsets, int flat) {
  const auto robot = std::upper_bound(offsets.begin(), offsets.end(), flat) - offsets.begin() - 1;
  return {static_cast<int>(robot), flat - offsets[robot]};
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

SE3 random_motion(std::mt19937_64& random, int dimension) {
  std::uniform_real_distribution<double> coordinate(-10.0, 10.0);
  SE3 T;
  if (dimension == 2) {
    std::uniform_real_distribution<double> angle(-std::numbers::pi, std::numbers::pi);
    T.rotation = SO3::exp({0.0, 0.0, angle(random)});
  } else {
    std::normal_distribution<double> normal;
    Eigen::Vector4d q;
    for (double& value : q) value = normal(random);
    T.rotation = SO3::from_quaternion(Eigen::Quaterniond(q));
  }
  for (int axis = 0; axis < dimension; ++axis) T.translation[axis] = coordinate(random);
  return T;
}

// One step of a walk, or a turn on the spot.
SE3 planar_motion(double forward, double angle) { return {SO3::exp({0.0, 0.0, angle}), {forward, 0.0, 0.0}}; }

// A random walk through the corridors of stata_like, T_W_pose.
class CorridorWalk {
 public:
  CorridorWalk(const StataOptions& options, std::mt19937_64& random) : options_(options), random_(random) {}

  Poses walk() {
    x_ = static_cast<int>(random_() % (options_.blocks_x + 1));
    y_ = static_cast<int>(random_() % (options_.blocks_y + 1));
    heading_ = static_cast<int>(random_() % 4);
    Poses poses = {
        {SO3::exp({0.0, 0.0, heading_ * kQuarter}), {x_ * options_.block, y_ * options_.block, 0.0}}};
    while (static_cast<int>(poses.size()) < options_.poses_per_robot) {
      turn(poses);
      go(poses);
    }
    poses.resize(options_.poses_per_robot);
    return poses;
  }

 private:
  static constexpr double kQuarter = 0.5 * std::numbers::pi;

  bool is_open(int heading) const {
    const int x = x_ + (heading == 0 ? 1 : heading == 2 ? -1 : 0);
    const int y = y_ + (heading == 1 ? 1 : heading == 3 ? -1 : 0);
    return x >= 0 && x <= options_.blocks_x && y >= 0 && y <= options_.blocks_y;
  }

  // Any way but back; at the start, which may face a wall, any way.
  void turn(Poses& poses) {
    int quarters = 0;
    do {
      quarters = static_cast<int>(random_() % (poses.size() > 1 ? 3 : 4)) - 1;
    } while (!is_open((heading_ + quarters + 4) % 4));
    heading_ = (heading_ + quarters + 4) % 4;
    for (int k = 0; k < 3 * std::abs(quarters); ++k) {
      poses.push_back(poses.back() * planar_motion(0.0, (quarters > 0 ? 1.0 : -1.0) * kQuarter / 3.0));
    }
  }

  void go(Poses& poses) {
    std::uniform_real_distribution<double> step(0.9 * options_.step, 1.1 * options_.step);
    for (double left = options_.block; left > 1e-9;) {
      const double length = std::min(step(random_), left);
      poses.push_back(poses.back() * planar_motion(length, 0.0));
      left -= length;
    }
    x_ += heading_ == 0 ? 1 : heading_ == 2 ? -1 : 0;
    y_ += heading_ == 1 ? 1 : heading_ == 3 ? -1 : 0;
  }

  const StataOptions& options_;
  std::mt19937_64& random_;
  int x_ = 0;
  int y_ = 0;
  int heading_ = 0;  // quarters of a turn from the x axis
};

// The edges of stata_like, drawn from the robots' true poses.
class StataGraph {
 public:
  StataGraph(const StataOptions& options, StataWorld& world, std::mt19937_64& random)
      : options_(options), world_(world), random_(random), offsets_(world.graph.offsets()) {}

  void add_odometry(int robot) {
    for (int k = 0; k + 1 < options_.poses_per_robot; ++k) {
      Edge& edge = add_measured({robot, k}, {robot, k + 1}, options_.odometry_rotation_sigma,
                                options_.odometry_translation_sigma);
      edge.kind = EdgeKind::kOdometry;
      edge.known_inlier = true;
    }
  }

  void add_true_loops(int a, int b, int count) {
    for (int found = 0; found < count;) {
      const PoseId from = random_pose(a);
      const PoseId to = random_pose(b);
      if ((a == b && to.index < from.index + kSeparation) || !same_place(from, to)) continue;
      add_measured(from, to, options_.closure_rotation_sigma, options_.closure_translation_sigma);
      ++found;
    }
  }

  void add_false_loops(int robot) {
    const double share = options_.false_share;
    const auto count = std::lround(options_.closures_per_robot * share / (1.0 - share));
    for (long found = 0; found < count;) {
      const PoseId from = random_pose(robot);
      const PoseId to = random_pose(robot);
      if (std::abs(from.index - to.index) <= 1) continue;
      Edge& edge =
          add_measured(from, to, options_.closure_rotation_sigma, options_.closure_translation_sigma);
      edge.measurement = random_motion(random_, 3);
      world_.is_true.back() = false;
      ++found;
    }
  }

 private:
  static constexpr int kSeparation = 50;

  const SE3& truth(const PoseId& id) const { return world_.truth[offsets_[id.robot] + id.index]; }

  PoseId random_pose(int robot) {
    return {robot, static_cast<int>(random_() % static_cast<unsigned>(options_.poses_per_robot))};
  }

  bool same_place(const PoseId& a, const PoseId& b) const {
    const SE3 T = truth(a).inverse() * truth(b);
    return T.translation.norm() <= options_.range && T.rotation.log().norm() <= 0.25 * std::numbers::pi;
  }

  Edge& add_measured(const PoseId& from, const PoseId& to, double rotation_sigma, double translation_sigma) {
    std::normal_distribution<double> normal;
    Vector6d noise;
    for (int axis = 0; axis < 6; ++axis)
      noise[axis] = (axis < 3 ? translation_sigma : rotation_sigma) * normal(random_);
    Edge edge{from, to, truth(from).inverse() * truth(to) * SE3::exp(noise)};
    edge.kappa = 0.5 / (rotation_sigma * rotation_sigma);
    edge.tau = 1.0 / (translation_sigma * translation_sigma);
    world_.graph.edges.push_back(edge);
    world_.is_true.push_back(true);
    return world_.graph.edges.back();
  }

  const StataOptions& options_;
  StataWorld& world_;
  std::mt19937_64& random_;
  std::vector<int> offsets_;
};

}  // namespace

StataWorld stata_like(const StataOptions& options) {
  constexpr int kRobots = 3;
  constexpr std::array<std::pair<int, int>, 3> kPairs = {{{0, 1}, {1, 2}, {0, 2}}};
  COVEY_CHECK(options.poses_per_robot >= 500 && options.between.size() == kPairs.size());
  COVEY_CHECK(options.false_share >= 0.0 && options.false_share < 1.0);
  std::mt19937_64 random(options.seed);
  StataWorld world;
  world.graph = {3, std::vector<int>(kRobots, options.poses_per_robot), {}};
  for (int robot = 0; robot < kRobots; ++robot) {
    const Poses walked = CorridorWalk(options, random).walk();
    world.truth.insert(world.truth.end(), walked.begin(), walked.end());
  }
  StataGraph graph(options, world, random);
  for (int robot = 0; robot < kRobots; ++robot) graph.add_odometry(robot);
  for (int robot = 0; robot < kRobots; ++robot) {
    graph.add_true_loops(robot, robot, options.closures_per_robot);
    graph.add_false_loops(robot);
  }
  for (std::size_t p = 0; p < kPairs.size(); ++p)
    graph.add_true_loops(kPairs[p].first, kPairs[p].second, options.between[p]);
  return world;
}

PoseGraph cut_into_robots(const PoseGraph& graph, int robots) {
  COVEY_CHECK(graph.robots() == 1 && robots >= 1 && robots <= graph.poses());
  const std::int64_t n = graph.poses();
  std::vector<int> offsets;
  for (std::int64_t r = 0; r <= robots; ++r) offsets.push_back(static_cast<int>(r * n / robots));
  PoseGraph cut{graph.dimension, {}, graph.edges};
  for (int r = 0; r < robots; ++r) cut.poses_per_robot.push_back(offsets[r + 1] - offsets[r]);
  for (Edge& edge : cut.edges) {
    edge.from = pose_at(offsets, edge.from.index);
    edge.to = pose_at(offsets, edge.to.index);
    if (edge.between_robots()) {
      edge.kind = EdgeKind::kLoop;
      edge.known_inlier = false;
    }
  }
  return cut;
}

Injection inject_outliers(const PoseGraph& graph, double share, std::uint64_t seed) {
  COVEY_CHECK(share >= 0.0 && share < 1.0);
  Injection result{graph, std::vector<bool>(graph.edges.size(), true)};
  const int loops = graph.loops();
  const auto wanted = std::lround(loops * share / (1.0 - share));
  if (wanted == 0) return result;
  std::vector<double> kappas;
  std::vector<double> taus;
  for (const Edge& edge : graph.edges) {
    if (loops > 0 && edge.kind != EdgeKind::kLoop) continue;
    kappas.push_back(edge.kappa);
    taus.push_back(edge.tau);
  }
  const double kappa = median(std::move(kappas));
  const double tau = median(std::move(taus));
  const std::vector<int> offsets = graph.offsets();
  const int n = graph.poses();
  const int with_poses = static_cast<int>(
      std::count_if(graph.poses_per_robot.begin(), graph.poses_per_robot.end(), [](int p) { return p > 0; }));
  COVEY_CHECK(with_poses > 1 || n > 2);
  std::mt19937_64 random(seed);
  std::uniform_int_distribution<int> any(0, n - 1);
  for (long k = 0; k < wanted; ++k) {
    Edge edge;
    int from = 0;
    int to = 0;
    do {
      from = any(random);
      to = any(random);
      edge.from = pose_at(offsets, from);
      edge.to = pose_at(offsets, to);
    } while (with_poses > 1 ? !edge.between_robots() : std::abs(from - to) <= 1);
    edge.measurement = random_motion(random, graph.dimension);
    edge.kappa = kappa;
    edge.tau = tau;
    result.graph.edges.push_back(edge);
    result.is_true.push_back(false);
  }
  return result;
}

}  // namespace covey::pgo
