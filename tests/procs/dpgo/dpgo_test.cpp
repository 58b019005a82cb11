// SPDX-License-Identifier: BSD-3-Clause
// Real dpgo processes: a team over real multicast and a lossy radio, in a network of the test's own; and one from a log.
#include <signal.h>

#include <catch2/catch.hpp>
#include <functional>
#include <map>
#include <memory>
#include <set>

#include "core/geometry/trajectory.h"
#include "core/pgo/robot_csv.h"
#include "core/pgo/solve_distributed.h"
#include "core/sim/grid.h"
#include "procs/common/bus.h"
#include "procs/common/log_file.h"
#include "tests/child_process.h"
#include "tests/core/pgo/scratch.h"
#include "tests/wait_until.h"

namespace covey {
namespace {

struct Folder : ScratchFile {
  Folder() { std::filesystem::create_directories(path); }
};

sim::GridWorld small_world() {
  return sim::make_grid({.robots = 3, .keyframes = 40, .seed = 4, .min_links = 4});
}

// One robot's processes, and its dpgo's STATUS as heard on its bus.
class Robot {
 public:
  Robot(int id, const std::filesystem::path& folder, EventLoop& loop, Status& counts)
      : id_(std::to_string(id)), folder_(folder), bus_({robot_bus_url(id), {}, nullptr}, loop, counts) {
    bus_.subscribe(kStatus, [this](const status_t& status) {
      if (status.process == "dpgo") status_ = status;
    });
    bridge_ = std::make_unique<ChildProcess>(
        "radio_bridge",
        std::vector<std::string>{"--robot", id_, "--config", (folder / "radio.yaml").string()},
        file("bridge.log"));
    start_dpgo();
    player_ = std::make_unique<ChildProcess>(
        "player",
        std::vector<std::string>{"--robot", id_, "--pose-graph", (folder / "graph").string(), "--speed", "0"},
        file("player.log"));
  }
  void start_dpgo() {
    status_ = {};
    dpgo_ = std::make_unique<ChildProcess>(
        "dpgo", std::vector<std::string>{"--robot", id_, "--state", file("state"), "--tum", tum()},
        file("dpgo.log"));
  }
  ChildProcess& dpgo() { return *dpgo_; }
  double gauge(const std::string& name) const {
    for (int k = 0; k < status_.n_gauges; ++k) {
      if (status_.gauge_names[k] == name) return status_.gauge_values[k];
    }
    return -1.0;
  }
  std::int64_t counter(const std::string& name) const {
    for (int k = 0; k < status_.n_counters; ++k) {
      if (status_.counter_names[k] == name) return status_.counter_values[k];
    }
    return 0;
  }
  const std::string& phase() const { return status_.phase; }
  std::string tum() const { return file("team.tum"); }
  bool solved_with_all() const {
    return phase() == "idle" && gauge("keyframes") == 40 && gauge("solved_keyframes") == 40 &&
           gauge("robots") == 3 && gauge("loops") == gauge("solved_loops");
  }

 private:
  std::string file(const std::string& name) const {
    return (folder_ / ("robot" + id_ + "_" + name)).string();
  }

  std::string id_;
  std::filesystem::path folder_;
  Bus bus_;
  status_t status_{};
  std::unique_ptr<ChildProcess> bridge_;
  std::unique_ptr<ChildProcess> dpgo_;
  std::unique_ptr<ChildProcess> player_;
};

class Team {
 public:
  Team(const pgo::PoseGraph& graph, const std::string& radio) {
    pgo::write_robot_csv(folder_.path / "graph", graph);
    std::ofstream(folder_.path / "radio.yaml") << "radio_bridge: {" << radio << "}";
    for (int id = 0; id < graph.robots(); ++id) {
      robots_[id] = std::make_unique<Robot>(id, folder_.path, loop_, counts_);
    }
  }
  Robot& robot(int id) { return *robots_.at(id); }

  bool wait_until(const std::function<bool()>& done) { return covey::wait_until(loop_, 90.0, done); }
  bool solved() const {
    std::set<double> rounds;
    for (const auto& [id, robot] : robots_) {
      if (!robot->solved_with_all()) return false;
      rounds.insert(robot->gauge("round"));
    }
    return rounds.size() == 1;
  }
  double cost() const {
    double cost = 0.0;
    for (const auto& [id, robot] : robots_) cost += robot->gauge("cost");
    return cost;
  }

 private:
  Folder folder_;
  EventLoop loop_;
  Status counts_;
  std::map<int, std::unique_ptr<Robot>> robots_;
};

TEST_CASE("three robots over a lossy radio end in one frame, and again after a kill") {
  const sim::GridWorld world = small_world();
  const double expected = pgo::solve_distributed(world.graph).cost;
  Team team(world.graph, "loss: 0.2, delay_ms: 20");
  // Into the middle of a round, then kill -9 and start anew with what is on disk.
  REQUIRE(team.wait_until([&] { return team.robot(1).phase() == "round"; }));
  team.robot(1).dpgo().kill(SIGKILL);
  REQUIRE(team.robot(1).dpgo().wait(5.0) == -SIGKILL);
  team.robot(1).start_dpgo();
  REQUIRE(team.wait_until([&] { return team.solved(); }));
  REQUIRE(team.cost() == Approx(expected).epsilon(1e-3));
  for (const int id : {0, 1, 2}) REQUIRE(read_tum(team.robot(id).tum()).size() == 40);

  // Killed when all is done: it has its solution back without another round.
  const double round = team.robot(2).gauge("round");
  team.robot(2).dpgo().kill(SIGKILL);
  REQUIRE(team.robot(2).dpgo().wait(5.0) == -SIGKILL);
  team.robot(2).start_dpgo();
  REQUIRE(team.wait_until([&] { return team.robot(2).solved_with_all(); }));
  REQUIRE(team.robot(2).gauge("round") == round);
  team.robot(2).dpgo().kill(SIGTERM);
  REQUIRE(team.robot(2).dpgo().wait(5.0) == 0);
}

TEST_CASE("robots that hear each other only through a third end in one frame") {
  const sim::GridWorld world = small_world();
  Team team(world.graph,
            "loss: 0.05, contacts: [{a: 0, b: 1, from_s: 0, until_s: 1000}, {a: 1, b: 2, from_s: 0, until_s: "
            "1000}]");
  REQUIRE(team.wait_until([&] { return team.solved(); }));
  REQUIRE(team.cost() == Approx(pgo::solve_distributed(world.graph).cost).epsilon(1e-3));
  REQUIRE(team.robot(1).counter("out/OUT_DPGO_RELAY_ROUND") > 0);
  for (const int id : {0, 2}) {
    REQUIRE(team.robot(id).counter("in/IN_DPGO_RELAY_ROUND") > 0);
    REQUIRE(team.robot(id).gauge("together/" + std::to_string(2 - id)) == 1.0);
    REQUIRE(team.robot(id).counter("out/OUT_DPGO_RELAY_ROUND") == 0);
  }
}

// One robot's keyframes and loops as a log, with some bytes that are no message.
void write_log(const std::string& file) {
  const sim::GridWorld world = sim::make_grid({.robots = 1, .keyframes = 120, .seed = 2, .min_links = 0});
  LogRecorder log(file);
  Utime now = 1'000'000;
  SE3 T_O_K;
  keyframe_t first{};
  first.q_O_K[0] = first.q_P_K[0] = 1.0;
  first.segment = 1;
  log.write(now, "KEYFRAME", encode(first));
  const auto put = [](const SE3& T, double(&q)[4], double(&t)[3]) {
    const Eigen::Quaterniond r = T.rotation.canonical_quaternion();
    q[0] = r.w(), q[1] = r.x(), q[2] = r.y(), q[3] = r.z();
    for (int i = 0; i < 3; ++i) t[i] = T.translation[i];
  };
  const auto isotropic = [](double kappa, double tau, double(&covariance)[36]) {
    for (int i = 0; i < 6; ++i) covariance[7 * i] = i < 3 ? 1.0 / tau : 0.5 / kappa;
  };
  int loops = 0;
  for (const pgo::Edge& edge : world.graph.edges) {
    now += 50'000;
    if (edge.kind == pgo::EdgeKind::kOdometry) {
      T_O_K = T_O_K * edge.measurement;
      keyframe_t message{};
      message.utime = now;
      message.segment = 1;
      message.id = edge.to.index;
      put(T_O_K, message.q_O_K, message.t_O_K);
      put(edge.measurement, message.q_P_K, message.t_P_K);
      isotropic(edge.kappa, edge.tau, message.covariance);
      log.write(now, "KEYFRAME", encode(message));
      if (edge.to.index % 10 == 0) log.write(now, "IN_DPGO_ADVANCE", Bytes(100, 7));
    } else {
      loop_t message{};
      message.utime = now;
      message.stream = 1;
      message.number = loops++;
      message.segment_a = message.segment_b = 1;
      message.id_a = edge.from.index;
      message.id_b = edge.to.index;
      put(edge.measurement, message.q_A_B, message.t_A_B);
      isotropic(edge.kappa, edge.tau, message.covariance);
      log.write(now, "LOOP", encode(message));
    }
  }
  log.write(now + 10 * kUsPerSecond, "STREAM_HEAD", Bytes());
}

std::map<std::string, std::vector<Bytes>> events_of(const std::filesystem::path& file) {
  std::map<std::string, std::vector<Bytes>> events;
  LogReader reader(file.string(),
                   [&](const std::string& channel, const Bytes& bytes) { events[channel].push_back(bytes); });
  while (reader.next_time()) reader.deliver();
  events.erase("STATUS");
  return events;
}

TEST_CASE("the same log twice gives the same messages") {
  const Folder folder;
  const std::string log = (folder.path / "in.lcm").string();
  write_log(log);
  std::vector<std::map<std::string, std::vector<Bytes>>> runs;
  for (const std::string name : {"a", "b"}) {
    const std::string out = (folder.path / (name + ".lcm")).string();
    const std::string tum = (folder.path / (name + ".tum")).string();
    ChildProcess dpgo("dpgo", {"--robot", "0", "--url", "file://" + log, "--out", out, "--tum", tum},
                      (folder.path / (name + ".log")).string());
    const auto code = dpgo.wait(60.0);
    INFO(dpgo.output());
    REQUIRE(code == 0);
    runs.push_back(events_of(out));
    REQUIRE(read_tum(tum).size() == 120);
  }
  REQUIRE(runs[0].count("TRAJECTORY") == 1);
  REQUIRE(runs[0].count("LOOP_WEIGHTS") == 1);
  REQUIRE(runs[0] == runs[1]);
}

}  // namespace
}  // namespace covey
