// SPDX-License-Identifier: BSD-3-Clause
// Whole processes over real multicast, each test in a network of its own (PRIVATE_NETWORK in CMakeLists.txt). Nothing here waits for a time to pass: a reader
// is there when its STATUS is, and a message has arrived when the reader's file says so.
#include "procs/common/process.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>

#include "procs/common/log_file.h"
#include "tests/child_process.h"
#include "tests/wait_until.h"

namespace covey {
namespace {

namespace fs = std::filesystem;

constexpr double kPatienceS = 60.0;

// A folder, and an ear on the bus of robot 3.
class Stage {
 public:
  Stage()
      : folder_(fs::temp_directory_path() / ("covey_process_test_" + std::to_string(getpid()))),
        bus_({robot_bus_url(3), {}, nullptr}, loop_, status_) {
    fs::create_directories(folder_);
    bus_.subscribe(kStatus, [this](const status_t& status) { statuses_[status.start_utime] = status; });
  }
  ~Stage() { fs::remove_all(folder_); }

  Bus& bus() { return bus_; }
  std::string file(const std::string& name) const { return (folder_ / name).string(); }

  // Starts a probe on robot 3's bus and waits for its STATUS: it has subscribed.
  std::unique_ptr<ChildProcess> start(std::vector<std::string> arguments) {
    arguments.insert(arguments.end(), {"--robot", "3"});
    const std::size_t known = statuses_.size();
    auto child = std::make_unique<ChildProcess>("probe", arguments, file("log" + std::to_string(known)));
    INFO(child->output());
    REQUIRE(wait_until([&] { return statuses_.size() > known; }));
    return child;
  }

  bool wait_until(const std::function<bool()>& done) { return covey::wait_until(loop_, kPatienceS, done); }

  // Of any process that has one of this name.
  std::int64_t counter(const std::string& name) const {
    std::int64_t sum = 0;
    for (const auto& [start, status] : statuses_) {
      for (std::size_t i = 0; i < status.counter_names.size(); ++i) {
        if (status.counter_names[i] == name) sum += status.counter_values[i];
      }
    }
    return sum;
  }

  // Whether some process is in it.
  bool phase(const std::string& name) const {
    return std::any_of(statuses_.begin(), statuses_.end(),
                       [&](const auto& status) { return status.second.phase == name; });
  }

 private:
  fs::path folder_;
  EventLoop loop_;
  Status status_;
  Bus bus_;
  std::map<Utime, status_t> statuses_;
};

using Keyframes = std::vector<std::pair<std::int64_t, std::int32_t>>;

Keyframes read_keyframes(const std::string& name) {
  Keyframes keyframes;
  std::ifstream file(name);
  std::int64_t segment = 0;
  std::int32_t id = 0;
  while (file >> segment >> id) keyframes.emplace_back(segment, id);
  return keyframes;
}

Keyframes expected(std::int64_t segment, std::int32_t count) {
  Keyframes keyframes;
  for (std::int32_t id = 0; id < count; ++id) keyframes.emplace_back(segment, id);
  return keyframes;
}

std::int64_t size_of(const std::string& file) {
  return static_cast<std::int64_t>(read_keyframes(file).size());
}

TEST_CASE("A stream over a lossy bus arrives whole, and SIGTERM ends both sides with 0") {
  Stage stage;
  const std::string got = stage.file("got");
  const auto reader =
      stage.start({"--read", got, "--bus-faults", "drop=0.3,duplicate=0.1,delay_ms=50,seed=1"});
  const auto writer = stage.start({"--write", "500", "--period-ms", "1", "--bus-faults", "drop=0.3,seed=2"});
  CHECK(stage.wait_until([&] { return size_of(got) >= 500; }));
  CHECK(read_keyframes(got) == expected(1'000'000, 500));
  CHECK(stage.wait_until([&] { return stage.counter("in/KEYFRAME") == 500; }));
  CHECK(stage.counter("resent/KEYFRAME") > 0);
  reader->kill(SIGTERM);
  writer->kill(SIGINT);
  CHECK(reader->wait(kPatienceS) == 0);
  CHECK(writer->wait(kPatienceS) == 0);
}

TEST_CASE("A writer that is killed and comes again, with its stream or a new one, is read on") {
  Stage stage;
  const std::string got = stage.file("got");
  const auto reader = stage.start({"--read", got, "--bus-faults", "drop=0.1,seed=3"});
  auto writer = stage.start({"--write", "300"});  // no more, however late it is killed
  REQUIRE(stage.wait_until([&] { return size_of(got) > 50; }));
  writer->kill(SIGKILL);
  CHECK(writer->wait(kPatienceS) == -SIGKILL);
  writer = stage.start({"--write", "400", "--period-ms", "1"});
  REQUIRE(stage.wait_until([&] { return size_of(got) >= 400; }));
  writer->kill(SIGKILL);
  CHECK(writer->wait(kPatienceS) == -SIGKILL);
  CHECK(read_keyframes(got) == expected(1'000'000, 400));
  writer = stage.start({"--write", "100", "--period-ms", "1", "--segment", "2000000"});
  REQUIRE(stage.wait_until([&] { return size_of(got) >= 500; }));
  Keyframes both = expected(1'000'000, 400);
  const Keyframes second = expected(2'000'000, 100);
  both.insert(both.end(), second.begin(), second.end());
  CHECK(read_keyframes(got) == both);
}

TEST_CASE("A reader that is killed and comes again hears the whole stream") {
  Stage stage;
  const std::string got = stage.file("got");
  auto reader = stage.start({"--read", got});
  const auto writer = stage.start({"--write", "300", "--period-ms", "1"});
  REQUIRE(stage.wait_until([&] { return size_of(got) > 50; }));
  reader->kill(SIGKILL);
  CHECK(reader->wait(kPatienceS) == -SIGKILL);
  reader = stage.start({"--read", got});
  CHECK(stage.wait_until([&] { return size_of(got) >= 300; }));
  CHECK(read_keyframes(got) == expected(1'000'000, 300));
}

TEST_CASE("Wrong types, garbage and absurd counts are counted, and the process goes on") {
  Stage stage;
  const std::string got = stage.file("got");
  const auto reader = stage.start({"--read", got});
  Bytes absurd = encode(trajectory_t{});
  absurd[absurd.size() - 8] = 0x7f;  // n = 2^31 - 1, of 16 GB
  for (std::size_t i = absurd.size() - 7; i < absurd.size() - 4; ++i) absurd[i] = 0xff;
  const std::vector<Bytes> nonsense{{}, Bytes(300'000, 0x5a), Bytes(7, 0), encode(status_t{}), absurd};
  for (const Bytes& bytes : nonsense) {
    CHECK(stage.bus().publish_raw("TRAJECTORY", bytes));
    CHECK(stage.bus().publish_raw("STREAM_HEAD", bytes));
  }
  stage.bus().publish_raw("KEYFRAME", nonsense[1]);
  CHECK(stage.wait_until([&] {
    return stage.counter("dropped/TRAJECTORY/undecodable") == 5 &&
           stage.counter("dropped/STREAM_HEAD/undecodable") == 5 &&
           stage.counter("dropped/KEYFRAME/undecodable") == 1;
  }));
  const auto writer = stage.start({"--write", "10"});
  CHECK(stage.wait_until([&] { return size_of(got) == 10; }));
  reader->kill(SIGTERM);
  CHECK(reader->wait(kPatienceS) == 0);
}

TEST_CASE("What --out records is what a process published, with its time") {
  Stage stage;
  const auto writer = stage.start({"--write", "20", "--out", stage.file("out.lcm")});
  REQUIRE(stage.wait_until([&] { return stage.phase("idle"); }));
  writer->kill(SIGTERM);
  CHECK(writer->wait(kPatienceS) == 0);
  std::int32_t next = 0;
  Utime before = 0;
  LogReader log(stage.file("out.lcm"), [&](const std::string& channel, const Bytes& bytes) {
    keyframe_t keyframe{};
    if (channel != kKeyframe.name) return;
    REQUIRE(decode(bytes, keyframe));
    CHECK(keyframe.id == next++);
  });
  for (; log.next_time(); log.deliver()) {
    CHECK(*log.next_time() >= before);
    before = *log.next_time();
  }
  CHECK(next == 20);
}

TEST_CASE("A second signal ends a process at once, even one that is stuck") {
  Stage stage;
  const auto stuck = stage.start({"--stuck"});
  REQUIRE(stage.wait_until([&] { return stage.phase("stuck"); }));
  stuck->kill(SIGTERM);
  CHECK(stuck->wait(0.2) == std::nullopt);
  stuck->kill(SIGTERM);
  CHECK(stuck->wait(kPatienceS) == 1);
}

// Exit code and output of a probe that ends by itself.
std::pair<std::optional<int>, std::string> run_probe(const Stage& stage,
                                                     const std::vector<std::string>& arguments) {
  ChildProcess child("probe", arguments, stage.file("run"));
  const auto code = child.wait(kPatienceS);
  return {code, child.output()};
}

TEST_CASE("A log run that a signal ends early fails and says that its output is partial") {
  Stage stage;
  const auto writer = stage.start({"--write", "20", "--out", stage.file("in.lcm")});
  REQUIRE(stage.wait_until([&] { return stage.phase("idle"); }));
  writer->kill(SIGTERM);
  CHECK(writer->wait(kPatienceS) == 0);
  const std::vector<std::string> replay{
      "--robot", "3", "--url", "file://" + stage.file("in.lcm"), "--out", stage.file("out.lcm")};
  CHECK(run_probe(stage, replay).first == 0);
  std::vector<std::string> interrupted = replay;
  interrupted.emplace_back("--interrupt");
  const auto [code, output] = run_probe(stage, interrupted);
  CHECK(code == 1);
  CHECK_THAT(output, Catch::Contains(stage.file("out.lcm") + " is partial"));
}

TEST_CASE("The command line: help, version, and one sentence with exit code 2 for what is wrong") {
  Stage stage;
  const auto [help_code, help] = run_probe(stage, {"--help"});
  CHECK(help_code == 0);
  for (const auto* option : {"--robot", "--config", "--url", "--state", "--out", "--tum", "--bus-faults"}) {
    CHECK_THAT(help, Catch::Contains(option));
  }
  CHECK(run_probe(stage, {"--version"}).first == 0);
  std::ofstream(stage.file("bad.yaml")) << "dpgo: {rounds: 3}\nprobes:\n  x: 1\n";
  const std::vector<std::pair<std::vector<std::string>, std::string>> wrong{
      {{}, "--robot"},
      {{"--robot", "99"}, "--robot"},
      {{"--robot", "3", "--wat"}, "--wat"},
      {{"--robot", "3", "--url", "http://x"}, "http://x"},
      {{"--robot", "3", "--url", "file:///nowhere.lcm"}, "/nowhere.lcm"},
      {{"--robot", "3", "--also", "nonsense"}, "nonsense"},
      {{"--robot", "3", "--bus-faults", "drop=2"}, "drop"},
      {{"--robot", "3", "--config", stage.file("nowhere.yaml")}, "nowhere.yaml"},
      {{"--robot", "3", "--config", stage.file("bad.yaml")}, "probes"},
      {{"--robot", "3", "--out", "/nowhere/out.lcm"}, "/nowhere/out.lcm"},
      {{"--robot", "3", "--state", "/proc/nowhere"}, "/proc/nowhere"},
  };
  for (const auto& [arguments, word] : wrong) {
    const auto [code, output] = run_probe(stage, arguments);
    CHECK(code == 2);
    CHECK_THAT(output, Catch::Contains(word));
    CHECK(std::count(output.begin(), output.end(), '\n') <= 1);
  }
}

}  // namespace
}  // namespace covey
