// SPDX-License-Identifier: BSD-3-Clause
#include "core/sim/grid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <random>

#include "core/base/angle.h"
#include "core/base/error.h"
#include "core/pgo/trajectories.h"

namespace covey::sim {
namespace {

using Random = std::mt19937_64;
using pgo::Edge;
using pgo::EdgeKind;
using pgo::PoseId;

// Streams that do not disturb each other: a change in one place does not redraw the whole world.
enum class Purpose : std::uint32_t { kPath, kOdometry, kClosures, kFalse };

struct Seed {
  std::uint64_t world;
  int drive;  // how often it was redrawn
};

Random random_for(const Seed& seed, Purpose purpose, int robot = 0) {
  std::seed_seq sequence{static_cast<std::uint32_t>(seed.world), static_cast<std::uint32_t>(seed.world >> 32),
                         static_cast<std::uint32_t>(seed.drive), static_cast<std::uint32_t>(purpose),
                         static_cast<std::uint32_t>(robot)};
  return Random(sequence);
}

double uniform(Random& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

int uniform_int(Random& random, int low, int high) {
  return std::uniform_int_distribution<int>(low, high)(random);
}

SE3 noise(Random& random, double rotation_sigma, double translation_sigma) {
  std::normal_distribution<double> normal;
  Vector6d xi;
  for (int k = 0; k < 6; ++k) xi[k] = normal(random) * (k < 3 ? translation_sigma : rotation_sigma);
  return SE3::exp(xi);
}

// Ground that rolls gently, with valleys that do not line up with the streets.
double height(double x, double y, double amplitude) {
  return amplitude * (std::sin(x / 6.0 + 0.4) + 0.7 * std::cos(y / 5.0 - x / 17.0));
}

// The pose of a body that stands on the ground at (x, y) and looks along the street and its slope.
SE3 pose_on_ground(const Eigen::Vector2d& p, double heading, double amplitude) {
  constexpr double kReach = 0.1;
  const Eigen::Vector2d ahead = p + kReach * Eigen::Vector2d(std::cos(heading), std::sin(heading));
  const double rise = height(ahead.x(), ahead.y(), amplitude) - height(p.x(), p.y(), amplitude);
  const SO3 yaw = SO3::exp({0.0, 0.0, heading});
  const SO3 pitch = SO3::exp({0.0, -std::atan2(rise, kReach), 0.0});
  return {yaw * pitch, {p.x(), p.y(), height(p.x(), p.y(), amplitude)}};
}

using Crossing = std::array<int, 2>;
constexpr std::array<Crossing, 4> kDirections = {{{1, 0}, {0, 1}, {-1, 0}, {0, -1}}};

Crossing neighbour(const Crossing& at, int direction) {
  return {at[0] + kDirections[direction][0], at[1] + kDirections[direction][1]};
}

bool inside(const Crossing& at, int blocks) {
  return at[0] >= 0 && at[0] <= blocks && at[1] >= 0 && at[1] <= blocks;
}

// Straight on twice as often as left or right; never back.
int next_direction(const Crossing& at, int direction, int blocks, Random& random) {
  std::vector<int> choices;
  for (const int turn : {0, 0, 1, 3}) {
    const int candidate = (direction + turn) % 4;
    if (inside(neighbour(at, candidate), blocks)) choices.push_back(candidate);
  }
  return choices[uniform_int(random, 0, static_cast<int>(choices.size()) - 1)];
}

Trajectory drive(const GridOptions& options, const Seed& seed, int robot) {
  Random random = random_for(seed, Purpose::kPath, robot);
  const int steps_per_block = static_cast<int>(std::lround(options.block_m / options.step_m));
  Crossing from = {uniform_int(random, 0, options.blocks), uniform_int(random, 0, options.blocks)};
  int direction = uniform_int(random, 0, 3);
  while (!inside(neighbour(from, direction), options.blocks)) direction = (direction + 1) % 4;
  Trajectory truth;
  double turned = 0.0;  // of the last turn; at a crossing the body looks half-way round the corner
  for (int k = 0; k < options.keyframes; ++k) {
    const int step = k % steps_per_block;
    if (step == 0 && k > 0) {
      from = neighbour(from, direction);
      const int next = next_direction(from, direction, options.blocks, random);
      turned = std::remainder((next - direction) * M_PI / 2.0, 2.0 * M_PI);
      direction = next;
    }
    const double along = options.block_m * step / steps_per_block;
    const Eigen::Vector2d p(options.block_m * from[0] + along * kDirections[direction][0],
                            options.block_m * from[1] + along * kDirections[direction][1]);
    const double heading = direction * M_PI / 2.0 - (step == 0 ? 0.5 * turned : 0.0);
    truth.push_back({pgo::keyframe_utime(k), pose_on_ground(p, heading, options.undulation_m)});
  }
  return truth;
}

struct Precision {
  double rotation_sigma;  // rad
  double translation_sigma;

  double kappa() const { return 1.0 / (2.0 * rotation_sigma * rotation_sigma); }
  double tau() const { return 1.0 / (translation_sigma * translation_sigma); }
};

class Builder {
 public:
  Builder(const GridOptions& options, const Seed& seed) : options_(options), seed_(seed) {
    for (int r = 0; r < options.robots; ++r) world_.truth.push_back(drive(options, seed, r));
    world_.graph.poses_per_robot.assign(options.robots, options.keyframes);
  }

  GridWorld build() {
    for (int r = 0; r < options_.robots; ++r) add_odometry(r);
    std::vector<Closure> closures = right_closures();
    const std::vector<Closure> wrong = false_closures(static_cast<int>(closures.size()));
    closures.insert(closures.end(), wrong.begin(), wrong.end());
    std::stable_sort(closures.begin(), closures.end(),
                     [](const Closure& a, const Closure& b) { return a.found_at() < b.found_at(); });
    for (const Closure& closure : closures) add(closure.edge, closure.right);
    return std::move(world_);
  }

 private:
  struct Closure {
    Edge edge;
    bool right = false;
    int found_at() const { return std::max(edge.from.index, edge.to.index); }
  };

  const SE3& truth(const PoseId& id) const { return world_.truth[id.robot][id.index].pose; }

  void add(const Edge& edge, bool right) {
    world_.graph.edges.push_back(edge);
    world_.right.push_back(right);
  }

  Edge measure(const PoseId& from, const PoseId& to, const Precision& precision, Random& random) const {
    Edge edge;
    edge.from = from;
    edge.to = to;
    edge.measurement = truth(from).inverse() * truth(to) *
                       noise(random, precision.rotation_sigma, precision.translation_sigma);
    edge.kappa = precision.kappa();
    edge.tau = precision.tau();
    return edge;
  }

  Precision closure_precision() const {
    return {options_.closure_rotation_sigma_deg * kDegree, options_.closure_translation_sigma_m};
  }

  void add_odometry(int robot) {
    Random random = random_for(seed_, Purpose::kOdometry, robot);
    const Precision precision{options_.odometry_rotation_sigma_deg * kDegree,
                              options_.odometry_translation_sigma_m};
    for (int k = 0; k + 1 < options_.keyframes; ++k) {
      Edge edge = measure({robot, k}, {robot, k + 1}, precision, random);
      edge.kind = EdgeKind::kOdometry;
      edge.known_inlier = true;
      add(edge, true);
    }
  }

  bool sees_the_same(const PoseId& a, const PoseId& b) const {
    const SE3 T_a_b = truth(a).inverse() * truth(b);
    return T_a_b.translation.norm() <= options_.closure_range_m &&
           T_a_b.rotation.log().norm() <= options_.closure_angle_deg * kDegree;
  }

  // The nearest of robot `other`'s keyframes so far that sees what keyframe `now` sees.
  std::optional<PoseId> earlier_pass(const PoseId& now, int other) const {
    const int last = other == now.robot ? now.index - options_.closure_min_separation : now.index;
    std::optional<PoseId> best;
    double best_distance = 0.0;
    for (int k = 0; k <= last; ++k) {
      const PoseId candidate{other, k};
      const double distance = (truth(candidate).translation - truth(now).translation).norm();
      if (sees_the_same(candidate, now) && (!best || distance < best_distance)) {
        best = candidate;
        best_distance = distance;
      }
    }
    return best;
  }

  std::vector<Closure> right_closures() const {
    Random random = random_for(seed_, Purpose::kClosures);
    std::vector<Closure> closures;
    for (int k = 0; k < options_.keyframes; ++k) {
      for (int r = 0; r < options_.robots; ++r) {
        for (int other = 0; other < options_.robots; ++other) {
          const std::optional<PoseId> before = earlier_pass({r, k}, other);
          if (!before || uniform(random, 0.0, 1.0) >= options_.closure_probability) continue;
          closures.push_back({measure(*before, {r, k}, closure_precision(), random), true});
        }
      }
    }
    return closures;
  }

  std::vector<Closure> false_closures(int right) const {
    Random random = random_for(seed_, Purpose::kFalse);
    const auto wanted =
        static_cast<std::size_t>(std::lround(right * options_.false_share / (1.0 - options_.false_share)));
    const auto any_pose = [&] {
      return PoseId{uniform_int(random, 0, options_.robots - 1),
                    uniform_int(random, 0, options_.keyframes - 1)};
    };
    std::vector<Closure> closures;
    while (closures.size() < wanted) {
      const PoseId a = any_pose();
      const PoseId b = any_pose();
      if (a.robot == b.robot && std::abs(a.index - b.index) < options_.closure_min_separation) continue;
      Edge edge = measure(a, b, closure_precision(), random);
      edge.measurement.translation = {uniform(random, -10.0, 10.0), uniform(random, -10.0, 10.0),
                                      uniform(random, -10.0, 10.0)};
      std::normal_distribution<double> normal;
      edge.measurement.rotation = SO3::from_quaternion(
          Eigen::Quaterniond(normal(random), normal(random), normal(random), normal(random)));
      closures.push_back({edge, false});
    }
    return closures;
  }

  GridOptions options_;
  Seed seed_;
  GridWorld world_;
};

// Whether chains of pairs with enough right closures between them join all robots.
bool all_linked(const GridWorld& world, int min_links) {
  const int robots = world.graph.robots();
  Eigen::MatrixXi links = Eigen::MatrixXi::Zero(robots, robots);
  for (std::size_t e = 0; e < world.graph.edges.size(); ++e) {
    const Edge& edge = world.graph.edges[e];
    if (!world.right[e]) continue;
    ++links(edge.from.robot, edge.to.robot);
    ++links(edge.to.robot, edge.from.robot);
  }
  std::vector<int> reached = {0};
  std::vector<bool> seen(robots, false);
  seen[0] = true;
  for (std::size_t n = 0; n < reached.size(); ++n) {
    for (int r = 0; r < robots; ++r) {
      if (seen[r] || links(reached[n], r) < min_links) continue;
      seen[r] = true;
      reached.push_back(r);
    }
  }
  return static_cast<int>(reached.size()) == robots;
}

// A town in which a drive of this length passes most places about twice.
int suitable_blocks(int keyframes) {
  return std::max(2, static_cast<int>(std::lround(std::sqrt(keyframes / 13.0))));
}

}  // namespace

void read_grid(ConfigSection& section, GridOptions& options) {
  section.read("blocks", options.blocks, 0, 1000);
  section.read("block_m", options.block_m, 0.1, 1000.0);
  section.read("step_m", options.step_m, 0.01, options.block_m);
  section.read("undulation_m", options.undulation_m, 0.0, 100.0);
  section.read("odometry_rotation_sigma_deg", options.odometry_rotation_sigma_deg, 1e-3, 30.0);
  section.read("odometry_translation_sigma_m", options.odometry_translation_sigma_m, 1e-4, 10.0);
  section.read("closure_rotation_sigma_deg", options.closure_rotation_sigma_deg, 1e-3, 30.0);
  section.read("closure_translation_sigma_m", options.closure_translation_sigma_m, 1e-4, 10.0);
  section.read("closure_range_m", options.closure_range_m, 0.0, 100.0);
  section.read("closure_angle_deg", options.closure_angle_deg, 0.0, 180.0);
  section.read("closure_min_separation", options.closure_min_separation, 2, 1'000'000);
  section.read("closure_probability", options.closure_probability, 0.0, 1.0);
  section.read("false_share", options.false_share, 0.0, 0.95);
  section.read("min_links", options.min_links, 0, 1'000'000);
}

GridWorld make_grid(const GridOptions& options) {
  COVEY_CHECK(options.robots > 0 && options.keyframes > 1 && options.blocks >= 0);
  COVEY_CHECK(options.step_m > 0.0 && options.block_m >= options.step_m && options.false_share < 1.0);
  GridOptions town = options;
  if (town.blocks == 0) town.blocks = suitable_blocks(options.keyframes);
  constexpr int kDrives = 100;
  for (int drive = 0; drive < kDrives; ++drive) {
    GridWorld world = Builder(town, {options.seed, drive}).build();
    if (all_linked(world, options.min_links)) return world;
  }
  throw_input_error("grid: {} keyframes are too few for {} robots to meet in a town of {} x {} blocks",
                    options.keyframes, options.robots, town.blocks, town.blocks);
}

}  // namespace covey::sim
