// SPDX-License-Identifier: BSD-3-Clause
// One robot solves for all, on a network that loses, delays, doubles and disorders: as with D-GNC, the result is that of the
// perfect network to the last bit.

#include <algorithm>
#include <catch2/catch.hpp>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/pgo/dgnc_agent.h"
#include "core/pgo/solve_distributed.h"
#include "core/sim/grid.h"
#include "tests/simnet/network.h"

namespace covey::pgo {
namespace {

constexpr Utime kSecond = kUsPerSecond;
constexpr int kRobots = 3;

sim::GridWorld small_world() {
  return sim::make_grid({.robots = kRobots, .keyframes = 40, .seed = 4, .min_links = 4});
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

class Team {
 public:
  // Each step of a robot's solver takes step_us, in which it hears nothing.
  Team(const std::vector<AgentOptions>& options, LinkFaults faults, std::uint64_t seed, Utime step_us = 0)
      : network_(seed, faults, kRobots) {
    const sim::GridWorld world = small_world();
    agents_.reserve(kRobots);
    for (int robot = 0; robot < kRobots; ++robot) {
      AgentOptions own = options[robot];
      if (step_us > 0) own.dgnc.meanwhile = [this, robot, step_us] { spend(robot, step_us); };
      agents_.emplace_back(robot, 1, own);
      feed(world, robot, agents_[robot]);
    }
  }

  // Until every robot has a result.
  std::map<int, RoundResult> solve() {
    while (results_.size() < kRobots) {
      REQUIRE(now_ < 3600 * kSecond);
      turn();
    }
    return results_;
  }
  Utime now() const { return now_; }

 private:
  void turn() {
    now_ += 20'000;
    for (int robot = 0; robot < kRobots; ++robot) {
      if (deaf_.count(robot) > 0) continue;
      agents_[robot].tick(now_);
      work(robot);
    }
    network_.deliver_until(
        now_, [&](int to, int, const AgentMessage& message, Utime) { inboxes_[to].push_back(message); });
    for (int robot = 0; robot < kRobots; ++robot) {
      if (deaf_.count(robot) > 0) continue;
      for (const AgentMessage& message : std::exchange(inboxes_[robot], {})) {
        agents_[robot].receive(message, now_);
        work(robot);
      }
    }
  }
  void spend(int robot, Utime time) {
    deaf_.insert(robot);
    for (const Utime end = now_ + time; now_ < end;) turn();
    deaf_.erase(robot);
    agents_[robot].say_presence(now_);
    send(robot);
  }
  void work(int robot) {
    do {
      send(robot);
      if (auto result = agents_[robot].take_result()) results_[robot] = std::move(*result);
    } while (agents_[robot].advance(now_));
  }
  void send(int robot) {
    for (const AgentMessage& message : agents_[robot].take_outgoing())
      network_.send(robot, kEveryone, message, now_);
  }

  SimNetwork<AgentMessage> network_;
  Utime now_ = 0;
  std::vector<DgncAgent> agents_;
  std::set<int> deaf_;
  std::map<int, std::vector<AgentMessage>> inboxes_;
  std::map<int, RoundResult> results_;
};

std::map<int, RoundResult> solve(const AgentOptions& options, LinkFaults faults, std::uint64_t seed) {
  return Team(std::vector<AgentOptions>(kRobots, options), faults, seed).solve();
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

TEST_CASE("elected: the others wait for who solves, however long it takes") {
  Team slow(std::vector<AgentOptions>(kRobots, elected()), {.loss = 0.2, .delay_us = 100'000}, 2, kSecond);
  require_identical(solve(elected(), {}, 1), slow.solve());
  REQUIRE(slow.now() >
          45 * kSecond);  // many times what a robot may be silent, and more than a round may stand still
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
  std::vector<AgentOptions> options(kRobots, elected());
  options[2].dgnc.solver = RoundSolver::kDgnc;
  const auto results = Team(options, {.loss = 0.2, .delay_us = 30'000}, 1).solve();
  REQUIRE(results.at(0).robots == std::vector<int>{0, 1});
  REQUIRE(results.at(2).robots == std::vector<int>{2});
  const auto& warnings = results.at(0).warnings;
  REQUIRE(std::any_of(warnings.begin(), warnings.end(), [](const std::string& warning) {
    return warning.find("robot 2's section dpgo differs") != std::string::npos;
  }));
}

}  // namespace
}  // namespace covey::pgo
