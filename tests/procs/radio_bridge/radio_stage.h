// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Real radio_bridges over real multicast, in the private network that the test runs in: an ear and a voice on each robot's
// bus, and a socket on the radio. Nothing waits for a time to pass, but until something is so.

#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>

#include "core/radio/addressing.h"
#include "procs/common/bus.h"
#include "procs/radio_bridge/radio_socket.h"
#include "tests/child_process.h"
#include "tests/wait_until.h"

namespace covey {

constexpr double kPatienceS = 60.0;

// A channel whose small messages cross as themselves; its large ones, as everywhere, in fragments that are acknowledged.
inline std::string a_channel() {
  const auto found = std::find_if(radio_table().begin(), radio_table().end(),
                                  [](const auto& entry) { return !entry.second.reliable; });
  REQUIRE(found != radio_table().end());
  return found->first;
}

// Looks like a message of that channel; the bridge reads no further than the addresses.
inline Bytes message_for(const std::string& channel, int from, int to, std::size_t bytes,
                         std::uint32_t tag = 0) {
  const auto fingerprint = static_cast<std::uint64_t>(radio_table().at(channel).fingerprint);
  Bytes message;
  radio::append_u32(message, static_cast<std::uint32_t>(fingerprint >> 32));
  radio::append_u32(message, static_cast<std::uint32_t>(fingerprint));
  radio::append_u32(message, 0);
  radio::append_u32(message, 1'000'000);
  radio::append_u32(message, static_cast<std::uint32_t>(from));
  radio::append_u32(message, static_cast<std::uint32_t>(to));
  radio::append_u32(message, tag);
  while (message.size() < bytes) message.push_back(static_cast<std::uint8_t>(message.size() + tag));
  return message;
}

class RadioStage {
 public:
  struct Robot {
    std::unique_ptr<Bus> bus;
    std::unique_ptr<ChildProcess> bridge;
    std::map<std::string, std::vector<Bytes>> heard;  // IN_x -> messages
    status_t status{};
  };

  explicit RadioStage(const std::vector<int>& robots)
      : folder_(std::filesystem::temp_directory_path() / ("covey_radio_" + std::to_string(getpid()))) {
    std::filesystem::create_directories(folder_);
    for (const int id : robots) {
      Robot& robot = robots_[id];
      robot.bus = std::make_unique<Bus>(BusOptions{robot_bus_url(id), {}, nullptr}, loop_, status_);
      robot.bus->subscribe_raw("IN_.*", [&robot](const std::string& channel, const Bytes& bytes) {
        robot.heard[channel].push_back(bytes);
      });
      robot.bus->subscribe(kStatus, [&robot](const status_t& status) { robot.status = status; });
    }
  }
  ~RadioStage() { std::filesystem::remove_all(folder_); }
  RadioStage(const RadioStage&) = delete;
  RadioStage& operator=(const RadioStage&) = delete;

  // Starts a bridge and waits for its first STATUS.
  void start(int id, std::vector<std::string> arguments = {}) {
    Robot& robot = robots_.at(id);
    const Utime before = robot.status.start_utime;
    arguments.insert(arguments.end(), {"--robot", std::to_string(id)});
    robot.bridge =
        std::make_unique<ChildProcess>("radio_bridge", arguments, file("log" + std::to_string(id)));
    const bool started = wait_until([&] { return robot.status.start_utime > before; });
    INFO(robot.bridge->output());
    REQUIRE(started);
  }

  Robot& robot(int id) { return robots_.at(id); }
  EventLoop& loop() { return loop_; }
  std::string file(const std::string& name) const { return (folder_ / name).string(); }

  std::size_t heard(int id, const std::string& channel) {
    return robots_.at(id).heard["IN_" + channel].size();
  }

  std::int64_t counter(int id, const std::string& name) const {
    const status_t& status = robots_.at(id).status;
    for (std::size_t i = 0; i < status.counter_names.size(); ++i) {
      if (status.counter_names[i] == name) return status.counter_values[i];
    }
    return 0;
  }

  bool wait_until(const std::function<bool()>& done) { return covey::wait_until(loop_, kPatienceS, done); }

 private:
  std::filesystem::path folder_;
  EventLoop loop_;
  Status status_;
  std::map<int, Robot> robots_;
};

}  // namespace covey
