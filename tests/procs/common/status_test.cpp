// SPDX-License-Identifier: BSD-3-Clause
#include "procs/common/status.h"

#include <arpa/inet.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>

#include "core/base/bytes.h"

namespace covey {
namespace {

TEST_CASE("STATUS says counters, gauges and samples, and survives the bus") {
  Status status;
  status.count("in/KEYFRAME");
  status.count("in/KEYFRAME", 2);
  status.gauge("keyframes", 7.0);
  for (int i = 1; i <= 1000; ++i) status.sample("solve_ms", i);
  status_t message{};
  REQUIRE(decode(encode(status.to_message(5)), message));
  CHECK(message.utime == 5);
  CHECK(message.phase == "starting");
  CHECK(message.counter_names == std::vector<std::string>{"in/KEYFRAME"});
  CHECK(message.counter_values == std::vector<std::int64_t>{3});
  CHECK(message.gauge_names ==
        std::vector<std::string>{"keyframes", "solve_ms_max", "solve_ms_mean", "solve_ms_p99"});
  CHECK(message.gauge_values[1] == 1000.0);
  CHECK(message.gauge_values[2] == Approx((745.0 + 1000.0) / 2.0));  // the last 256
  CHECK(message.gauge_values[3] == Approx(997.0));
}

TEST_CASE("A change of phase is told, a repetition is not") {
  Status status;
  int told = 0;
  status.on_phase_change([&told] { ++told; });
  status.set_phase("running");
  status.set_phase("running");
  status.set_phase("idle");
  CHECK(told == 2);
}

TEST_CASE("What the kernel dropped is found by port, for the sockets of this process") {
  const int receiver = socket(AF_INET, SOCK_DGRAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  REQUIRE(bind(receiver, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0);
  socklen_t length = sizeof address;
  REQUIRE(getsockname(receiver, reinterpret_cast<sockaddr*>(&address), &length) == 0);
  const int small = 4096;
  setsockopt(receiver, SOL_SOCKET, SO_RCVBUF, &small, sizeof small);
  const int port = ntohs(address.sin_port);
  CHECK(kernel_drops().at(port) == 0);
  const int sender = socket(AF_INET, SOCK_DGRAM, 0);
  const std::array<char, 1000> data{};
  for (int i = 0; i < 100; ++i) {
    sendto(sender, data.data(), data.size(), 0, reinterpret_cast<sockaddr*>(&address), sizeof address);
  }
  CHECK(kernel_drops().at(port) > 50);
  close(sender);
  close(receiver);
  CHECK(kernel_drops().count(port) == 0);
}

TEST_CASE("Resident memory is in megabytes") {
  CHECK(resident_mb() > 1.0);
  CHECK(resident_mb() < 4000.0);
}

}  // namespace
}  // namespace covey
