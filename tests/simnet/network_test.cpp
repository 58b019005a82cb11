// SPDX-License-Identifier: BSD-3-Clause
#include "tests/simnet/network.h"

#include <algorithm>
#include <catch2/catch.hpp>

namespace covey {
namespace {

struct Arrival {
  int to;
  int from;
  int message;
  Utime t;
  bool operator==(const Arrival&) const = default;
};

std::vector<Arrival> run(SimNetwork<int>& network, Utime end) {
  std::vector<Arrival> arrivals;
  network.deliver_until(end, [&](int to, int from, int message, Utime t) {
    arrivals.push_back({to, from, message, t});
  });
  return arrivals;
}

std::vector<Arrival> lossy_run(std::uint64_t seed) {
  SimNetwork<int> network(seed, {.loss = 0.3, .delay_us = 100, .jitter_us = 50, .duplicate = 0.1}, 4);
  for (int i = 0; i < 1000; ++i) network.send(i % 4, kEveryone, i, i);
  return run(network, 10'000);
}

TEST_CASE("a perfect network delivers to the addressed, in order and after the delay") {
  SimNetwork<int> network(1, {.delay_us = 10}, 3);
  network.send(0, kEveryone, 7, 0);
  network.send(1, 2, 8, 0);
  REQUIRE(run(network, 9).empty());
  REQUIRE(run(network, 10) == std::vector<Arrival>{{1, 0, 7, 10}, {2, 0, 7, 10}, {2, 1, 8, 10}});
  REQUIRE(network.idle());
}

TEST_CASE("faults happen at their rate, reorder, and repeat with the seed") {
  const auto arrivals = lossy_run(5);
  REQUIRE(arrivals == lossy_run(5));
  REQUIRE(arrivals != lossy_run(6));
  REQUIRE(static_cast<double>(arrivals.size()) == Approx(3000 * 1.1 * 0.7).epsilon(0.05));
  REQUIRE(std::is_sorted(arrivals.begin(), arrivals.end(), [](auto& a, auto& b) { return a.t < b.t; }));
  REQUIRE_FALSE(std::is_sorted(arrivals.begin(), arrivals.end(),
                               [](auto& a, auto& b) { return a.message < b.message; }));
}

TEST_CASE("a message sent while delivering is delivered in the same run when due") {
  SimNetwork<int> network(1, {.delay_us = 10}, 2);
  network.send(0, 1, 0, 0);
  int last = -1;
  network.deliver_until(35, [&](int to, int from, int message, Utime t) {
    last = message;
    network.send(to, from, message + 1, t);
  });
  REQUIRE(last == 2);
  REQUIRE(network.next_arrival() == 40);
}

TEST_CASE("partitions, isolation, healing and restarts") {
  SimNetwork<int> network(1, {}, 4);
  network.partition({0, 1}, {2, 3});
  network.send(0, kEveryone, 1, 0);
  REQUIRE(run(network, 0) == std::vector<Arrival>{{1, 0, 1, 0}});
  network.heal();
  network.isolate(3);
  network.send(0, kEveryone, 2, 1);
  REQUIRE(run(network, 1) == std::vector<Arrival>{{1, 0, 2, 1}, {2, 0, 2, 1}});
  network.heal();
  network.send(0, kEveryone, 3, 2);
  network.restart(1);
  network.send(1, 0, 4, 2);
  REQUIRE(run(network, 2) == std::vector<Arrival>{{2, 0, 3, 2}, {3, 0, 3, 2}, {0, 1, 4, 2}});
}

TEST_CASE("links are cut and mended one by one") {
  SimNetwork<int> network(1, {}, 4);
  network.chain();
  network.send(1, kEveryone, 1, 0);
  REQUIRE(run(network, 0) == std::vector<Arrival>{{0, 1, 1, 0}, {2, 1, 1, 0}});
  network.mend(3, 1);
  network.cut(0, 1);
  network.send(1, kEveryone, 2, 1);
  REQUIRE(run(network, 1) == std::vector<Arrival>{{2, 1, 2, 1}, {3, 1, 2, 1}});
}

}  // namespace
}  // namespace covey
