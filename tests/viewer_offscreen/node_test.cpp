// SPDX-License-Identifier: BSD-3-Clause
// The process on a log and on buses, each test in a network of its own (PRIVATE_NETWORK in CMakeLists.txt).
#include <png.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <filesystem>

#include "procs/common/bus.h"
#include "procs/common/log_file.h"
#include "tests/child_process.h"
#include "tests/viewer_offscreen/team_messages.h"
#include "tests/wait_until.h"
#include "viewer_offscreen/colour.h"

namespace covey::viewer {
namespace {

constexpr double kPatienceS = 60.0;
const std::vector<Eigen::Vector3d> kPath = {{0, 0, 0}, {4, 0, 0}, {4, 3, 0}};

// A folder of its own, and an ear on the bus of robot 4.
class Stage {
 public:
  Stage() : bus_({robot_bus_url(4), {}, nullptr}, loop_, status_) {
    std::string pattern = (std::filesystem::temp_directory_path() / "covey_viewer_node_XXXXXX").string();
    folder_ = mkdtemp(pattern.data());
    bus_.subscribe(kStatus, [this](const status_t& message) { viewer_ = message; });
  }
  ~Stage() { std::filesystem::remove_all(folder_); }
  Stage(const Stage&) = delete;
  Stage& operator=(const Stage&) = delete;

  std::string file(const std::string& name) const { return (folder_ / name).string(); }
  EventLoop& loop() { return loop_; }
  Status& status() { return status_; }
  Bus& bus() { return bus_; }

  std::unique_ptr<ChildProcess> start(std::vector<std::string> arguments) const {
    arguments.insert(arguments.end(), {"--size", "800x600", "--view", "top"});
    return std::make_unique<ChildProcess>("viewer_offscreen", arguments, file("output"));
  }
  std::optional<int> run(const std::vector<std::string>& arguments) const {
    return start(arguments)->wait(kPatienceS);
  }
  std::string output() const { return read_text(file("output")); }

  bool wait_until(const std::function<bool()>& done) { return covey::wait_until(loop_, kPatienceS, done); }

  // Of the viewer's last STATUS; 0 where it has none of the name.
  double said(const std::string& name) const {
    for (std::size_t i = 0; i < viewer_.counter_names.size(); ++i) {
      if (viewer_.counter_names[i] == name) return static_cast<double>(viewer_.counter_values[i]);
    }
    for (std::size_t i = 0; i < viewer_.gauge_names.size(); ++i) {
      if (viewer_.gauge_names[i] == name) return viewer_.gauge_values[i];
    }
    return 0.0;
  }
  bool heard() const { return viewer_.process == "viewer_offscreen" && viewer_.robot == 4; }

 private:
  std::filesystem::path folder_;
  EventLoop loop_;
  Status status_;
  Bus bus_;
  status_t viewer_{};
};

bool shows(const std::string& file, Rgb colour) {
  png_image header = {};
  header.version = PNG_IMAGE_VERSION;
  if (png_image_begin_read_from_file(&header, file.c_str()) == 0) return false;
  header.format = PNG_FORMAT_RGB;
  std::vector<std::uint8_t> rgb(PNG_IMAGE_SIZE(header));
  if (png_image_finish_read(&header, nullptr, rgb.data(), 0, nullptr) == 0) return false;
  for (std::size_t i = 0; i + 2 < rgb.size(); i += 3) {
    if (Rgb{rgb[i], rgb[i + 1], rgb[i + 2]} == colour) return true;
  }
  return false;
}

std::vector<Eigen::Vector3d> shifted(double y) {
  std::vector<Eigen::Vector3d> path = kPath;
  for (Eigen::Vector3d& p : path) p.y() += y;
  return path;
}

TEST_CASE("the state at the end of a log is drawn, in the robots' colours, the same bytes each time") {
  const Stage stage;
  {
    LogRecorder first(stage.file("robot0.lcm"));
    first.write(100, "TRAJECTORY", encode(trajectory_part(0, 100, {{500, 500, 0}, {600, 500, 0}})));
    first.write(150, "TRAJECTORY", Bytes(1000, 0x5a));
    first.write(160, "LOOP_WEIGHTS", {});
    first.write(200, "TRAJECTORY", encode(trajectory_part(0, 200, kPath)));
    first.write(200, "LOOP_WEIGHTS", encode(weights_part(0, 200, {{0, 0, 3, 2, 1.0}, {0, 1, 3, 0, 0.0}})));
    LogRecorder second(stage.file("robot3.lcm"));
    second.write(250, "TRAJECTORY", encode(trajectory_part(3, 250, shifted(2.0))));
    second.write(300, "TRAJECTORY", encode(trajectory_part(3, 300, {{0, 9, 0}}, 0, 2)));  // never whole
  }
  const std::vector<std::string> logs = {"--url", "file://" + stage.file("robot0.lcm"), "--url",
                                         "file://" + stage.file("robot3.lcm")};
  for (const char* name : {"a.png", "b.png"}) {
    std::vector<std::string> arguments = logs;
    arguments.insert(arguments.end(), {"--out", stage.file(name)});
    const auto exit_code = stage.run(arguments);
    INFO(stage.output());
    CHECK(exit_code == 0);
  }
  CHECK(shows(stage.file("a.png"), palette_colour(0)));
  CHECK(shows(stage.file("a.png"), palette_colour(3)));
  CHECK_FALSE(shows(stage.file("a.png"), palette_colour(1)));
  CHECK(read_text(stage.file("a.png")) == read_text(stage.file("b.png")));
  CHECK(stage.run({logs[0], logs[1], "--out", stage.file("c.png")}) == 0);
  CHECK_FALSE(shows(stage.file("c.png"), palette_colour(3)));
}

TEST_CASE("live, every round is drawn in its turn, nonsense is counted, and SIGTERM ends it with 0") {
  Stage stage;
  Bus other({robot_bus_url(6), {}, nullptr}, stage.loop(), stage.status());
  const std::string out = stage.file("live.png");
  const auto viewer = stage.start({"--robot", "4", "--robot", "6", "--every", "0.1", "--out", out});
  REQUIRE(stage.wait_until([&] { return stage.heard(); }));
  for (const Bytes& bytes : {Bytes(), Bytes(300'000, 0x5a), encode(status_t{})}) {
    stage.bus().publish_raw("TRAJECTORY", bytes);
    other.publish_raw("LOOP_WEIGHTS", bytes);
  }
  const Utime now = stage.loop().now();
  stage.bus().publish(kTrajectory, trajectory_part(4, now + 3'600'000'000, kPath));
  stage.bus().publish(kTrajectory, trajectory_part(4, now, {{1e300, 0, 0}}));
  CHECK(stage.wait_until([&] {
    return stage.said("dropped/TRAJECTORY/undecodable") == 3 &&
           stage.said("dropped/LOOP_WEIGHTS/undecodable") == 3 &&
           stage.said("dropped/TRAJECTORY/future") == 1 && stage.said("dropped/TRAJECTORY/values") == 1;
  }));
  CHECK_FALSE(std::filesystem::exists(out));
  stage.bus().publish(kTrajectory, trajectory_part(4, now, kPath));
  CHECK(stage.wait_until([&] { return stage.said("pictures") == 1; }));
  CHECK(shows(out, palette_colour(4)));
  other.publish(kTrajectory, trajectory_part(6, now, shifted(2.0)));
  CHECK(stage.wait_until([&] { return stage.said("robots") == 2; }));
  CHECK(shows(out, palette_colour(6)));
  CHECK(stage.said("pictures") == 2);
  viewer->kill(SIGTERM);
  CHECK(viewer->wait(kPatienceS) == 0);
}

TEST_CASE("what makes no sense beside a bus, or there, is refused with 2") {
  const Stage stage;
  LogRecorder(stage.file("silent.lcm")).write(1, "TRAJECTORY", encode(trajectory_part(0, 1, {})));
  const std::string log = "file://" + stage.file("silent.lcm");
  const std::string out = stage.file("x.png");
  const auto refuses = [&](std::vector<std::string> arguments, const std::string& words) {
    if (std::find(arguments.begin(), arguments.end(), "--out") == arguments.end())
      arguments.insert(arguments.end(), {"--out", out});
    CHECK(stage.run(arguments) == 2);
    CHECK_THAT(stage.output(), Catch::Matchers::Contains(words));
  };
  refuses({"--url", log}, log + ": no robot said a whole TRAJECTORY with poses; nothing to draw");
  refuses({"--url", log, "--trajectory", "a=b.tum"}, "--trajectory excludes --url");
  refuses({"--robot", "1", "--loops", "loops.csv"}, "--loops excludes --robot");
  refuses({"--robot", "1", "--url", log}, "--robot excludes --url");
  refuses({"--robot", "20"}, "--robot");
  refuses({"--robot", "1", "--robot", "1"}, "every bus needs a port of its own");
  refuses({"--url", log, "--url", "udpm://239.255.76.67:7701"}, "either all buses are logs or none is");
  refuses({"--url", "file:///nonexistent.lcm"}, "/nonexistent.lcm");
  refuses({"--every", "1", "--trajectory", "a=b.tum"}, "--every is for a bus; give --robot or --url too");
  refuses({"--robot", "1", "--out", "/nonexistent/x.png"}, "--out: /nonexistent is no folder");
  CHECK_FALSE(std::filesystem::exists(out));
}

}  // namespace
}  // namespace covey::viewer
