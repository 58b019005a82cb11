// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/rbcd.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <set>

#include "core/pgo/central.h"
#include "core/pgo/cost.h"
#include "core/pgo/experiment.h"
#include "core/pgo/robot_blocks.h"
#include "core/pgo/start.h"
#include "tests/core/pgo/worlds.h"

namespace covey::pgo {
namespace {

struct Problem {
  PoseGraph graph;
  Poses start;  // away from the optimum
};

Problem make_problem(int robots, int seed, int dimension = 3) {
  const Walk walk =
      make_walk({.dimension = dimension, .poses = 150, .rotation_sigma = 0.03, .grid = 4, .seed = seed});
  Problem problem{cut_into_robots(walk.graph, robots), walk.truth};
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal(0.0, 0.2);
  for (SE3& T : problem.start) {
    Vector6d xi = Vector6d::NullaryExpr([&] { return normal(random); });
    if (dimension == 2) xi.segment<3>(2).setZero();
    T = T * SE3::exp(xi);
  }
  return problem;
}

constexpr Schedule kInOrder[] = {Schedule::kGreedy, Schedule::kRoundRobin, Schedule::kColoured};

TEST_CASE("the team's cost never rises, and is what the evidence says") {
  for (const Schedule schedule : kInOrder) {
    for (const bool accelerated : {true, false}) {
      for (int seed = 1; seed <= 4; ++seed) {
        const Problem problem = make_problem(2 + seed, seed);
        RbcdOptions options{.schedule = schedule, .accelerated = accelerated, .max_block_updates = 60};
        double last =
            cost(problem.graph, problem.start) * (1.0 + 1e-6);  // the start is sent in single precision
        options.stop = [&](const RbcdProgress& progress) {
          const double now = cost(problem.graph, progress.poses());
          REQUIRE(now == Approx(progress.cost).epsilon(1e-9));
          REQUIRE(now <= last * (1.0 + 1e-12));
          last = now;
          return false;
        };
        const RbcdResult result = solve_rbcd(problem.graph, problem.start, options);
        REQUIRE(result.block_updates == static_cast<int>(result.updates.size()));
        for (std::size_t k = 0; k < result.updates.size(); ++k) {
          const RbcdUpdate& update = result.updates[k];
          REQUIRE(update.cost_after <= update.cost_before);
          if (k > 0) REQUIRE(update.cost_before <= result.updates[k - 1].cost_after);
        }
        REQUIRE((accelerated ? result.accelerations > 0 : result.accelerations == 0));
      }
    }
  }
}

TEST_CASE("all schedules end at the central optimum") {
  for (const int dimension : {2, 3}) {
    const Problem problem = make_problem(4, 11, dimension);
    const double optimum = solve_least_squares(problem.graph, chordal_start(problem.graph)).cost;
    for (const auto& [name, schedule] : schedules()) {
      for (const int rank : {3, 5}) {
        INFO(name << " in " << dimension << "D, rank " << rank);
        const RbcdResult result = solve_rbcd(problem.graph, problem.start,
                                             {.schedule = schedule, .rank = rank, .tolerance = 1e-10});
        REQUIRE(result.converged);
        REQUIRE(cost(problem.graph, result.poses) == Approx(optimum).epsilon(1e-6));
        REQUIRE(result.cost == Approx(optimum).epsilon(1e-6));
      }
    }
  }
}

TEST_CASE("acceleration saves half of the updates, and more") {
  const Problem problem = make_problem(5, 12);
  const double optimum = solve_least_squares(problem.graph, chordal_start(problem.graph)).cost;
  const auto updates = [&](bool accelerated) {
    RbcdOptions options{.accelerated = accelerated, .tolerance = 0.0};
    options.stop = [&](const RbcdProgress& progress) { return progress.cost < optimum * (1.0 + 1e-5); };
    return solve_rbcd(problem.graph, problem.start, options).block_updates;
  };
  REQUIRE(2 * updates(true) < updates(false));
}

TEST_CASE("greedy updates the block whose gradient is largest") {
  const Problem problem = make_problem(5, 13);
  const std::vector<RobotBlock> blocks = split_into_blocks(problem.graph, 3, {});
  const auto argmax = [&](const Poses& poses) {
    std::vector<Lifted> X;
    std::vector<Lifted> known;
    for (const RobotBlock& block : blocks) {
      Lifted mine(3, 4 * block.solver.poses());
      for (int k = 0; k < block.solver.poses(); ++k)
        mine.middleCols<4>(4 * k) = lift(poses[block.first + k], 3);
      known.push_back(public_part(block, mine));
      X.push_back(std::move(mine));
    }
    int best = 0;
    double largest = -1.0;
    for (const RobotBlock& block : blocks) {
      const double norm = block.solver.riemannian_gradient(targets_of(block, known), X[block.robot]).norm();
      if (norm > largest) best = block.robot, largest = norm;
    }
    return best;
  };
  RbcdOptions options{.schedule = Schedule::kGreedy, .accelerated = false, .max_block_updates = 40};
  std::vector<int> expected = {argmax(problem.start)};
  options.stop = [&](const RbcdProgress& progress) {
    expected.push_back(argmax(progress.poses()));
    return false;
  };
  const RbcdResult result = solve_rbcd(problem.graph, problem.start, options);
  std::set<int> updated;
  for (std::size_t k = 0; k < result.updates.size(); ++k) {
    REQUIRE(result.updates[k].robot == expected[k]);
    updated.insert(result.updates[k].robot);
  }
  REQUIRE(updated.size() == 5);
}

TEST_CASE("robots of one colour take one step together") {
  const Problem problem = make_problem(6, 14);
  const std::vector<int> colours = colours_of(split_into_blocks(problem.graph, 3, {}));
  const int n = 1 + *std::max_element(colours.begin(), colours.end());
  const RbcdResult result = solve_rbcd(problem.graph, problem.start, {.max_block_updates = 18});
  REQUIRE(result.block_updates == 18);
  REQUIRE(result.rounds == 3);
  REQUIRE(result.steps == 3 * n);
  std::vector<int> order;
  for (int k = 0; k < 6; ++k) order.push_back(result.updates[k].robot);
  REQUIRE(std::is_sorted(order.begin(), order.end(), [&](int a, int b) { return colours[a] < colours[b]; }));
}

TEST_CASE("asynchronous updates converge from old poses, whatever the draw") {
  const Problem problem = make_problem(4, 15);
  const double optimum = solve_least_squares(problem.graph, chordal_start(problem.graph)).cost;
  std::set<int> updates;
  for (const std::uint64_t seed : {1, 2, 3}) {
    const RbcdOptions options{
        .schedule = Schedule::kAsynchronous, .seed = seed, .max_delay = 20, .tolerance = 1e-9};
    const RbcdResult result = solve_rbcd(problem.graph, problem.start, options);
    REQUIRE(result.converged);
    REQUIRE(result.cost == Approx(optimum).epsilon(1e-5));
    REQUIRE(solve_rbcd(problem.graph, problem.start, options).cost == result.cost);
    updates.insert(result.block_updates);
  }
  REQUIRE(updates.size() > 1);
}

TEST_CASE("what is sent is counted by kind") {
  const Problem problem = make_problem(4, 16);
  std::size_t public_poses = 0;
  for (const RobotBlock& block : split_into_blocks(problem.graph, 3, {}))
    public_poses += block.public_poses.size();
  const auto bytes = [&](Schedule schedule, bool accelerated) {
    return solve_rbcd(
               problem.graph, problem.start,
               {.schedule = schedule, .accelerated = accelerated, .tolerance = 0.0, .max_block_updates = 12})
        .bytes;
  };
  auto plain = bytes(Schedule::kRoundRobin, false);
  REQUIRE(plain.size() == 2);
  REQUIRE(plain["start"] > static_cast<std::int64_t>(28 * public_poses));
  REQUIRE(plain["start"] < static_cast<std::int64_t>(40 * public_poses + 4 * 80));
  REQUIRE(plain["update"] >
          static_cast<std::int64_t>(3 * 24 * public_poses));  // three rounds, 12 16-bit numbers each
  REQUIRE(plain["update"] < static_cast<std::int64_t>(3 * 24 * public_poses + 12 * 120));
  auto accelerated = bytes(Schedule::kRoundRobin, true);
  REQUIRE(accelerated["acceleration"] > 0);
  REQUIRE(accelerated["acceleration"] < accelerated["update"]);
  REQUIRE(bytes(Schedule::kGreedy, false)["gradient"] > 12 * 52);
}

TEST_CASE("planar poses stay in the plane") {
  const Problem problem = make_problem(3, 17, 2);
  for (const SE3& T : solve_rbcd(problem.graph, problem.start).poses) {
    REQUIRE(std::abs(T.translation.z()) < 1e-12);
    REQUIRE(T.rotation.log().head<2>().norm() < 1e-12);
  }
}

TEST_CASE("one robot alone solves its graph, and the first pose stays") {
  Problem problem = make_problem(1, 18);
  const double optimum = solve_least_squares(problem.graph, chordal_start(problem.graph)).cost;
  const RbcdResult result = solve_rbcd(problem.graph, problem.start, {.tolerance = 1e-12});
  REQUIRE(cost(problem.graph, result.poses) == Approx(optimum).epsilon(1e-8));
  REQUIRE((result.poses.front().inverse() * problem.start.front()).log().norm() < 1e-9);
}

}  // namespace
}  // namespace covey::pgo
