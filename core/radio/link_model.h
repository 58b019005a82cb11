// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// A radio link that is worse than the cable it runs on: what one robot hears of the others, in event time.
//
//   loss: 0.2            probability that a datagram is not heard; every receiver meets its own luck
//   delay_ms: 100        of every datagram
//   jitter_ms: 10        plus uniform in [0, jitter_ms]; more than the spacing of datagrams reorders them
//   duplicate: 0.0       probability of a second copy
//   rate_bytes_per_s: 0  what a robot may send; 0: no limit (the sender's own budget, see Budget)
//   burst_bytes: 16000   what it may send at once after a pause
//   seed: 1
//   epoch_utime: 0       us; contacts count from here, and all bridges of a team want the same. 0: from the first
//                        datagram that this run of this bridge hears; bin/demo sets its own start instead
//   contacts:            who hears whom when; absent: everyone always hears everyone
//     - {a: 0, b: 1, from_s: 0, until_s: 60}
//
// A contact works both ways. Loss, delay and contacts act where a datagram is received, the rate where it is
// sent.

#include <optional>
#include <queue>
#include <random>
#include <vector>

#include "core/base/config.h"
#include "core/base/time.h"
#include "core/radio/bytes.h"

namespace covey::radio {

struct Contact {
  int a = 0;
  int b = 0;
  double from_s = 0.0;  // since epoch_utime
  double until_s = 0.0;
};

struct LinkModelOptions {
  double loss = 0.0;
  double delay_ms = 0.0;
  double jitter_ms = 0.0;
  double duplicate = 0.0;
  double rate_bytes_per_s = 0.0;
  double burst_bytes = 16'000.0;
  std::int64_t seed = 1;
  Utime epoch_utime = 0;
  std::optional<std::vector<Contact>> contacts = std::nullopt;
};

LinkModelOptions read_link_model(ConfigSection& section);

class LinkModel {
 public:
  LinkModel(int own_robot, LinkModelOptions options);

  // A datagram of `from` that reached this robot's antenna. Null when it will be heard, otherwise why it will
  // not: "simulated_loss", "no_contact", "simulated_backlog".
  const char* offer(int from, ByteView datagram, Utime now);

  // What is heard by now, in order of arrival.
  std::vector<Bytes> take_due(Utime now);

  bool in_contact(int from, Utime now) const;

 private:
  struct Heard {
    Utime arrival;
    std::uint64_t order;
    Bytes datagram;
    bool operator<(const Heard& other) const {
      return std::pair(arrival, order) > std::pair(other.arrival, other.order);
    }
  };

  double uniform() { return static_cast<double>(random_() >> 11) * 0x1p-53; }

  int own_robot_;
  LinkModelOptions options_;
  std::mt19937_64 random_;
  std::uint64_t order_ = 0;
  std::optional<Utime> epoch_;
  std::priority_queue<Heard> in_flight_;
};

// A token bucket: how many bytes may be sent now.
class Budget {
 public:
  Budget(double rate_bytes_per_s, double burst_bytes)
      : rate_(rate_bytes_per_s), burst_(burst_bytes), tokens_(burst_bytes) {}

  // True while anything is left: a datagram may overdraw the bucket, and the next one waits for it.
  bool open(Utime now);
  void spend(std::size_t bytes);

 private:
  double rate_;  // 0: no limit
  double burst_;
  double tokens_;
  std::optional<Utime> filled_;
};

}  // namespace covey::radio
