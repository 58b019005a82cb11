// SPDX-License-Identifier: BSD-3-Clause
#include "tests/simnet/dpgo_team.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <utility>

#include "core/sim/grid.h"

namespace covey::pgo {
namespace {

constexpr Utime kStepUs = 20'000;

}  // namespace

const PoseGraph& small_graph() {
  static const sim::GridWorld kWorld =
      sim::make_grid({.robots = 3, .keyframes = 40, .seed = 4, .min_links = 4});
  return kWorld.graph;
}

Matrix6d isotropic(double kappa, double tau) {
  Vector6d variances;
  variances << Eigen::Vector3d::Constant(1.0 / tau), Eigen::Vector3d::Constant(0.5 / kappa);
  return variances.asDiagonal();
}

Team::Team(const PoseGraph& graph, LinkFaults faults, std::uint64_t seed, Utime settle_us)
    : graph_(graph), network_(seed, faults, graph.robots()), segments_(graph.robots(), 1) {
  options_.settle_us = settle_us;
  options_.request_us = kSecond / 2;
  for (int robot = 0; robot < graph.robots(); ++robot) start(robot);
}

void Team::start(int robot, const DgncOptions& dgnc) {
  AgentOptions options = options_;
  options.dgnc = dgnc;
  agents_[robot] = std::make_unique<DgncAgent>(robot, now_ + 1, options);
  results_.erase(robot);
}

void Team::restart(int robot, bool with_state) {
  const Solution solution = agents_.at(robot)->solution();
  network_.restart(robot);
  const auto result = results_.find(robot);
  const std::optional<RoundResult> last =
      result == results_.end() ? std::nullopt : std::optional(result->second);
  start(robot);
  if (!with_state || solution.round.number == 0) return;
  agents_.at(robot)->restore(solution);
  if (last) results_.emplace(robot, *last);
}

void Team::feed(int robot, double share) {
  DgncAgent& agent = *agents_.at(robot);
  std::vector<Keyframe> keyframes(1);
  keyframes.front().T_O_K.translation.x() = 100.0 * static_cast<double>(segments_[robot] - 1);
  for (const Edge& edge : graph_.edges) {
    if (edge.kind != EdgeKind::kOdometry || edge.from.robot != robot) continue;
    Keyframe keyframe{{robot, segments_[robot], edge.to.index},
                      kSecond * edge.to.index,
                      {},
                      edge.measurement,
                      isotropic(edge.kappa, edge.tau)};
    keyframe.T_O_K = keyframes.back().T_O_K * edge.measurement;
    keyframes.push_back(keyframe);
  }
  keyframes.front().name = {robot, segments_[robot], 0};
  keyframes.resize(static_cast<std::size_t>(share * static_cast<double>(keyframes.size())));
  for (const Keyframe& keyframe : keyframes) agent.add(keyframe);
  for (const Edge& edge : graph_.edges) {
    if (edge.kind == EdgeKind::kOdometry || (edge.from.robot != robot && edge.to.robot != robot)) continue;
    agent.add(Loop{{edge.from.robot, segments_[edge.from.robot], edge.from.index},
                   {edge.to.robot, segments_[edge.to.robot], edge.to.index},
                   edge.measurement,
                   isotropic(edge.kappa, edge.tau)});
  }
}

void Team::run_until(Utime end) {
  for (; now_ < end; now_ += kStepUs) {
    network_.deliver_until(now_, [&](int to, int, const AgentMessage& message, Utime t) {
      if (agents_.count(to) == 0) return;
      if (on_message) on_message(to, message, t);
      const char* reason = agents_.at(to)->receive(message, t - behind_[to]);
      if (reason != nullptr) ++refused_[reason];
      work(to, t - behind_[to]);
    });
    for (const auto& [robot, agent] : agents_) {
      agent->tick(now_ - behind_[robot]);
      work(robot, now_ - behind_[robot]);
    }
  }
}

bool Team::run_until_solved(Utime limit) { return run_until_solved(running(), limit); }

bool Team::run_until_solved(const std::set<int>& robots, Utime limit) {
  const Utime end = now_ + limit;
  while (now_ < end) {
    run_for(kSecond);
    if (solved(robots)) return true;
  }
  return false;
}

bool Team::solved(const std::set<int>& robots) const {
  return std::all_of(robots.begin(), robots.end(), [&](int robot) {
    return agents_.at(robot)->phase() == AgentPhase::kIdle && results_.count(robot) > 0 &&
           results_.at(robot).name == results_.at(*robots.begin()).name;
  });
}

double Team::cost() const {
  double cost = 0.0;
  for (const auto& [robot, result] : results_) cost += result.owned_cost;
  return cost;
}

std::set<int> Team::running() const {
  std::set<int> robots;
  for (const auto& [robot, agent] : agents_) robots.insert(robot);
  return robots;
}

void Team::work(int robot, Utime now) {
  DgncAgent& agent = *agents_.at(robot);
  do {
    for (const AgentMessage& message : agent.take_outgoing()) {
      const auto instead = damage ? damage(robot, message) : std::nullopt;
      ++said_[type_of(message)];
      network_.send(robot, kEveryone, instead ? *instead : message, now + behind_[robot]);
    }
    if (auto result = agent.take_result()) {
      if (on_result) on_result(robot, *result);
      results_[robot] = std::move(*result);
    }
  } while (agent.advance(now));
}

void run_into_a_round(Team& team, int robot) {
  while (team.agent(robot).round() == nullptr || team.agent(robot).round()->updates() < 10) {
    team.run_for(20'000);
    REQUIRE(team.now() < 300 * kSecond);
  }
}

}  // namespace covey::pgo
