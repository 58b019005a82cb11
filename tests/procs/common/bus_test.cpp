// SPDX-License-Identifier: BSD-3-Clause
// The bus without a network: memq:// lives within the process, logs are files.
#include "procs/common/bus.h"

#include <unistd.h>

#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <filesystem>

#include "core/base/error.h"
#include "procs/common/log_file.h"

namespace covey {
namespace {

namespace fs = std::filesystem;

// A bus within the process, run for a while.
struct Local {
  explicit Local(BusFaults faults = {}) : bus({"memq://", faults, nullptr}, loop, status) {}
  void run(double seconds = 0.05) {
    loop.call_at(loop.now() + from_seconds(seconds), [this] { loop.stop(); });
    loop.run();
  }
  EventLoop loop;
  Status status;
  Bus bus;
};

std::string temporary(const std::string& name) {
  return (fs::temp_directory_path() / ("covey_bus_test_" + std::to_string(getpid()) + "_" + name)).string();
}

trajectory_t round_of(std::int64_t round) {
  trajectory_t trajectory{};
  trajectory.round = round;
  return trajectory;
}

keyframe_t keyframe(std::int64_t segment, std::int32_t id) {
  keyframe_t message{};
  message.segment = segment;
  message.id = id;
  return message;
}

TEST_CASE("A message comes out as it went in, and both sides are counted") {
  Local local;
  std::vector<std::int64_t> rounds;
  local.bus.subscribe(kTrajectory,
                      [&](const trajectory_t& trajectory) { rounds.push_back(trajectory.round); });
  for (int round = 0; round < 100; ++round) local.bus.publish(kTrajectory, round_of(round));
  local.run();
  REQUIRE(rounds.size() == 100);  // liblcm's own queue would have kept 31
  CHECK(rounds.back() == 99);
  CHECK(local.status.counter("in/TRAJECTORY") == 100);
  CHECK(local.status.counter("out/TRAJECTORY") == 100);
}

TEST_CASE("What is no message of the channel's type is counted and dropped") {
  Local local;
  int handled = 0;
  local.bus.subscribe(kTrajectory, [&](const trajectory_t&) { ++handled; });
  local.bus.publish_raw("TRAJECTORY", encode(status_t{}));
  local.bus.publish_raw("TRAJECTORY", {});
  local.bus.publish_raw("TRAJECTORY", Bytes(300'000, 0xa5));
  Bytes longer = encode(trajectory_t{});
  longer.push_back(0);
  local.bus.publish_raw("TRAJECTORY", longer);
  Bytes negative = encode(trajectory_t{});
  for (std::size_t i = negative.size() - 8; i < negative.size() - 4; ++i) negative[i] = 0xff;  // n = -1
  local.bus.publish_raw("TRAJECTORY", negative);
  local.bus.publish(kTrajectory, round_of(1));
  local.run();
  CHECK(handled == 1);
  CHECK(local.status.counter("dropped/TRAJECTORY/undecodable") == 5);
  CHECK(local.status.counter("in/TRAJECTORY") == 1);
}

TEST_CASE("A handler that throws is contained, and the bus goes on") {
  Local local;
  int handled = 0;
  local.bus.subscribe(kTrajectory, [&](const trajectory_t&) {
    if (++handled == 1) throw std::runtime_error("oh");
  });
  local.bus.publish(kTrajectory, round_of(0));
  local.bus.publish(kTrajectory, round_of(1));
  local.run();
  CHECK(handled == 2);
  CHECK(local.status.counter("bugs/TRAJECTORY") == 1);
}

TEST_CASE("Queues keep the newest or the oldest, exactly as many as they say") {
  Local local;
  std::vector<std::int64_t> newest;
  std::vector<std::int64_t> oldest;
  std::vector<std::int64_t> all;
  local.bus.subscribe(kTrajectory,
                      [&](const trajectory_t& trajectory) { newest.push_back(trajectory.round); },
                      {.newest_wins = true});
  local.bus.subscribe(kTrajectory,
                      [&](const trajectory_t& trajectory) { oldest.push_back(trajectory.round); },
                      {.capacity = 3});
  local.bus.subscribe(kTrajectory, [&](const trajectory_t& trajectory) { all.push_back(trajectory.round); });
  for (int round = 0; round < 20; ++round) local.bus.publish(kTrajectory, round_of(round));
  local.run();
  CHECK(newest == std::vector<std::int64_t>{19});
  CHECK(oldest == std::vector<std::int64_t>{0, 1, 2});
  CHECK(all.size() == 20);
  CHECK(local.status.counter("dropped/TRAJECTORY/queue_full") == 19 + 17);
}

TEST_CASE("A channel's name is a name, not a regular expression, and has at most 63 bytes") {
  Local local;
  int plus = 0;
  std::vector<std::string> raw;
  const Channel<trajectory_t> odd{"A.B+"};
  local.bus.subscribe(odd, [&](const trajectory_t&) { ++plus; });
  local.bus.subscribe_raw("OUT_.*",
                          [&](const std::string& channel, const Bytes&) { raw.push_back(channel); });
  const Bytes bytes = encode(trajectory_t{});
  for (const auto* name : {"A.B+", "AxBB", "OUT_X", "NOT_OUT_X", "OUT_"})
    CHECK(local.bus.publish_raw(name, bytes));
  CHECK(local.bus.publish_raw(std::string(63, 'X'), bytes));
  CHECK_FALSE(local.bus.publish_raw(std::string(64, 'X'), bytes));
  CHECK_FALSE(local.bus.publish_raw("", bytes));
  local.run();
  CHECK(plus == 1);
  CHECK(raw == std::vector<std::string>{"OUT_X", "OUT_"});
  CHECK_THROWS_AS(local.bus.subscribe_raw("(", [](const std::string&, const Bytes&) {}), InputError);
}

TEST_CASE("A radio channel goes out by one name and comes in by the other") {
  Local local;
  const RadioChannel<trajectory_t> radio{"THING"};
  int in = 0;
  local.bus.subscribe(radio, [&](const trajectory_t&) { ++in; });
  local.bus.publish(radio, trajectory_t{});
  local.bus.publish(radio.in(), trajectory_t{});
  local.run();
  CHECK(in == 1);
  CHECK(local.status.counter("out/OUT_THING") == 1);
}

TEST_CASE("A stream arrives whole over a bus that loses, doubles and delays") {
  Local local({.drop = 0.3, .duplicate = 0.1, .delay_ms = 30.0, .seed = 5});
  std::vector<std::int32_t> ids;
  local.bus.subscribe(kKeyframe, [&](const keyframe_t& message) {
    ids.push_back(message.id);
    if (message.id == 199) local.loop.stop();
  });
  int next = 0;
  local.loop.call_every(1'000, [&] {
    if (next < 200) local.bus.publish(kKeyframe, keyframe(7, next++));
  });
  local.run(60.0);
  std::vector<std::int32_t> expected;
  for (int id = 0; id < 200; ++id) expected.push_back(id);
  CHECK(ids == expected);
  CHECK(local.status.counter("in/KEYFRAME") == 200);
  CHECK(local.status.counter("requests/KEYFRAME") > 0);
  CHECK(local.status.counter("lost/KEYFRAME") == 0);
}

TEST_CASE("A bus that cannot be is refused in words") {
  EventLoop loop;
  Status status;
  CHECK_THROWS_WITH(Bus({"tcpq://x", {}, nullptr}, loop, status), Catch::Contains("udpm://"));
  CHECK_THROWS_WITH(Bus({"file:///nowhere.lcm", {}, nullptr}, loop, status), Catch::Contains("/nowhere.lcm"));
  CHECK_THROWS_AS(Bus({fmt::format("file://{}/LICENSE", COVEY_SOURCE_DIR), {}, nullptr}, loop, status),
                  InputError);
  CHECK_THROWS_AS(Bus({"file:///x.lcm?speed=0", {}, nullptr}, loop, status), InputError);
  CHECK(robot_bus_url(2) == "udpm://239.255.76.67:7702?ttl=0&recv_buf_size=4194304");
}

// Reads the log, publishes an answer to each trajectory and one more every 10 ms; returns the recording.
std::string replay(const std::string& log, const std::string& out, const BusFaults& faults) {
  EventLoop loop;
  Status status;
  {
    Bus bus({"file://" + log, faults, std::make_shared<LogRecorder>(out)}, loop, status);
    bus.subscribe(kTrajectory, [&](const trajectory_t& trajectory) {
      trajectory_t answer = round_of(trajectory.round);
      answer.utime = loop.now();
      bus.publish(kTrajectory, answer);
    });
    loop.call_every(10'000, [&] { bus.publish(kLoopWeights, loop_weights_t{}); });
    loop.run();
  }
  std::string trace;
  LogReader reader(out, [&](const std::string& channel, const Bytes& bytes) {
    trace += channel + ":" + std::string(bytes.begin(), bytes.end()) + "\n";
  });
  while (const auto time = reader.next_time()) {
    trace += std::to_string(*time) + " ";
    reader.deliver();
  }
  return trace;
}

TEST_CASE("The same log gives the same output twice, with faults too") {
  const std::string log = temporary("in.lcm");
  const std::string out = temporary("out.lcm");
  {
    LogRecorder recorder(log);
    for (int i = 0; i < 100; ++i) recorder.write(5'000 * i + (i % 7), "TRAJECTORY", encode(round_of(i)));
    REQUIRE(recorder.good());
  }
  for (const BusFaults& faults :
       {BusFaults{}, BusFaults{.drop = 0.2, .duplicate = 0.2, .delay_ms = 40.0, .seed = 2}}) {
    const std::string first = replay(log, out, faults);
    CHECK(first.size() > 5'000);
    CHECK(first == replay(log, out, faults));
  }
  CHECK(replay(log, out, {}) != replay(log, out, {.drop = 0.5}));
  fs::remove(log);
  fs::remove(out);
}

TEST_CASE("A message of a stream that the log has not is jumped over after a few seconds, and counted") {
  const std::string log = temporary("gap.lcm");
  stream_head_t head{};
  head.channel = kKeyframe.name;
  head.stream = 7;
  {
    LogRecorder recorder(log);
    for (int id = 0; id < 30; ++id) {
      const Utime time = kUsPerSecond * id;
      if (id != 4 && id != 5) recorder.write(time, kKeyframe.name, encode(keyframe(7, id)));
      head.next = id + 1;
      recorder.write(time + 1, kStreamHead.name, encode(head));
    }
  }
  EventLoop loop;
  Status status;
  Bus bus({"file://" + log, {}, nullptr}, loop, status);
  std::vector<std::int32_t> ids;
  Utime jumped = 0;
  bus.subscribe(kKeyframe, [&](const keyframe_t& message) {
    ids.push_back(message.id);
    if (message.id == 6) jumped = loop.now();
  });
  loop.run();
  std::vector<std::int32_t> expected{0, 1, 2, 3};
  for (int id = 6; id < 30; ++id) expected.push_back(id);
  CHECK(ids == expected);
  CHECK(status.counter("lost/KEYFRAME") == 2);
  CHECK(jumped < 15 * kUsPerSecond);
  fs::remove(log);
}

TEST_CASE("A log that is cut off is read as far as it goes") {
  const std::string log = temporary("cut.lcm");
  {
    LogRecorder recorder(log);
    for (int i = 0; i < 10; ++i) recorder.write(i, "TRAJECTORY", encode(round_of(i)));
  }
  fs::resize_file(log, fs::file_size(log) - 20);
  int events = 0;
  LogReader reader(log, [&](const std::string&, const Bytes&) { ++events; });
  while (reader.next_time()) reader.deliver();
  CHECK(events == 9);
  fs::remove(log);
}

TEST_CASE("An image set arrives whole through its bands, and a lost band costs one set") {
  Local local;
  std::vector<std::int64_t> seen;
  local.bus.subscribe(kStereo, [&](const stereo_t& stereo) {
    CHECK(stereo.left == std::vector<std::uint8_t>(stereo.left.size(), 7));
    seen.push_back(stereo.utime);
  });
  stereo_t stereo{};
  stereo.width = 752;
  stereo.height = 480;
  stereo.n_left = stereo.n_right = 752 * 480;
  stereo.left.assign(752 * 480, 7);
  stereo.right = stereo.left;
  for (int i = 0; i < 3; ++i) {
    stereo.utime = 1000 + i;
    local.bus.publish(kStereo, stereo);
    local.run();
  }
  CHECK(seen == std::vector<std::int64_t>{1000, 1001, 1002});
  CHECK(local.status.counter("in/STEREO") == 3);
}

}  // namespace
}  // namespace covey
