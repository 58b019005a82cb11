// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// A radio network in virtual time, for protocols that are state machines on messages: N agents numbered from
// 0, and a seeded network that loses, delays, reorders and doubles what they send each other. The same seed
// and the same calls give the same run.
//
//   SimNetwork<std::vector<std::uint8_t>> network(seed, {.loss = 0.2, .delay_us = 100'000, .jitter_us =
//   50'000}, 3); network.send(0, kEveryone, bytes, now); network.deliver_until(now + 10'000, [&](int to, int
//   from, const auto& message, Utime t) { ... network.send(...) });
//
// Every receiver's copy meets its own luck, as on the air. Jitter larger than the spacing of messages
// reorders them. Partitions and isolation act at the moment of sending; what is in the air still arrives. All
// times in microseconds.

#include <algorithm>
#include <cstdint>
#include <map>
#include <queue>
#include <random>
#include <set>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/base/time.h"

namespace covey {

inline constexpr int kEveryone = -1;

struct LinkFaults {
  double loss = 0.0;       // probability per copy, [0, 1]
  Utime delay_us = 0;      // of every copy
  Utime jitter_us = 0;     // plus uniform in [0, jitter_us]
  double duplicate = 0.0;  // probability that a copy arrives twice (each with its own jitter)
};

template <typename Message>
class SimNetwork {
 public:
  SimNetwork(std::uint64_t seed, LinkFaults faults, int agents)
      : random_(seed), faults_(faults), agents_(agents) {}

  // To one agent, or to all others with kEveryone.
  void send(int from, int to, const Message& message, Utime now) {
    ++sent_;
    for (int receiver = 0; receiver < agents_; ++receiver) {
      if (receiver == from || (to != kEveryone && receiver != to)) continue;
      const int copies = uniform() < faults_.duplicate ? 2 : 1;
      for (int copy = 0; copy < copies; ++copy) {
        const bool lost = uniform() < faults_.loss;
        const Utime delay =
            faults_.delay_us + static_cast<Utime>(uniform() * static_cast<double>(faults_.jitter_us));
        if (lost || !connected(from, receiver)) {
          ++lost_;
        } else {
          in_flight_.push({now + delay, order_++, from, receiver, message});
        }
      }
    }
  }

  // Calls deliver(to, from, message, t) for everything due until `end`, in order of arrival. `deliver` may
  // send.
  template <typename Deliver>
  void deliver_until(Utime end, Deliver deliver) {
    while (!in_flight_.empty() && in_flight_.top().arrival <= end) {
      const Flight flight = in_flight_.top();
      in_flight_.pop();
      if (flight.order < deaf_before_[flight.to]) continue;
      ++delivered_;
      deliver(flight.to, flight.from, flight.message, flight.arrival);
    }
  }

  bool idle() const { return in_flight_.empty(); }
  Utime next_arrival() const {
    COVEY_CHECK(!idle());
    return in_flight_.top().arrival;
  }

  void set_faults(LinkFaults faults) { faults_ = faults; }

  // Links work both ways, and stay cut until they are mended.
  void cut(int a, int b) { cut_.insert(std::minmax(a, b)); }
  void mend(int a, int b) { cut_.erase(std::minmax(a, b)); }
  void partition(const std::set<int>& a, const std::set<int>& b) {
    for (const int i : a) {
      for (const int j : b) cut(i, j);
    }
  }
  void isolate(int agent) {
    for (int other = 0; other < agents_; ++other) cut(agent, other);
  }
  // Each robot hears only the one before it and the one after it.
  void chain() {
    for (int a = 0; a < agents_; ++a) {
      for (int b = a + 2; b < agents_; ++b) cut(a, b);
    }
  }
  void heal() { cut_.clear(); }
  bool connected(int a, int b) const { return cut_.count(std::minmax(a, b)) == 0; }

  // The agent is started anew: what is on its way to it now is lost; what it has sent still arrives.
  void restart(int agent) { deaf_before_[agent] = order_; }

  std::int64_t sent() const { return sent_; }            // calls of send
  std::int64_t lost() const { return lost_; }            // copies that the network swallowed
  std::int64_t delivered() const { return delivered_; }  // copies handed over

 private:
  struct Flight {
    Utime arrival;
    std::int64_t order;  // of sending: breaks ties, so that equal arrivals keep their order
    int from;
    int to;
    Message message;
    bool operator<(const Flight& other) const {
      return std::pair(arrival, order) >
             std::pair(other.arrival, other.order);  // the queue's top is the earliest
    }
  };

  double uniform() { return static_cast<double>(random_() >> 11) * 0x1p-53; }

  std::mt19937_64 random_;
  LinkFaults faults_;
  int agents_;
  std::int64_t order_ = 0;
  std::int64_t sent_ = 0;
  std::int64_t lost_ = 0;
  std::int64_t delivered_ = 0;
  std::priority_queue<Flight> in_flight_;
  std::set<std::pair<int, int>> cut_;
  std::map<int, std::int64_t> deaf_before_;
};

}  // namespace covey
