// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The numbered messages of one sender, put together again: each is handed over exactly once, and what has
// arrived of each can be said in an ack. The sender is not trusted: every number is checked before anything
// is allocated, pieces cannot overlap since a piece's place follows from its number, and memory is bounded
// (kMaxPartialBytes: the message that was not touched for longest is dropped; its sender learns so from the
// next ack and repeats it).

#include <bitset>
#include <deque>
#include <map>
#include <optional>
#include <vector>

#include "core/base/time.h"
#include "core/radio/wire.h"

namespace covey::radio {

inline constexpr std::size_t kMaxPartialBytes = 1024 * 1024;  // of unfinished messages, per sender
inline constexpr Utime kPartialTimeoutUs = 60 * kUsPerSecond;
inline constexpr std::size_t kRepeatedAcks = 8;

// What has arrived of one message: fragments 0 ... below - 1, and below + 1 + i for every bit i of the mask.
struct Arrived {
  std::int64_t message = 0;
  std::int32_t below = 0;
  std::uint64_t mask = 0;
};

class Assembler {
 public:
  struct Result {
    const char* refused = nullptr;
    std::optional<Bytes> body;  // of a message that this fragment completed
  };

  // Refusals: "fragment_numbers", "fragment_length", "fragment_window", "fragment_stale",
  // "fragment_inconsistent", "fragment_duplicate".
  Result add(const radio_fragment_t& fragment, Utime now);

  // Messages touched since the last call, at most `most` of them, and with them, in case its ack was lost,
  // each of the last kRepeatedAcks that were completed.
  std::vector<Arrived> take_arrived(std::size_t most);
  bool has_arrived() const { return !touched_.empty(); }

  // Forgets unfinished messages that were not touched for kPartialTimeoutUs; says how many.
  int expire(Utime now);

  std::size_t partial_bytes() const { return partial_bytes_; }

 private:
  struct Partial {
    std::vector<bool> have;
    std::int32_t below = 0;
    Bytes body;
    Utime touched = 0;
  };

  void advance_floor(std::int64_t floor);
  void make_room(std::size_t bytes);
  void drop(std::map<std::int64_t, Partial>::iterator partial);
  bool done(std::int64_t message) const { return done_[static_cast<std::size_t>(message % kMessageWindow)]; }

  std::int64_t floor_ = 0;  // the sender repeats nothing below
  std::bitset<kMessageWindow>
      done_;  // of floor_ ... floor_ + kMessageWindow - 1, by number modulo the window
  std::map<std::int64_t, Partial> partial_;
  std::size_t partial_bytes_ = 0;
  std::map<std::int64_t, std::int32_t> touched_;                      // number -> fragments
  std::deque<std::pair<std::int64_t, std::int32_t>> last_completed_;  // number, fragments
};

}  // namespace covey::radio
