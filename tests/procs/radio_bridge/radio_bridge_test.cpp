// SPDX-License-Identifier: BSD-3-Clause
// Real radio_bridges over real multicast, in a network of the test's own.
#include <filesystem>
#include <fstream>

#include "core/radio/packet.h"
#include "procs/common/log_file.h"
#include "tests/procs/radio_bridge/radio_stage.h"

namespace covey {
namespace {

TEST_CASE("what is published as OUT_x arrives as IN_x where it is addressed to, and nowhere else") {
  const std::string channel = a_channel();
  RadioStage stage({0, 1, 2});
  for (const int robot : {0, 1, 2}) stage.start(robot);
  const Bytes to_all = message_for(channel, 0, -1, 200, 1);
  const Bytes to_one = message_for(channel, 0, 2, 200, 2);
  stage.robot(0).bus->publish_raw("OUT_" + channel, to_all);
  stage.robot(0).bus->publish_raw("OUT_" + channel, to_one);
  stage.robot(0).bus->publish_raw("OUT_KEYFRAME", to_all);
  stage.robot(0).bus->publish_raw("OUT_" + channel, message_for(channel, 1, -1, 200, 3));
  REQUIRE(stage.wait_until([&] { return stage.heard(2, channel) == 2 && stage.heard(1, channel) == 1; }));
  REQUIRE(stage.robot(1).heard["IN_" + channel][0] == to_all);
  REQUIRE(stage.robot(2).heard["IN_" + channel][1] == to_one);
  REQUIRE(stage.wait_until([&] { return stage.counter(1, "dropped/radio/for_another_robot") == 1; }));
  REQUIRE(stage.wait_until([&] { return stage.counter(0, "dropped/OUT_KEYFRAME/channel_unknown") == 1; }));
  REQUIRE(stage.counter(0, "dropped/OUT_" + channel + "/from_another_robot") == 1);
  REQUIRE(stage.counter(0, "dropped/radio/own_echo") > 0);
  REQUIRE(stage.heard(0, channel) == 0);
  REQUIRE(stage.heard(1, channel) == 1);
}

TEST_CASE("large messages arrive exactly once through a lossy radio, also after a kill") {
  const std::string channel = a_channel();
  const std::string config = (std::filesystem::path(COVEY_SOURCE_DIR) / "configs/radio/lossy.yaml").string();
  RadioStage stage({0, 1});
  for (const int robot : {0, 1}) stage.start(robot, {"--config", config});
  const auto say = [&](std::uint32_t first, std::uint32_t last) {
    for (std::uint32_t tag = first; tag < last; ++tag) {
      stage.robot(0).bus->publish_raw("OUT_" + channel,
                                      message_for(channel, 0, -1, tag % 5 == 0 ? 30'000 : 2000, tag));
    }
  };
  const auto check = [&](std::size_t messages) {
    REQUIRE(stage.wait_until([&] { return stage.heard(1, channel) >= messages; }));
    std::map<Bytes, int> times;
    for (const Bytes& message : stage.robot(1).heard["IN_" + channel]) ++times[message];
    REQUIRE(times.size() == messages);
    REQUIRE(stage.robot(1).heard["IN_" + channel].size() == messages);
  };
  say(0, 30);
  check(30);
  stage.robot(0).bridge->kill(SIGKILL);
  stage.start(0, {"--config", config});
  say(30, 60);
  check(60);
  REQUIRE(stage.wait_until([&] { return stage.counter(1, "dropped/radio/simulated_loss") > 10; }));
  REQUIRE(stage.wait_until([&] { return stage.counter(0, "sent_bytes/control") > 0; }));
}

TEST_CASE("SIGTERM ends a bridge at once, also with messages that nobody will ever acknowledge") {
  const std::string channel = a_channel();
  RadioStage stage({0});
  stage.start(0);
  for (std::uint32_t tag = 0; tag < 20; ++tag) {
    stage.robot(0).bus->publish_raw("OUT_" + channel, message_for(channel, 0, 5, 5000, tag));
  }
  REQUIRE(stage.wait_until([&] { return stage.counter(0, "sent_packets/control") > 1; }));
  stage.robot(0).bridge->kill(SIGTERM);
  REQUIRE(stage.robot(0).bridge->wait(10.0) == 0);
}

TEST_CASE("from logs of the bus and of the air: the same twice, byte for byte") {
  const std::string channel = a_channel();
  RadioStage stage({});
  {
    LogRecorder bus(stage.file("private.lcm"));
    LogRecorder air(stage.file("air.lcm"));
    for (std::uint32_t tag = 0; tag < 50; ++tag) {
      const Utime t = kUsPerSecond + 30'000 * static_cast<Utime>(tag);
      bus.write(t, "OUT_" + channel, message_for(channel, 0, -1, 100, tag));
      bus.write(t + 1, "OUT_" + channel, message_for(channel, 0, -1, 4000, tag));
      air.write(t + 2, channel, message_for(channel, 1, 0, 100, tag));
      air.write(t + 3, channel, message_for(channel, 1, 2, 100, tag));
      air.write(t + 4, "RADIO_FRAGMENT", message_for(channel, 1, 0, 100, tag));
      air.write(t + 5, channel, Bytes(5000));
    }
  }
  const std::string config = (std::filesystem::path(COVEY_SOURCE_DIR) / "configs/radio/lossy.yaml").string();
  for (const std::string out : {"a.lcm", "b.lcm"}) {
    ChildProcess bridge("radio_bridge",
                        {"--robot", "0", "--config", config, "--url", "file://" + stage.file("private.lcm"),
                         "--radio-url", "file://" + stage.file("air.lcm"), "--out", stage.file(out)},
                        stage.file("log"));
    const auto code = bridge.wait(kPatienceS);
    INFO(bridge.output());
    REQUIRE(code == 0);
  }
  std::map<std::string, int> counts;
  const auto messages_of = [&](const std::string& name) {
    std::vector<std::pair<std::string, Bytes>> messages;
    LogReader reader(stage.file(name), [&](const std::string& where, const Bytes& bytes) {
      if (where == "STATUS") return;
      ++counts[where];
      messages.emplace_back(where, bytes);
    });
    while (reader.next_time()) reader.deliver();
    return messages;
  };
  const auto first = messages_of("a.lcm");
  REQUIRE(counts[channel] == 50);
  REQUIRE(counts["RADIO_FRAGMENT"] >= 200);
  REQUIRE(counts["IN_" + channel] > 30);
  REQUIRE(counts["IN_" + channel] < 50);
  REQUIRE(first == messages_of("b.lcm"));
}

TEST_CASE("a bridge in another network namespace still hears the radio of its own") {
  RadioStage stage({0});
  stage.start(0);
  // The holder of a namespace within this one: its private bus is out of our hearing, its radio is not.
  ChildProcess holder("../../../bin/covey_tools/in_namespace", {"--", "/usr/bin/sleep", "60"},
                      stage.file("holder"));
  // When the command runs, its network is ready.
  REQUIRE(stage.wait_until(
      [&] { return read_text("/proc/" + std::to_string(holder.pid()) + "/comm") == "sleep\n"; }));
  const std::string holder_net = "/proc/" + std::to_string(holder.pid()) + "/ns/net";
  REQUIRE(std::filesystem::read_symlink(holder_net) != std::filesystem::read_symlink("/proc/self/ns/net"));
  ChildProcess inside("radio_bridge", {"--robot", "1", "--netns", holder_net}, stage.file("inside"));
  const bool heard = stage.wait_until([&] { return stage.counter(0, "received_packets/control") > 1; });
  INFO(inside.output());
  REQUIRE(heard);
  inside.kill(SIGTERM);
  REQUIRE(inside.wait(10.0) == 0);
}

}  // namespace
}  // namespace covey
