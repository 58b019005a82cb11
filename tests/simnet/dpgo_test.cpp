// SPDX-License-Identifier: BSD-3-Clause
// Distributed optimisation on a network that loses, delays, doubles and disorders: the result is that of the perfect
// network, to the last bit; and after partitions and restarts everybody still ends in one frame at the same optimum.

#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <random>
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

// The agents of a pose graph's robots, and the air between them, in virtual time.
class Team {
 public:
  Team(const PoseGraph& graph, LinkFaults faults, std::uint64_t seed = 1, Utime settle_us = kSecond)
      : graph_(graph), network_(seed, faults, graph.robots()), segments_(graph.robots(), 1) {
    options_.settle_us = settle_us;
    options_.request_us = kSecond / 2;
    for (int robot = 0; robot < graph.robots(); ++robot) start(robot);
  }

  void start(int robot) { start(robot, options_.dgnc); }
  void start(int robot, const DgncOptions& dgnc) {
    AgentOptions options = options_;
    options.dgnc = dgnc;
    agents_[robot] = std::make_unique<DgncAgent>(robot, now_ + 1, options);
    results_.erase(robot);
  }
  void stop(int robot) { agents_.erase(robot); }
  // What is fed of it from here on has another odometry frame, 100 m off.
  void restart_odometry(int robot) { ++segments_[robot]; }
  void set_back_clock(int robot, Utime by) { behind_[robot] += by; }

  // What is sent in place of a robot's message; none: the message.
  std::function<std::optional<AgentMessage>(int from, const AgentMessage& message)> damage;

  void feed_all() {
    for (const auto& [robot, agent] : agents_) feed(robot);
  }

  // What the robot's front end gave; the share of its keyframes and of the loops among these.
  void feed(int robot, double share = 1.0) {
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

  void run_until(Utime end) {
    for (; now_ < end; now_ += 20'000) {
      network_.deliver_until(now_, [&](int to, int, const AgentMessage& message, Utime t) {
        if (agents_.count(to) == 0) return;
        agents_.at(to)->receive(message, t - behind_[to]);
        work(to, t - behind_[to]);
      });
      for (const auto& [robot, agent] : agents_) {
        agent->tick(now_ - behind_[robot]);
        work(robot, now_ - behind_[robot]);
      }
    }
  }
  void run_for(Utime duration) { run_until(now_ + duration); }

  // Until all agents are idle in one round; false after `limit`.
  bool run_until_solved(Utime limit) {
    const Utime end = now_ + limit;
    while (now_ < end) {
      run_for(kSecond);
      if (solved()) return true;
    }
    return false;
  }
  bool solved() const {
    for (const auto& [robot, agent] : agents_) {
      if (agent->phase() != AgentPhase::kIdle || results_.count(robot) == 0) return false;
      if (results_.at(robot).name != results_.begin()->second.name) return false;
    }
    return true;
  }

  double cost() const {
    double cost = 0.0;
    for (const auto& [robot, result] : results_) cost += result.owned_cost;
    return cost;
  }

  Utime now() const { return now_; }
  SimNetwork<AgentMessage>& network() { return network_; }
  DgncAgent& agent(int robot) { return *agents_.at(robot); }
  const std::map<int, RoundResult>& results() const { return results_; }

 private:
  void work(int robot, Utime now) {
    DgncAgent& agent = *agents_.at(robot);
    do {
      for (const AgentMessage& message : agent.take_outgoing()) {
        const auto instead = damage ? damage(robot, message) : std::nullopt;
        network_.send(robot, kEveryone, instead ? *instead : message, now + behind_[robot]);
      }
      if (auto result = agent.take_result()) results_[robot] = std::move(*result);
    } while (agent.advance(now));
  }

  PoseGraph graph_;
  AgentOptions options_;
  SimNetwork<AgentMessage> network_;
  Utime now_ = 0;
  std::map<int, std::unique_ptr<DgncAgent>> agents_;
  std::vector<Utime> segments_;  // of each robot, the one that is fed
  std::map<int, Utime> behind_;  // what an agent's clock lacks
  std::map<int, RoundResult> results_;
};

void require_identical(const std::map<int, RoundResult>& a, const std::map<int, RoundResult>& b) {
  REQUIRE(a.size() == b.size());
  for (const auto& [robot, result] : a) {
    const RoundResult& other = b.at(robot);
    REQUIRE(result.updates == other.updates);
    REQUIRE(result.segments.size() == other.segments.size());
    for (std::size_t s = 0; s < result.segments.size(); ++s) {
      REQUIRE(result.segments[s].T_W_K.size() == other.segments[s].T_W_K.size());
      for (std::size_t k = 0; k < result.segments[s].T_W_K.size(); ++k) {
        const SE3& T = result.segments[s].T_W_K[k];
        const SE3& U = other.segments[s].T_W_K[k];
        REQUIRE(T.translation == U.translation);
        REQUIRE(T.rotation.quaternion().coeffs() == U.rotation.quaternion().coeffs());
      }
    }
    REQUIRE(result.owned_cost == other.owned_cost);
  }
}

std::map<int, RoundResult> solve(LinkFaults faults, std::uint64_t seed) {
  // Settles long enough for everybody to hear of everybody, so that there is one round.
  Team team(small_world().graph, faults, seed, 8 * kSecond);
  team.feed_all();
  REQUIRE(team.run_until_solved(600 * kSecond));
  REQUIRE(team.results().at(0).name.number == 1);
  return team.results();
}

TEST_CASE("loss, delay, doubles and disorder change nothing in the result") {
  const auto perfect = solve({}, 1);
  require_identical(perfect, solve({.loss = 0.2, .delay_us = 100'000}, 2));
  require_identical(perfect,
                    solve({.loss = 0.4, .delay_us = 50'000, .jitter_us = 400'000, .duplicate = 0.3}, 3));
}

TEST_CASE("agents reach what the solver without a network reaches") {
  const sim::GridWorld world = small_world();
  const DistributedResult direct = solve_distributed(world.graph);
  const auto over_the_air = solve({}, 1);
  double cost = 0.0;
  int kept = 0;
  for (const auto& [robot, result] : over_the_air) {
    cost += result.owned_cost;
    kept += result.owned_kept;
  }
  REQUIRE(cost == Approx(direct.cost).epsilon(1e-6));
  REQUIRE(kept == direct.kept);
}

TEST_CASE("parted teams solve apart, and together when they meet") {
  Team team(small_world().graph, {.loss = 0.1, .delay_us = 30'000});
  team.network().isolate(2);
  team.feed_all();
  team.run_for(60 * kSecond);
  REQUIRE(team.results().at(0).robots == std::vector<int>{0, 1});
  REQUIRE(team.results().at(2).robots == std::vector<int>{2});
  team.network().heal();
  REQUIRE(team.run_until_solved(300 * kSecond));
  for (const auto& [robot, result] : team.results()) {
    REQUIRE(result.robots == std::vector<int>{0, 1, 2});
    REQUIRE(result.anchor == 0);
  }
  REQUIRE(team.cost() == Approx(solve_distributed(small_world().graph).cost).epsilon(1e-3));
}

// Runs until some robot is in the middle of its updates.
void run_into_a_round(Team& team, int robot) {
  while (team.agent(robot).round() == nullptr || team.agent(robot).round()->updates() < 10) {
    team.run_for(20'000);
    REQUIRE(team.now() < 300 * kSecond);
  }
}

TEST_CASE("a robot that is killed in a round and started anew takes part again") {
  for (const int victim : {0, 1, 2}) {
    Team team(small_world().graph, {.loss = 0.1, .delay_us = 30'000});
    team.feed_all();
    run_into_a_round(team, victim);
    team.stop(victim);
    team.network().restart(victim);
    team.run_for(kSecond);
    team.start(victim);
    team.feed(victim);
    REQUIRE(team.run_until_solved(300 * kSecond));
    REQUIRE(team.results().at(victim).robots == std::vector<int>{0, 1, 2});
    REQUIRE(team.cost() == Approx(solve_distributed(small_world().graph).cost).epsilon(1e-3));
  }
}

TEST_CASE("a robot that falls silent for good is left out, and the others finish") {
  Team team(small_world().graph, {.loss = 0.1, .delay_us = 30'000});
  team.feed_all();
  run_into_a_round(team, 0);
  team.stop(0);
  REQUIRE(team.run_until_solved(300 * kSecond));
  for (const int robot : {1, 2}) REQUIRE(team.results().at(robot).robots == std::vector<int>{1, 2});
  REQUIRE(team.results().at(1).anchor == 1);
}

// Runs until robot 0 has ended a round that robot 1 has not, for want of a message of robot `of` alone.
bool run_until_last_message_is_missing(Team& team, int of) {
  while (team.results().count(0) == 0) {
    team.run_for(20'000);
    REQUIRE(team.now() < 600 * kSecond);
  }
  return team.agent(1).phase() == AgentPhase::kRound &&
         team.agent(1).round()->name() == team.results().at(0).name &&
         team.agent(1).round()->missing() == std::vector<int>{of};
}

TEST_CASE("a robot that leaves with the last message of a round leaves nobody waiting for it") {
  int tried = 0;
  for (std::uint64_t seed = 1; tried < 3; ++seed) {
    REQUIRE(seed < 100);
    Team team(small_world().graph, {.loss = 0.4, .delay_us = 30'000}, seed, 8 * kSecond);
    team.feed_all();
    if (!run_until_last_message_is_missing(team, 2)) continue;
    team.stop(2);
    team.run_for(kSecond / 10);
    if (team.agent(1).phase() != AgentPhase::kRound) continue;  // it was in the air
    ++tried;
    team.network().set_faults({.delay_us = 30'000});  // else silence by chance would end it one day
    REQUIRE(team.run_until_solved(60 * kSecond));
    for (const int robot : {0, 1}) REQUIRE(team.results().at(robot).robots == std::vector<int>{0, 1});
  }
}

TEST_CASE("a robot that is restarted right after a round leaves nobody waiting for its end") {
  int tried = 0;
  for (std::uint64_t seed = 1; tried < 3; ++seed) {
    REQUIRE(seed < 100);
    Team team(small_world().graph, {.loss = 0.4, .delay_us = 30'000}, seed, 8 * kSecond);
    team.feed_all();
    if (!run_until_last_message_is_missing(team, 0)) continue;
    const Solution solution = team.agent(0).solution();
    team.stop(0);
    team.run_for(kSecond / 10);
    if (team.agent(1).phase() != AgentPhase::kRound) continue;  // it was in the air
    ++tried;
    team.network().set_faults({.delay_us = 30'000});  // else silence by chance would end it one day
    team.start(0);
    team.feed(0);
    team.agent(0).restore(solution);
    REQUIRE(team.run_until_solved(60 * kSecond));
    REQUIRE(team.results().at(0).name.number > solution.round.number);
    REQUIRE(team.results().at(0).robots == std::vector<int>{0, 1, 2});
  }
}

TEST_CASE("a clock that is set back holds nobody up") {
  for (const int robot : {0, 1, 2}) {
    Team team(small_world().graph, {.loss = 0.1, .delay_us = 30'000});
    team.run_for(150 * kSecond);
    team.feed_all();
    run_into_a_round(team, robot);
    team.set_back_clock(robot, 150 * kSecond);
    REQUIRE(team.run_until_solved(60 * kSecond));
    for (const auto& [member, result] : team.results()) REQUIRE(result.robots == std::vector<int>{0, 1, 2});
    const std::int64_t round = team.results().at(0).name.number;
    team.run_for(20 * kSecond);
    REQUIRE(team.results().at(0).name.number == round);
  }
}

TEST_CASE("a robot without keyframes has nothing to wait for") {
  Team team(small_world().graph, {});
  team.feed(0);
  team.feed(1);
  team.run_for(30 * kSecond);
  REQUIRE(team.agent(2).phase() == AgentPhase::kIdle);
  REQUIRE(team.results().at(0).robots == std::vector<int>{0, 1});
}

TEST_CASE("round numbers at the end of their range are refused and never count over") {
  DgncAgent agent(0, 1, {});
  dpgo_beacon_t beacon{};
  beacon.from = 1;
  beacon.round = std::numeric_limits<std::int64_t>::max();
  REQUIRE(agent.receive(beacon, 0) == std::string("values"));
}

TEST_CASE("new keyframes and loops open a new round that goes on from the last one") {
  Team team(small_world().graph, {.loss = 0.1, .delay_us = 30'000});
  for (const int robot : {0, 1, 2}) team.feed(robot, 0.7);
  REQUIRE(team.run_until_solved(300 * kSecond));
  const std::int64_t first = team.results().at(0).name.number;
  for (const int robot : {0, 1, 2}) team.feed(robot);
  REQUIRE(team.run_until_solved(300 * kSecond));
  REQUIRE(team.results().at(0).name.number > first);
  REQUIRE(team.results().at(0).keyframes == 40);
  REQUIRE(team.cost() == Approx(solve_distributed(small_world().graph).cost).epsilon(1e-3));
}

TEST_CASE("a solution read back after a restart spares the round when nothing is new") {
  Team team(small_world().graph, {});
  team.feed_all();
  REQUIRE(team.run_until_solved(100 * kSecond));
  const Solution solution = team.agent(1).solution();
  const std::int64_t round = solution.round.number;
  team.stop(1);
  team.network().restart(1);
  team.start(1);
  team.feed(1);
  team.agent(1).restore(solution);
  team.run_for(30 * kSecond);
  REQUIRE(team.agent(0).solution().round.number == round);
  REQUIRE(team.agent(1).phase() == AgentPhase::kIdle);
}

TEST_CASE("rounds of one name before and after a restart without memory leave frames of two names") {
  Team team(small_world().graph, {}, 1, 8 * kSecond);
  team.feed_all();
  REQUIRE(team.run_until_solved(100 * kSecond));
  team.network().isolate(2);
  for (const int robot : {0, 1}) {
    team.stop(robot);
    team.restart_odometry(robot);
  }
  for (const int robot : {0, 1}) {
    team.start(robot);
    team.feed(robot);
  }
  team.run_for(60 * kSecond);
  REQUIRE(team.agent(0).solution().round == team.agent(2).solution().round);
  REQUIRE(team.agent(0).solution().frame != team.agent(2).solution().frame);
  team.network().heal();
  team.feed(2);
  REQUIRE(team.run_until_solved(100 * kSecond));
  REQUIRE(team.results().at(2).robots == std::vector<int>{0, 1, 2});
  REQUIRE(team.cost() == Approx(solve_distributed(small_world().graph).cost).epsilon(1e-3));
}

TEST_CASE("what only one robot knows of two is left out, and said") {
  Team team(small_world().graph, {.loss = 0.1, .delay_us = 30'000});
  team.feed_all();
  REQUIRE(team.agent(0).add(Loop{{0, 1, 3}, {1, 1, 5}, {}, isotropic(100.0, 100.0)}) == nullptr);
  REQUIRE(team.run_until_solved(300 * kSecond));
  const auto& warnings = team.results().at(0).warnings;
  REQUIRE(std::any_of(warnings.begin(), warnings.end(), [](const std::string& warning) {
    return warning.find("robots 0-1 are left out: robot 1 does not know them") != std::string::npos;
  }));
  REQUIRE(team.cost() == Approx(solve_distributed(small_world().graph).cost).epsilon(1e-6));
}

bool warns_of(const RoundResult& result, int robot) {
  const std::string words = "robot " + std::to_string(robot) + "'s section dpgo differs";
  return std::any_of(result.warnings.begin(), result.warnings.end(),
                     [&](const std::string& warning) { return warning.find(words) != std::string::npos; });
}

TEST_CASE("robots with other options solve apart, hold nobody up, and are named") {
  const auto changed = [](auto change) {
    DgncOptions options;
    change(options);
    return options;
  };
  for (const DgncOptions& other :
       {changed([](DgncOptions& o) { o.mu_step = 1.4; }), changed([](DgncOptions& o) { o.updates = 3; }),
        changed([](DgncOptions& o) { o.barc2 = 100.0; }), changed([](DgncOptions& o) { o.tolerance = 1e-2; }),
        changed([](DgncOptions& o) { o.rounds = 8; }), changed([](DgncOptions& o) { o.look_back = 0; })}) {
    for (const int odd : {0, 1}) {
      Team team(small_world().graph, {.loss = 0.3, .delay_us = 30'000}, 1, 8 * kSecond);
      team.start(odd, other);
      team.feed_all();
      REQUIRE(team.run_until_solved(100 * kSecond));
      REQUIRE(team.results().at(0).name.number == 1);
      for (const auto& [robot, result] : team.results()) {
        for (const int member : {0, 1, 2}) {
          const bool together = (robot == odd) == (member == odd);
          REQUIRE(warns_of(result, member) != together);
          REQUIRE(together == std::binary_search(result.robots.begin(), result.robots.end(), member));
        }
      }
      team.run_for(60 * kSecond);
      REQUIRE(team.results().at(0).name.number == 1);
    }
  }
}

TEST_CASE("options that only one robot works with need not be the same") {
  DgncOptions options;
  options.alignment.translation_sigma = 0.4;
  options.block.max_inner = 5;
  REQUIRE(common_hash(options) == common_hash({}));
}

// Values that a correct member would not send, in messages that decode.
class Vandal {
 public:
  explicit Vandal(std::uint64_t seed) : random_(seed) {}

  AgentMessage operator()(dpgo_beacon_t m) {
    return hit({[&] { m.keyframes = whole(); }, [&] { m.graph = whole(); },
                [&] { m.start_utime = whole(); }}),
           m;
  }
  AgentMessage operator()(dpgo_round_t m) {
    return hit({[&] { scratch(m.members); }, [&] { scratch(m.start_utimes); }, [&] { m.round = whole(); }}),
           m;
  }
  AgentMessage operator()(dpgo_request_t m) {
    return hit({[&] { m.number = whole(); }, [&] { scratch(m.robots); }}), m;
  }
  AgentMessage operator()(dpgo_join_t m) {
    hit({[&] { scratch(m.segments); }, [&] { scratch(m.solutions); }, [&] { scratch(m.T_O_K); },
         [&] { m.mu = real(); }, [&] { scratch(m.peers); }, [&] { scratch(m.hashes); },
         [&] { m.number = whole(); }});
    return m;
  }
  AgentMessage operator()(dpgo_keys_t m) {
    return hit({[&] { scratch(m.peers); }, [&] { scratch(m.keys); }}), m;
  }
  AgentMessage operator()(dpgo_start_t m) {
    hit({[&] { scratch(m.segments); }, [&] { scratch(m.ids); }, [&] { scratch(m.T_S_K); },
         [&] { m.number = whole(); }});
    return m;
  }
  AgentMessage operator()(dpgo_alignment_t m) {
    hit({[&] { scratch(m.segments_a); }, [&] { scratch(m.robots_b); }, [&] { scratch(m.segments_b); },
         [&] { scratch(m.inliers); }, [&] { scratch(m.T_A_B); }});
    return m;
  }
  AgentMessage operator()(dpgo_step_t m) {
    hit({[&] { m.max_residual_sq = static_cast<float>(real()); },
         [&] { m.cost = static_cast<float>(real()); }, [&] { m.gradient_sq = static_cast<float>(real()); },
         [&] { m.undecided = whole(); }, [&] { scratch(m.products); },
         [&] { m.rotation_unit = static_cast<float>(real()); },
         [&] { m.translation_unit = static_cast<float>(real()); }, [&] { scratch(m.code); }});
    return m;
  }

  AgentMessage operator()(dpgo_graph_t m) {
    hit({[&] { scratch(m.poses); }, [&] { scratch(m.robots_b); }, [&] { scratch(m.segments_a); },
         [&] { scratch(m.sizes); }, [&] { scratch(m.ids_b); }, [&] { scratch(m.values); },
         [&] { scratch(m.precisions); }});
    return m;
  }
  AgentMessage operator()(dpgo_poses_t m) {
    hit({[&] { scratch(m.robots); }, [&] { scratch(m.anchors); }, [&] { scratch(m.anchor_segments); },
         [&] { scratch(m.poses); }, [&] { scratch(m.values); }, [&] { scratch(m.loops); },
         [&] { scratch(m.robots_b); }});
    return m;
  }

  bool strikes() { return random_() % 4 == 0; }

 private:
  void hit(const std::vector<std::function<void()>>& ways) { ways[random_() % ways.size()](); }
  int whole() {
    const int values[] = {-1, 0, 1, 2, 3, 1000, 1 << 30};
    return values[random_() % std::size(values)];
  }
  double real() {
    const double values[] = {-1.0, 0.0, 1e-300, 0.5, 1e9, 1e300, INFINITY, NAN};
    return values[random_() % std::size(values)];
  }
  template <typename T>
  void scratch(std::vector<T>& values) {
    if (values.empty()) return;
    T& value = values[random_() % values.size()];
    if constexpr (std::is_floating_point_v<T>) {
      value = static_cast<T>(real());
    } else {
      value = static_cast<T>(whole());
    }
  }
  std::mt19937_64 random_;
};

TEST_CASE("a member that sends nonsense ends nobody, and nothing infinite comes of it") {
  int results = 0;
  for (std::uint64_t seed = 0; seed < 12; ++seed) {
    Vandal vandal(seed);
    Team team(small_world().graph, {});
    team.feed_all();
    team.damage = [&](int from, const AgentMessage& message) -> std::optional<AgentMessage> {
      if (from != 2 || !vandal.strikes()) return std::nullopt;
      return std::visit(vandal, message);
    };
    team.run_for(40 * kSecond);
    results += static_cast<int>(team.results().size());
    for (const auto& [robot, result] : team.results()) {
      REQUIRE(std::isfinite(result.owned_cost));
      for (const SegmentResult& segment : result.segments) {
        for (const SE3& T : segment.T_W_K) REQUIRE(T.translation.allFinite());
      }
    }
  }
  REQUIRE(results > 0);
}

}  // namespace
}  // namespace covey::pgo
