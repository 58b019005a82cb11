// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The dpgo agents of a pose graph's robots, and the air between them, in virtual time.

#include <cmath>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "core/pgo/dgnc_agent.h"
#include "core/pgo/pose_graph.h"
#include "tests/simnet/network.h"

namespace covey::pgo {

inline constexpr Utime kSecond = kUsPerSecond;

// Three robots, 40 keyframes each, a third of the closures false.
const PoseGraph& small_graph();

Matrix6d isotropic(double kappa, double tau);

class Team {
 public:
  explicit Team(const PoseGraph& graph, LinkFaults faults = {}, std::uint64_t seed = 1,
                Utime settle_us = kSecond);

  void start(int robot) { start(robot, options_.dgnc); }
  void start(int robot, const DgncOptions& dgnc);
  void stop(int robot) { agents_.erase(robot); }
  // Anew, as a process that was killed; with what it had on disk, or without.
  void restart(int robot, bool with_state);
  // What is fed of it from here on has another odometry frame, 100 m off.
  void restart_odometry(int robot) { ++segments_[robot]; }
  void set_back_clock(int robot, Utime by) { behind_[robot] += by; }

  // What is sent in place of a robot's message; none: the message.
  std::function<std::optional<AgentMessage>(int from, const AgentMessage& message)> damage;
  // Each message as it arrives, and each result as it comes.
  std::function<void(int to, const AgentMessage& message, Utime now)> on_message;
  std::function<void(int robot, const RoundResult& result)> on_result;

  void feed_all() {
    for (const auto& [robot, agent] : agents_) feed(robot);
  }
  // What the robot's front end gave; the share of its keyframes and of the loops among these.
  void feed(int robot, double share = 1.0);

  void run_until(Utime end);
  void run_for(Utime duration) { run_until(now_ + duration); }
  // Until these are idle in one round; false after `limit`.
  bool run_until_solved(Utime limit);  // all that run
  bool run_until_solved(const std::set<int>& robots, Utime limit);
  bool solved(const std::set<int>& robots) const;

  double cost() const;
  Utime now() const { return now_; }
  SimNetwork<AgentMessage>& network() { return network_; }
  DgncAgent& agent(int robot) { return *agents_.at(robot); }
  std::set<int> running() const;
  const std::map<int, RoundResult>& results() const { return results_; }
  // Of messages that agents have refused, by reason; and of those said, by type.
  const std::map<std::string, int>& refused() const { return refused_; }
  const std::map<std::string, int>& said() const { return said_; }

 private:
  void work(int robot, Utime now);

  PoseGraph graph_;
  AgentOptions options_;
  SimNetwork<AgentMessage> network_;
  Utime now_ = 0;
  std::map<int, std::unique_ptr<DgncAgent>> agents_;
  std::vector<Utime> segments_;  // of each robot, the one that is fed
  std::map<int, Utime> behind_;  // what an agent's clock lacks
  std::map<int, RoundResult> results_;
  std::map<std::string, int> refused_;
  std::map<std::string, int> said_;
};

// Until some robot is in the middle of its updates.
void run_into_a_round(Team& team, int robot);

}  // namespace covey::pgo
