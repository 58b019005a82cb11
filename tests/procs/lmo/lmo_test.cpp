// SPDX-License-Identifier: BSD-3-Clause
// A real lmo: from a log; and over multicast in a network of the test's own, killed on the way.
#include <signal.h>

#include <catch2/catch.hpp>
#include <functional>
#include <map>

#include "procs/common/bus.h"
#include "procs/common/log_file.h"
#include "tests/child_process.h"
#include "tests/core/mesh/corridor_messages.h"
#include "tests/core/pgo/scratch.h"
#include "tests/wait_until.h"
#include "viewer_offscreen/ply.h"

namespace covey {
namespace {

struct Folder : ScratchFile {
  Folder() { std::filesystem::create_directories(path); }
  std::string file(const std::string& name) const { return (path / name).string(); }
};

SE3 drift(double seconds) {
  Vector6d body_velocity;
  body_velocity << 1.0, 0.01, 0.0, 0.0, 0.0, 0.005;
  return SE3::exp(seconds * body_velocity) * SE3{SO3{}, {-seconds, 0.0, 0.0}};
}

testing::Corridor corridor() { return testing::make_corridor(drift, {.length_m = 12.0}); }

double largest_distance(const viewer::Mesh& mesh, const std::vector<std::vector<Eigen::Vector3f>>& truth) {
  std::vector<Eigen::Vector3f> p_W;
  for (const auto& of_block : truth) p_W.insert(p_W.end(), of_block.begin(), of_block.end());
  if (p_W.size() != mesh.vertices.size()) return 1e9;
  return testing::distances(mesh.vertices, p_W).max_m;
}

void write_log(const std::string& file) {
  LogRecorder log(file);
  Utime now = 1'000'000;
  for (const keyframe_t& message : testing::keyframe_messages(corridor())) {
    log.write(now += 1000, "KEYFRAME", encode(message));
  }
  for (const mesh_block_t& message : testing::block_messages(corridor()).messages) {
    log.write(now += 1000, "MESH", encode(message));
  }
  log.write(now, "TRAJECTORY", Bytes(50, 3));
  for (const trajectory_t& message : testing::trajectory_messages(corridor(), 1, now)) {
    log.write(now += 1000, "TRAJECTORY", encode(message));
  }
}

TEST_CASE("lmo from a log writes the deformed mesh, and the same log gives the same messages") {
  const Folder folder;
  write_log(folder.file("in.lcm"));
  std::vector<std::vector<Bytes>> runs;
  for (const std::string run : {"a", "b"}) {
    ChildProcess lmo("lmo",
                     {"--robot", "0", "--url", "file://" + folder.file("in.lcm"), "--out",
                      folder.file(run + ".lcm"), "--mesh", folder.file("mesh_" + run)},
                     folder.file(run + ".txt"));
    REQUIRE(lmo.wait(30.0) == 0);
    runs.emplace_back();
    LogReader reader(folder.file(run + ".lcm"), [&](const std::string& channel, const Bytes& bytes) {
      if (channel == "MESH_OPTIMIZED") runs.back().push_back(bytes);
    });
    while (reader.next_time()) reader.deliver();
  }
  REQUIRE(runs[0].size() > 3);
  REQUIRE(runs[0] == runs[1]);
  const auto truth = testing::block_messages(corridor()).p_W;
  const viewer::Mesh vio = viewer::read_ply(folder.file("mesh_a/robot0_vio.ply"));
  const viewer::Mesh team = viewer::read_ply(folder.file("mesh_a/robot0_team.ply"));
  REQUIRE(largest_distance(vio, truth) > 0.1);
  REQUIRE(largest_distance(team, truth) < 0.01);
  REQUIRE(team.faces.size() == corridor().mesh.faces.size());
  REQUIRE(team.colours.size() == team.vertices.size());
  for (std::size_t v = 0; v < team.vertices.size(); ++v) {
    REQUIRE(team.labels[v] == (std::abs(team.vertices[v].z()) < 0.05F ? 2 : 1));
  }
}

// An lmo on robot 0's bus, and what it says.
class Stage {
 public:
  Stage() { start(); }

  void start() {
    status_ = {};
    lmo_ = std::make_unique<ChildProcess>(
        "lmo",
        std::vector<std::string>{"--robot", "0", "--state", folder.file("state"), "--mesh",
                                 folder.file("mesh"), "--config", config()},
        folder.file("lmo.txt"));
  }
  // A bus that knows nothing of what another one has sent.
  void open_bus() {
    bus_.reset();
    bus_ = std::make_unique<Bus>(BusOptions{robot_bus_url(0), {}, nullptr}, loop_, counts_);
    bus_->subscribe(kStatus, [this](const status_t& status) { status_ = status; });
    bus_->subscribe(kMeshOptimized,
                    [this](const mesh_optimized_t& part) { parts_[part.round].insert(part.part); });
  }
  bool wait_until(const std::function<bool()>& done) { return covey::wait_until(loop_, 30.0, done); }
  double gauge(const std::string& name) const {
    for (int k = 0; k < status_.n_gauges; ++k) {
      if (status_.gauge_names[k] == name) return status_.gauge_values[k];
    }
    return -100.0;
  }
  bool solved(std::int64_t round, int number) const {
    return status_.phase == "idle" && gauge("solved_round") == static_cast<double>(round) &&
           gauge("mesh_number") == number;
  }
  Bus& bus() { return *bus_; }
  ChildProcess& lmo() { return *lmo_; }
  std::size_t parts(std::int64_t round) const { return parts_.contains(round) ? parts_.at(round).size() : 0; }

  Folder folder;

 private:
  std::string config() const {
    std::ofstream(folder.path / "robot.yaml") << "lmo: {settle_s: 0.3}\n";
    return folder.file("robot.yaml");
  }

  EventLoop loop_;
  Status counts_;
  std::unique_ptr<Bus> bus_;
  status_t status_{};
  std::map<std::int64_t, std::set<int>> parts_;
  std::unique_ptr<ChildProcess> lmo_;
};

TEST_CASE("lmo that was killed goes on with all that it had") {
  Stage stage;
  stage.open_bus();
  REQUIRE(stage.wait_until([&] { return stage.gauge("blocks") == 0; }));
  const auto blocks = testing::block_messages(corridor());
  const int last = static_cast<int>(blocks.messages.size()) - 1;
  for (const keyframe_t& message : testing::keyframe_messages(corridor()))
    stage.bus().publish(kKeyframe, message);
  for (int b = 0; b < last; ++b) stage.bus().publish(kMesh, blocks.messages[b]);
  for (const auto& part : testing::trajectory_messages(corridor(), 1, 1000))
    stage.bus().publish(kTrajectory, part);
  REQUIRE(stage.wait_until([&] { return stage.solved(1, last - 1) && stage.parts(1) > 3; }));

  stage.lmo().kill(SIGKILL);
  REQUIRE(stage.lmo().wait(5.0) == -SIGKILL);
  std::filesystem::remove_all(stage.folder.path / "mesh");
  stage.open_bus();
  stage.start();
  REQUIRE(stage.wait_until([&] { return stage.solved(1, last - 1); }));
  REQUIRE(std::filesystem::exists(stage.folder.path / "mesh/robot0_team.ply"));

  // One more block, and a round that moves all by the same.
  const SE3 T_new_W{SO3::exp({0.0, 0.0, 1.0}), {5.0, 0.0, 0.0}};
  stage.bus().publish(kMesh, blocks.messages[last]);
  for (const auto& part : testing::trajectory_messages(corridor(), 2, 2000, 1000, T_new_W)) {
    stage.bus().publish(kTrajectory, part);
  }
  REQUIRE(stage.wait_until([&] { return stage.solved(2, last); }));
  auto truth = blocks.p_W;
  for (auto& of_block : truth) {
    for (Eigen::Vector3f& p : of_block) p = (T_new_W * p.cast<double>()).cast<float>();
  }
  REQUIRE(largest_distance(viewer::read_ply(stage.folder.file("mesh/robot0_team.ply")), truth) < 0.01);
  REQUIRE(largest_distance(viewer::read_ply(stage.folder.file("mesh/robot0_vio.ply")), truth) > 0.1);
  stage.lmo().kill(SIGTERM);
  REQUIRE(stage.lmo().wait(5.0) == 0);
}

}  // namespace
}  // namespace covey
