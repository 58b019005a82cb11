// SPDX-License-Identifier: BSD-3-Clause
// One robot solves for all, on a network that loses, delays, doubles and disorders: as with D-GNC, the result is that of the
// perfect network to the last bit.

#include <algorithm>
#include <catch2/catch.hpp>
#include <map>
#include <string>

#include "core/pgo/dgnc_agent.h"
#include "core/pgo/solve_distributed.h"
#include "core/sim/grid.h"
#include "tests/simnet/network.h"

namespace covey::pgo {
namespace {

constexpr Utime kSecond = kUsPerSecond;

sim::GridWorld small_world() {
  return sim::make_grid({.robots = 3, .keyframes = 40, .seed = 4, .min_links = 4});
}

Matrix6d isotropic(double kappa, double tau) {
  Vector6d variances;
  variances << Eigen::Vector3d::Constant(1.0 / tau), Eigen::Vector3d::Constant(0.5 / kappa);
  return variances.asDiagonal();
}

AgentOptions elected(bool full_covariances = false) {
  AgentOptions options;
  // Settles long enough for everybody to hear of everybody, so that there is one round.
  options.settle_us = 8 * kSecond;
  options.request_us = kSecond / 2;
  options.dgnc.solver = RoundSolver::kElected;
  options.dgnc.full_covariances = full_covariances;
  return options;
}

// What robot's front end says: with gravity, as it is at the truth.
void feed(const sim::GridWorld& world, int robot, DgncAgent& agent) {
  const Trajectory& truth = world.truth[robot];
  const auto keyframe = [&](int id) {
    Keyframe k;
    k.name = {robot, 1, id};
    k.gravity = {truth[id].pose.rotation.inverse() * Eigen::Vector3d(0.0, 0.0, -1.0), 0.005};
    return k;
  };
  Keyframe last = keyframe(0);
  last.T_O_K.rotation = truth[0].pose.rotation;
  REQUIRE(agent.add(last) == nullptr);
  for (const Edge& edge : world.graph.edges) {
    if (edge.kind == EdgeKind::kOdometry && edge.from.robot == robot) {
      Keyframe next = keyframe(edge.to.index);
      next.T_P_K = edge.measurement;
      next.T_O_K = last.T_O_K * edge.measurement;
      next.covariance = isotropic(edge.kappa, edge.tau);
      REQUIRE(agent.add(next) == nullptr);
      last = next;
    } else if (edge.kind == EdgeKind::kLoop && (edge.from.robot == robot || edge.to.robot == robot)) {
      REQUIRE(agent.add(Loop{{edge.from.robot, 1, edge.from.index},
                             {edge.to.robot, 1, edge.to.index},
                             edge.measurement,
                             isotropic(edge.kappa, edge.tau)}) == nullptr);
    }
  }
}

// Until every robot has a result. options by robot.
std::map<int, RoundResult> solve(const std::vector<AgentOptions>& options, LinkFaults faults,
                                 std::uint64_t seed) {
  const sim::GridWorld world = small_world();
  SimNetwork<AgentMessage> network(seed, faults, 3);
  std::vector<DgncAgent> agents;
  for (int robot = 0; robot < 3; ++robot) {
    agents.emplace_back(robot, 1, options[robot]);
    feed(world, robot, agents[robot]);
  }
  std::map<int, RoundResult> results;
  const auto work = [&](int robot, Utime now) {
    do {
      for (const AgentMessage& message : agents[robot].take_outgoing())
        network.send(robot, kEveryone, message, now);
      if (auto result = agents[robot].take_result()) results[robot] = std::move(*result);
    } while (agents[robot].advance(now));
  };
  for (Utime now = 0; results.size() < 3; now += 20'000) {
    REQUIRE(now < 600 * kSecond);
    network.deliver_until(now, [&](int to, int, const AgentMessage& message, Utime t) {
      agents[to].receive(message, t);
      work(to, t);
    });
    for (int robot = 0; robot < 3; ++robot) {
      agents[robot].tick(now);
      work(robot, now);
    }
  }
  return results;
}

std::map<int, RoundResult> solve(const AgentOptions& options, LinkFaults faults, std::uint64_t seed) {
  return solve(std::vector<AgentOptions>(3, options), faults, seed);
}

double cost_of(const std::map<int, RoundResult>& results) {
  double cost = 0.0;
  for (const auto& [robot, result] : results) cost += result.owned_cost;
  return cost;
}

void require_identical(const std::map<int, RoundResult>& a, const std::map<int, RoundResult>& b) {
  for (const auto& [robot, result] : a) {
    const RoundResult& other = b.at(robot);
    REQUIRE(result.name.number == 1);
    REQUIRE(other.name.number == 1);
    REQUIRE(result.robots == std::vector<int>{0, 1, 2});
    REQUIRE(result.segments.size() == other.segments.size());
    for (std::size_t s = 0; s < result.segments.size(); ++s) {
      REQUIRE(result.segments[s].T_W_K.size() == other.segments[s].T_W_K.size());
      for (std::size_t k = 0; k < result.segments[s].T_W_K.size(); ++k) {
        REQUIRE(result.segments[s].T_W_K[k].translation == other.segments[s].T_W_K[k].translation);
        REQUIRE(result.segments[s].T_W_K[k].rotation.quaternion().coeffs() ==
                other.segments[s].T_W_K[k].rotation.quaternion().coeffs());
      }
    }
    REQUIRE(result.loops.size() == other.loops.size());
    for (std::size_t k = 0; k < result.loops.size(); ++k) {
      REQUIRE(result.loops[k].weight == other.loops[k].weight);
      REQUIRE(result.loops[k].r2 == other.loops[k].r2);
    }
    REQUIRE(result.owned_cost == other.owned_cost);
  }
}

TEST_CASE("elected: loss, delay, doubles and disorder change nothing in the result") {
  for (const bool full : {false, true}) {
    const auto perfect = solve(elected(full), {}, 1);
    require_identical(perfect, solve(elected(full), {.loss = 0.2, .delay_us = 100'000}, 2));
    require_identical(
        perfect,
        solve(elected(full), {.loss = 0.4, .delay_us = 50'000, .jitter_us = 400'000, .duplicate = 0.3}, 3));
  }
}

TEST_CASE("elected: agents reach what the solver in one process reaches, and so does D-GNC") {
  const auto agents = solve(elected(), {.loss = 0.1, .delay_us = 30'000}, 1);
  DistributedOptions options;
  options.dgnc.solver = RoundSolver::kElected;
  const DistributedResult direct = solve_distributed(small_world().graph, options);
  const DistributedResult dgnc = solve_distributed(small_world().graph);
  REQUIRE(cost_of(agents) == Approx(direct.cost).epsilon(1e-5));
  REQUIRE(cost_of(agents) == Approx(dgnc.cost).epsilon(1e-3));
  int kept = 0;
  for (const auto& [robot, result] : agents) kept += result.owned_kept;
  REQUIRE(kept == direct.kept);
  REQUIRE(kept == dgnc.kept);
}

TEST_CASE("elected: with full covariances and gravity the team's keyframes stand upright in W") {
  const sim::GridWorld world = small_world();
  const auto results = solve(elected(true), {}, 1);
  const auto as_scaled = solve(elected(), {}, 1);
  for (const auto& [robot, result] : results) {
    REQUIRE(result.loops_kept == as_scaled.at(robot).loops_kept);
    for (int k = 0; k < 40; ++k) {
      const Eigen::Vector3d down_K =
          world.truth[robot][k].pose.rotation.inverse() * Eigen::Vector3d(0.0, 0.0, -1.0);
      REQUIRE((result.segments[0].T_W_K[k].rotation * down_K - Eigen::Vector3d(0.0, 0.0, -1.0)).norm() <
              0.02);
    }
  }
}

TEST_CASE("elected: a robot that solves with D-GNC is left apart, and named") {
  std::vector<AgentOptions> options(3, elected());
  options[2].dgnc.solver = RoundSolver::kDgnc;
  const auto results = solve(options, {.loss = 0.2, .delay_us = 30'000}, 1);
  REQUIRE(results.at(0).robots == std::vector<int>{0, 1});
  REQUIRE(results.at(2).robots == std::vector<int>{2});
  const auto& warnings = results.at(0).warnings;
  REQUIRE(std::any_of(warnings.begin(), warnings.end(), [](const std::string& warning) {
    return warning.find("robot 2's section dpgo differs") != std::string::npos;
  }));
}

}  // namespace
}  // namespace covey::pgo
