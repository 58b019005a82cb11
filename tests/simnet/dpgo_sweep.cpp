// SPDX-License-Identifier: BSD-3-Clause
#include "tests/simnet/dpgo_sweep.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <set>
#include <vector>

#include "core/pgo/solve_distributed.h"
#include "core/sim/grid.h"
#include "tests/simnet/dpgo_team.h"
#include "tests/simnet/seeds.h"

namespace covey::pgo {
namespace {

constexpr int kKeyframes = 24;
constexpr int kWorlds = 5;
constexpr Utime kLimit = 3000 * kSecond;
constexpr int kMostLooks = 15;         // a second each, at who is named as apart
constexpr Utime kQuiet = 8 * kSecond;  // longer than it takes to notice that a robot is away
constexpr double kCostError = 1e-3;
constexpr double kFarM = 0.5;
constexpr double kTurnedRad = 0.1;

using Robots = std::set<int>;

// A world, and what a lossless run makes of it with some of its robots.
class World {
 public:
  World(int robots, int number)
      : graph_(sim::make_grid({.robots = robots,
                               .keyframes = kKeyframes,
                               .seed = static_cast<std::uint64_t>(number),
                               .false_share = 0.2,
                               .min_links = 4})
                   .graph) {}

  const PoseGraph& graph() const { return graph_; }

  const DistributedResult& lossless(const Robots& robots) {
    const auto known = lossless_.find(robots);
    if (known != lossless_.end()) return known->second;
    return lossless_[robots] = solve_distributed(among(robots));
  }

  // Of all parts into which closures, or their want, divide these robots.
  double lossless_cost(const Robots& robots) {
    double cost = 0.0;
    for (Robots rest = robots; !rest.empty();) {
      const Robots part = connected(*rest.begin(), rest);
      cost += lossless(part).cost;
      for (const int robot : part) rest.erase(robot);
    }
    return cost;
  }

  // The robots that closures connect with `robot`, among these.
  Robots connected(int robot, const Robots& among) const {
    Robots part{robot};
    for (bool grown = true; grown;) {
      grown = false;
      for (const Edge& edge : graph_.edges) {
        if (among.count(edge.from.robot) == 0 || among.count(edge.to.robot) == 0) continue;
        if (part.count(edge.from.robot) == part.count(edge.to.robot)) continue;
        part.insert({edge.from.robot, edge.to.robot});
        grown = true;
      }
    }
    return part;
  }

  static World& of(int robots, int number) {
    static std::map<std::pair<int, int>, World> worlds;
    const auto known = worlds.find({robots, number});
    if (known != worlds.end()) return known->second;
    return worlds.emplace(std::pair(robots, number), World(robots, number)).first->second;
  }

 private:
  PoseGraph among(const Robots& robots) const {
    PoseGraph graph = graph_;
    for (int robot = 0; robot < graph.robots(); ++robot) {
      if (robots.count(robot) == 0) graph.poses_per_robot[robot] = 0;
    }
    graph.edges.erase(std::remove_if(graph.edges.begin(), graph.edges.end(),
                                     [&](const Edge& edge) {
                                       return robots.count(edge.from.robot) == 0 ||
                                              robots.count(edge.to.robot) == 0;
                                     }),
                      graph.edges.end());
    return graph;
  }

  PoseGraph graph_;
  std::map<Robots, DistributedResult> lossless_;
};

// Which robots hear each other: links that are there, less the partitions that are on.
class Links {
 public:
  Links(int robots, SeededRandom& random) : robots_(robots) {
    const int kind = random.below(5);
    if (kind < 2) {
      for (int a = 0; a < robots; ++a) {
        for (int b = a + 1; b < robots; ++b) links_.insert({a, b});
      }
      name_ = "all hear all";
      return;
    }
    std::vector<int> order(robots);
    std::iota(order.begin(), order.end(), 0);
    for (int k = robots - 1; k > 0; --k) std::swap(order[k], order[random.below(k + 1)]);
    name_ = kind < 4 ? "chain" : "tree";
    for (int k = 1; k < robots; ++k) {
      const int before = order[kind < 4 ? k - 1 : random.below(k)];
      links_.insert(std::minmax(order[k], before));
      name_ += fmt::format(" {}-{}", before, order[k]);
    }
  }

  const std::string& name() const { return name_; }
  void part(const Robots& robots) { parted_ = robots; }
  void heal() { parted_.clear(); }
  bool joined(int a, int b) const {
    return links_.count(std::minmax(a, b)) > 0 && parted_.count(a) == parted_.count(b);
  }
  void apply(SimNetwork<AgentMessage>& network) const {
    network.heal();
    for (int a = 0; a < robots_; ++a) {
      for (int b = a + 1; b < robots_; ++b) {
        if (!joined(a, b)) network.cut(a, b);
      }
    }
  }
  // The robots that links join with `robot`, among these.
  Robots reached(int robot, const Robots& among) const {
    Robots part{robot};
    for (bool grown = true; grown;) {
      grown = false;
      for (const int a : Robots(part)) {
        for (const int b : among) {
          if (joined(a, b)) grown = part.insert(b).second || grown;
        }
      }
    }
    return part;
  }

 private:
  int robots_;
  std::string name_;
  std::set<std::pair<int, int>> links_;
  Robots parted_;
};

struct Event {
  double at_s;
  std::string word;
  std::function<void()> act;
};

class Run {
 public:
  explicit Run(std::uint64_t seed)
      : random_(seed),
        robots_(random_.chance(0.7) ? 3 : 4),
        world_(World::of(robots_, 1 + random_.below(kWorlds))),
        links_(robots_, random_),
        faults_(draw_faults()),
        team_(world_.graph(), faults_, seed) {
    team_.on_result = [this](int robot, const RoundResult& result) {
      frames_[result.frame][robot] = result;
      rounds_ = std::max(rounds_, static_cast<int>(result.name.number));
    };
    links_.apply(team_.network());
    draw_events();
  }

  SweepRun operator()() {
    SweepRun run;
    run.story = fmt::format("{} robots, {}, loss {:.2f}, delay {:.2f} + {:.2f} s, doubles {:.2f}", robots_,
                            links_.name(), faults_.loss, to_seconds(faults_.delay_us),
                            to_seconds(faults_.jitter_us), faults_.duplicate);
    for (const Event& event : events_) {
      run.story += fmt::format("; {:.1f} s {}", event.at_s, event.word);
      team_.run_until(from_seconds(event.at_s));
      event.act();
    }
    const bool quiet = run_until_quiet();
    run.seconds = to_seconds(team_.now());
    run.rounds = rounds_;
    const auto relayed = team_.said().find("dpgo_relay_t");
    run.relayed = relayed == team_.said().end() ? 0 : relayed->second;
    run.failure = quiet ? wrong_end(run) : "no end: " + where_it_stands();
    for (int looks = 1; quiet && run.failure.empty(); ++looks) {
      run.failure = wrong_names(run);
      if (run.failure.empty() || looks == kMostLooks) break;
      run.failure.clear();
      team_.run_for(kSecond);
    }
    if (run.failure.empty()) run.failure = wrong_frame();
    return run;
  }

 private:
  LinkFaults draw_faults() {
    return {.loss = random_.uniform(0.0, 0.4),
            .delay_us = from_seconds(random_.uniform(0.0, 0.5)),
            .jitter_us = from_seconds(random_.uniform(0.0, 0.5)),
            .duplicate = random_.uniform(0.0, 0.3)};
  }

  void draw_events() {
    const bool in_parts = random_.chance(0.4);
    share_ = in_parts ? 0.7 : 1.0;
    add(0.0, in_parts ? "first keyframes" : "all keyframes", [this] { feed_all(); });
    if (in_parts) {
      add(random_.uniform(5.0, 60.0), "the other keyframes", [this] {
        share_ = 1.0;
        feed_all();
      });
    }
    if (random_.chance(0.4)) draw_partition(random_.uniform(0.0, 50.0), random_.chance(0.7));
    if (random_.chance(0.5)) draw_restart();
    std::stable_sort(events_.begin(), events_.end(),
                     [](const Event& a, const Event& b) { return a.at_s < b.at_s; });
  }
  void draw_partition(double at_s, bool heals) {
    Robots part;
    for (int robot = 0; robot < robots_; ++robot) {
      if (random_.chance(0.5)) part.insert(robot);
    }
    if (part.empty()) part.insert(random_.below(robots_));
    add(at_s, fmt::format("{} parted", fmt::join(part, " ")), [this, part] {
      links_.part(part);
      links_.apply(team_.network());
    });
    if (!heals) return;
    add(at_s + random_.uniform(1.0, 60.0), "healed", [this] {
      links_.heal();
      links_.apply(team_.network());
    });
  }
  void draw_restart() {
    const int robot = random_.below(robots_);
    const double at_s = random_.uniform(1.0, 60.0);
    if (random_.chance(0.2)) {
      add(at_s, fmt::format("{} killed", robot), [this, robot] { team_.stop(robot); });
      return;
    }
    const bool with_state = random_.chance(0.5);
    add(at_s, fmt::format("{} restarted {} state", robot, with_state ? "with" : "without"),
        [this, robot, with_state] {
          team_.restart(robot, with_state);
          team_.feed(robot, share_);
        });
  }
  void add(double at_s, std::string word, std::function<void()> act) {
    events_.push_back({at_s, std::move(word), std::move(act)});
  }
  void feed_all() {
    for (const int robot : team_.running()) team_.feed(robot, share_);
  }

  // Until all have been solved, each with those that it can reach, for as long as it takes to notice anything.
  bool run_until_quiet() {
    const Utime end = team_.now() + kLimit;
    Utime quiet_since = team_.now();
    while (team_.now() < end) {
      team_.run_for(kSecond);
      const Robots running = team_.running();
      const bool solved = std::all_of(running.begin(), running.end(), [&](int robot) {
        return team_.solved(links_.reached(robot, running));
      });
      if (!solved) quiet_since = team_.now();
      if (team_.now() - quiet_since >= kQuiet) return true;
    }
    return false;
  }

  std::string wrong_end(SweepRun& run) {
    for (const int robot : team_.running()) {
      const Robots reached = links_.reached(robot, team_.running());
      const Robots expected = world_.connected(robot, reached);
      const RoundResult& result = team_.results().at(robot);
      const Robots together(result.robots.begin(), result.robots.end());
      // At least with whom closures connect it; with others by an earlier solution, also with those that have left since.
      if (!std::includes(together.begin(), together.end(), expected.begin(), expected.end())) {
        return fmt::format("robot {} is solved with {}, not with {}", robot, fmt::join(together, " "),
                           fmt::join(expected, " "));
      }
      if (auto failure = wrong_cost(result, together, run); !failure.empty()) return failure;
    }
    return "";
  }
  std::string wrong_cost(const RoundResult& result, const Robots& together, SweepRun& run) {
    double cost = 0.0;
    for (const int robot : together) {
      const auto& ended = frames_.at(result.frame);
      if (ended.count(robot) == 0) return "";  // it has gone with its part of the cost
      cost += ended.at(robot).owned_cost;
    }
    const double expected = world_.lossless_cost(together);
    const double error = std::abs(cost - expected) / std::max(expected, 1.0);  // alone without closures: 0
    run.cost_error = std::max(run.cost_error, error);
    if (error <= kCostError) return "";
    return fmt::format("robots {} end at cost {:.6g}, without loss at {:.6g}", fmt::join(together, " "), cost,
                       expected);
  }
  // To be asked again: over two hops of a chain that loses two messages of five, five seconds are silent now and then.
  std::string wrong_names(SweepRun& run) {
    for (const int robot : team_.running()) {
      const RoundResult& result = team_.results().at(robot);
      const Robots together(result.robots.begin(), result.robots.end());
      const Robots reached = links_.reached(robot, team_.running());
      if (auto failure = wrong_names(robot, reached, together, run); !failure.empty()) return failure;
    }
    return "";
  }
  std::string wrong_names(int robot, const Robots& reached, const Robots& together, SweepRun& run) {
    const DgncAgent& agent = team_.agent(robot);
    Robots named;
    for (const ApartRobot& apart : agent.apart(team_.now())) named.insert(apart.robot);
    for (const auto& [other, peer] : agent.presence().peers()) {
      const bool apart = reached.count(other) == 0 || together.count(other) == 0;
      run.parted = run.parted || apart;
      if (apart != (named.count(other) > 0)) {
        return fmt::format("robot {} {} robot {} as apart", robot, apart ? "does not name" : "names", other);
      }
    }
    return "";
  }

  // All that was ever published in one frame, of all that the front ends have given.
  std::string wrong_frame() {
    for (const auto& [frame, results] : frames_) {
      if (!complete(results)) continue;
      for (const auto& [robot, result] : results) {
        const Robots together(result.robots.begin(), result.robots.end());
        // Others are where an earlier round has put them.
        if (world_.connected(*together.begin(), together).count(robot) == 0) continue;
        const Poses& poses = world_.lossless(together).poses;
        const auto before = std::distance(together.begin(), together.find(robot)) * kKeyframes;
        for (int k = 0; k < kKeyframes; ++k) {
          const SE3 error = poses[before + k].inverse() * result.segments.at(0).T_W_K[k];
          if (error.translation.norm() > kFarM || error.rotation.log().norm() > kTurnedRad) {
            return fmt::format("round {}: keyframe {} of robot {} is off by {:.2f} m, {:.2f} rad",
                               result.name.number, k, robot, error.translation.norm(),
                               error.rotation.log().norm());
          }
        }
      }
    }
    return "";
  }
  static bool complete(const std::map<int, RoundResult>& results) {
    const std::size_t robots = results.begin()->second.robots.size();
    return results.size() == robots && std::all_of(results.begin(), results.end(), [](const auto& of) {
             return of.second.keyframes == kKeyframes;
           });
  }

  std::string where_it_stands() {
    std::string words;
    for (const int robot : team_.running()) {
      const DgncAgent& agent = team_.agent(robot);
      const DgncRound* round = agent.round();
      words +=
          fmt::format(" robot {}: phase {}, round {} by {} at message {}, waits for {};", robot,
                      static_cast<int>(agent.phase()), round == nullptr ? 0 : round->name().number,
                      round == nullptr ? 0 : round->name().anchor, round == nullptr ? 0 : round->number(),
                      fmt::join(round == nullptr ? std::vector<int>{} : round->missing(), " "));
    }
    for (const auto& [reason, count] : team_.refused()) words += fmt::format(" {} {},", count, reason);
    return words;
  }

  SeededRandom random_;
  int robots_;
  World& world_;
  Links links_;
  LinkFaults faults_;
  Team team_;
  std::vector<Event> events_;
  double share_ = 1.0;
  std::map<std::int64_t, std::map<int, RoundResult>> frames_;  // every result, by the frame's name
  int rounds_ = 0;
};

}  // namespace

SweepRun run_seed(std::uint64_t seed) { return Run(seed)(); }

}  // namespace covey::pgo
