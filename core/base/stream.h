// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Numbered streams: messages that a lossy bus must not lose. Every message carries (stream, number): the
// stream names one run of numbers (a segment of keyframes, one run of a loop finder), numbers count from 0
// without gaps. The reader hands messages on once and in order; where it sees a gap it asks for it again
// (RESEND), and the writer's heads (STREAM_HEAD, once a second: "0 ... next - 1 have been sent") tell it of a
// lost tail and of streams it never heard. The writer keeps what it sent.
//
// Both sides are state machines without sockets or clocks: input and time in, actions out. Guarantees,
// whatever is lost, doubled, reordered or restarted:
//  - within a stream the numbers handed on grow strictly; a jump happens only over what is lost for good, and
//    is counted: what the writer's history no longer holds (head.first), or what a writer that claims to have
//    it does not send after `give_up_after` requests (a log that is played has no writer that answers), or what
//    nothing has been heard of, neither message nor head of its stream, over `give_up_silent_after` requests (its
//    writer is gone for good): then all that waits is handed on, and nothing more is asked for until the stream is
//    heard again;
//  - work is bounded: requests are limited in span and number and back off without progress; answers are
//    limited in bytes a tick, and a number that several readers ask for within a tick is sent once;
//  - memory is bounded by history_bytes on the writer's side, by waiting_bytes and max_streams on the reader's.
// A writer that restarts with the same stream and the same messages is heard as duplicates until it comes
// past what is known.

#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "core/base/bytes.h"
#include "core/base/time.h"

namespace covey {

struct StreamMessage {
  std::int64_t stream = 0;
  std::int32_t number = 0;
  Bytes bytes;
};

struct StreamGap {
  std::int64_t stream = 0;
  std::int32_t first = 0;
  std::int32_t last = 0;
};

struct StreamHead {
  std::int64_t stream = 0;
  std::int32_t first = 0;  // oldest number that can still be sent again
  std::int32_t next = 0;   // numbers before it have been sent
};

// The next number that a reader wants of each stream; those not named begin at 0.
using StreamPositions = std::map<std::int64_t, std::int32_t>;

struct StreamReaderOptions {
  Utime reorder_us = 20'000;             // a gap may close by itself for so long
  Utime first_backoff_us = 100'000;      // from one request to the next without progress; doubles ...
  Utime longest_backoff_us = 2'000'000;  // ... up to this
  std::int32_t span = 128;               // numbers from the first missing one that are asked for at once
  std::size_t ranges = 16;               // gaps that are asked for at once
  int give_up_after = 30;  // requests without progress to a writer that says it has the number (about 50 s)
  int give_up_silent_after = 34;         // requests without a sign of the stream's writer (about 60 s)
  std::int32_t furthest = 1 << 20;       // a number further ahead than this is impossible
  std::size_t waiting_bytes = 32 << 20;  // held back behind gaps, all streams together
  std::size_t max_streams = 4096;
};

struct StreamReaderCounts {
  std::int64_t duplicate = 0;   // came again: by the bus, by RESEND, by a writer that restarted
  std::int64_t impossible = 0;  // negative or absurdly large numbers, heads that contradict themselves
  std::int64_t refused = 0;     // no room for another stream or for another waiting message
  std::int64_t lost = 0;        // numbers jumped over, for good
  std::int64_t requests = 0;    // gaps asked for
};

struct StreamActions {
  std::vector<StreamMessage> deliver;  // in this order
  std::vector<StreamGap> resend;       // to be published as RESEND
};

class StreamReader {
 public:
  explicit StreamReader(StreamReaderOptions options = {}, const StreamPositions& have = {});

  StreamActions on_message(StreamMessage message, Utime now);
  StreamActions on_head(const StreamHead& head, Utime now);
  StreamActions on_tick(Utime now);

  const StreamReaderCounts& counts() const { return counts_; }
  std::size_t waiting() const;  // messages held back behind gaps

 private:
  struct Stream {
    std::int32_t expected = 0;  // the next number to hand on
    std::int32_t known = 0;     // numbers before it exist
    std::int32_t head_first = 0;
    std::int32_t head_next = 0;
    std::map<std::int32_t, Bytes> waiting;
    bool behind = false;  // something is missing, and a request is due at:
    Utime request_us = 0;
    Utime backoff_us = 0;
    int unanswered = 0;
    int unheard = 0;  // requests since the writer's last sign
    std::int32_t asked_until = 0;
  };

  Stream* find(std::int64_t name);
  bool wait(Stream& stream, std::int32_t number, Bytes bytes);
  void hand_on(std::int64_t name, Stream& stream, StreamActions& actions);
  void jump(std::int64_t name, Stream& stream, std::int32_t to, StreamActions& actions);
  void leave(std::int64_t name, Stream& stream, StreamActions& actions);
  void note_progress(Stream& stream, Utime now);
  void update_gap(Stream& stream, Utime now);
  void request(std::int64_t name, Stream& stream, StreamActions& actions);

  StreamReaderOptions options_;
  StreamReaderCounts counts_;
  std::map<std::int64_t, Stream> streams_;
  std::size_t waiting_bytes_ = 0;
};

struct StreamWriterOptions {
  std::size_t history_bytes = 64 << 20;  // all streams of the channel together; the oldest messages go first
  std::size_t resend_bytes_per_tick = 65536;  // and always at least one message
  std::size_t max_pending = 8192;  // numbers asked for and not sent yet; more are left to the next request
  Utime head_period_us = 1'000'000;
};

struct StreamWriterCounts {
  std::int64_t out_of_order = 0;  // published with a number that is not the next one: not kept
  std::int64_t resent = 0;
  std::int64_t forgotten = 0;  // asked for, but beyond the history
};

struct StreamWriterActions {
  std::vector<StreamMessage> send;
  std::vector<StreamHead> heads;  // to be published as STREAM_HEAD
};

class StreamWriter {
 public:
  explicit StreamWriter(StreamWriterOptions options = {});

  // Keeps what is being sent. A stream may begin at any number; after that each number follows the last, else
  // false.
  bool on_publish(const StreamMessage& message);
  void on_resend(const StreamGap& gap);
  StreamWriterActions on_tick(Utime now);

  const StreamWriterCounts& counts() const { return counts_; }

 private:
  struct Stream {
    std::int32_t first = 0;
    std::deque<Bytes> messages;  // first, first + 1, ...
    std::int32_t next() const { return first + static_cast<std::int32_t>(messages.size()); }
  };

  StreamWriterOptions options_;
  StreamWriterCounts counts_;
  std::map<std::int64_t, Stream> streams_;
  std::deque<std::int64_t> order_;  // whose message is the oldest, the next oldest, ...
  std::size_t history_bytes_ = 0;
  std::set<std::pair<std::int64_t, std::int32_t>> pending_;
  Utime heads_due_us_ = 0;
};

}  // namespace covey
