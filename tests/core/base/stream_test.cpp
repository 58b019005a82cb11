// SPDX-License-Identifier: BSD-3-Clause
#include "core/base/stream.h"

#include <catch2/catch.hpp>
#include <vector>

#include "tests/simnet/network.h"

namespace covey {
namespace {

constexpr Utime kTick = 20'000;
constexpr std::int64_t kRun = 1'000'000;  // a stream's name

StreamMessage numbered(std::int64_t stream, std::int32_t number, std::size_t bytes = 100) {
  StreamMessage message{stream, number, Bytes(bytes, static_cast<std::uint8_t>(number))};
  return message;
}

// One writer (agent 0) and readers (1 ...) over a bad network in virtual time.
class Bench {
 public:
  struct Packet {  // one of them
    std::vector<StreamMessage> message = {};
    std::vector<StreamGap> gap = {};
    std::vector<StreamHead> head = {};
  };

  Bench(std::uint64_t seed, LinkFaults faults, int readers, StreamWriterOptions writer_options = {})
      : network_(seed, faults, readers + 1), writer_options_(writer_options), writer_(writer_options) {
    for (int i = 0; i < readers; ++i) readers_.emplace_back();
  }

  void publish(const StreamMessage& message) {
    REQUIRE(writer_.on_publish(message));
    network_.send(0, kEveryone, {.message = {message}}, now_);
  }

  void step() {
    now_ += kTick;
    network_.deliver_until(now_,
                           [this](int to, int, const Packet& packet, Utime t) { receive(to, packet, t); });
    const StreamWriterActions actions = writer_.on_tick(now_);
    for (const auto& message : actions.send) network_.send(0, kEveryone, {.message = {message}}, now_);
    for (const auto& head : actions.heads) network_.send(0, kEveryone, {.head = {head}}, now_);
    for (std::size_t i = 0; i < readers_.size(); ++i) act(i, readers_[i].machine.on_tick(now_), now_);
  }

  void run(double seconds) {
    for (const Utime end = now_ + from_seconds(seconds); now_ < end;) step();
  }

  void restart_reader(std::size_t i, const StreamPositions& have = {}) {
    readers_[i].machine = StreamReader({}, have);
    readers_[i].got.clear();
  }
  void restart_writer() { writer_ = StreamWriter(writer_options_); }

  const std::vector<std::int32_t>& got(std::size_t reader, std::int64_t stream = kRun) {
    return readers_[reader].got[stream];
  }
  const StreamReader& reader(std::size_t i) const { return readers_[i].machine; }
  const StreamWriter& writer() const { return writer_; }

 private:
  struct Reader {
    StreamReader machine;
    std::map<std::int64_t, std::vector<std::int32_t>> got;
  };

  void receive(int to, const Packet& packet, Utime t) {
    if (to == 0) {
      for (const auto& gap : packet.gap) writer_.on_resend(gap);
      return;
    }
    const auto i = static_cast<std::size_t>(to - 1);
    for (const auto& message : packet.message) act(i, readers_[i].machine.on_message(message, t), t);
    for (const auto& head : packet.head) act(i, readers_[i].machine.on_head(head, t), t);
  }

  void act(std::size_t i, const StreamActions& actions, Utime t) {
    for (const auto& message : actions.deliver) {
      REQUIRE(message.bytes == numbered(message.stream, message.number).bytes);
      readers_[i].got[message.stream].push_back(message.number);
    }
    for (const auto& gap : actions.resend) network_.send(static_cast<int>(i) + 1, 0, {.gap = {gap}}, t);
  }

  SimNetwork<Packet> network_;
  StreamWriterOptions writer_options_;
  StreamWriter writer_;
  std::vector<Reader> readers_;
  Utime now_ = kRun;
};

std::vector<std::int32_t> range(std::int32_t first, std::int32_t end) {
  std::vector<std::int32_t> numbers;
  for (std::int32_t number = first; number < end; ++number) numbers.push_back(number);
  return numbers;
}

constexpr LinkFaults kBad{.loss = 0.3, .delay_us = 5'000, .jitter_us = 80'000, .duplicate = 0.1};

TEST_CASE("A good bus needs no requests") {
  Bench bench(1, {.delay_us = 1'000}, 1);
  for (int number = 0; number < 200; ++number) {
    bench.publish(numbered(kRun, number));
    bench.step();
  }
  bench.run(1.0);
  CHECK(bench.got(0) == range(0, 200));
  CHECK(bench.reader(0).counts().requests == 0);
  CHECK(bench.writer().counts().resent == 0);
}

TEST_CASE(
    "Every message arrives once and in order, whatever is lost, doubled or reordered, the tail included") {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Bench bench(seed, kBad, 3);
    for (int number = 0; number < 300; ++number) {
      bench.publish(numbered(kRun, number));
      bench.step();
    }
    bench.run(20.0);
    for (std::size_t i = 0; i < 3; ++i) {
      CHECK(bench.got(i) == range(0, 300));
      CHECK(bench.reader(i).counts().lost == 0);
      CHECK(bench.reader(i).waiting() == 0);
    }
  }
}

TEST_CASE("A reader that restarts hears everything again, or goes on where it says it was") {
  Bench bench(7, kBad, 2);
  for (int number = 0; number < 1000; ++number) {
    bench.publish(numbered(kRun, number));
    if (number % 10 == 0) bench.step();
  }
  bench.restart_reader(0);
  bench.restart_reader(1, {{kRun, 600}});
  bench.run(30.0);
  CHECK(bench.got(0) == range(0, 1000));
  CHECK(bench.got(1) == range(600, 1000));
}

TEST_CASE("A writer that restarts with the same messages is heard on without a repetition") {
  Bench bench(3, kBad, 1);
  for (int number = 0; number < 100; ++number) {
    bench.publish(numbered(kRun, number));
    bench.step();
  }
  bench.restart_writer();
  for (int number = 0; number < 150; ++number) {
    bench.publish(numbered(kRun, number));
    bench.step();
  }
  bench.run(20.0);
  CHECK(bench.got(0) == range(0, 150));
  CHECK(bench.reader(0).counts().lost == 0);
}

TEST_CASE("A writer that restarts with a new stream leaves the old one as far as it came") {
  Bench bench(4, kBad, 1);
  for (int number = 0; number < 50; ++number) {
    bench.publish(numbered(kRun, number));
    bench.step();
  }
  const auto before = bench.got(0);
  bench.restart_writer();
  for (int number = 0; number < 50; ++number) {
    bench.publish(numbered(kRun + 5, number));
    bench.step();
  }
  bench.run(20.0);
  CHECK(bench.got(0, kRun + 5) == range(0, 50));
  CHECK(bench.got(0) == range(0, static_cast<std::int32_t>(bench.got(0).size())));
  CHECK(bench.got(0).size() >= before.size());
}

TEST_CASE("What the history no longer holds is jumped over and counted, and only that") {
  Bench bench(5, {.delay_us = 1'000}, 1, {.history_bytes = 5'000});  // 50 messages
  for (int number = 0; number < 200; ++number) bench.publish(numbered(kRun, number));
  bench.restart_reader(0);
  bench.run(1.0);
  bench.restart_reader(0);
  bench.run(10.0);
  CHECK(bench.got(0) == range(150, 200));
  CHECK(bench.reader(0).counts().lost == 150);
}

TEST_CASE("A log has no writer that answers: the reader gives up after a bounded number of requests") {
  StreamReader reader({.give_up_after = 5});
  reader.on_message(numbered(kRun, 0), 0);
  CHECK(reader.on_message(numbered(kRun, 3), 0).deliver.empty());
  std::vector<std::int32_t> got;
  Utime when = 0;
  for (Utime now = 0; now < 60 * kUsPerSecond && got.empty(); now += kTick) {
    if (now % kUsPerSecond == 0) reader.on_head({kRun, 0, 4}, now);
    for (const auto& message : reader.on_tick(now).deliver) got.push_back(message.number);
    when = now;
  }
  CHECK(got == std::vector<std::int32_t>{3});
  CHECK(reader.counts().lost == 2);
  CHECK(reader.counts().requests == 5);
  CHECK(when > kUsPerSecond);
}

TEST_CASE("A writer that is silent is asked ever more slowly, and after a minute what waits is handed on") {
  StreamReader reader;
  for (const int number : {0, 3, 4, 7}) reader.on_message(numbered(kRun, number), 0);
  std::vector<std::int32_t> got;
  Utime when = 0;
  for (Utime now = 0; now < 600 * kUsPerSecond; now += kTick) {
    for (const auto& message : reader.on_tick(now).deliver) {
      got.push_back(message.number);
      when = now;
    }
  }
  CHECK(got == std::vector<std::int32_t>{3, 4, 7});
  CHECK(to_seconds(when) == Approx(60.0).margin(3.0));
  CHECK(reader.counts().lost == 4);
  CHECK(reader.counts().requests < 100);  // and none after that
  CHECK(reader.on_message(numbered(kRun, 8), 600 * kUsPerSecond).deliver.size() == 1);
}

TEST_CASE(
    "A writer that comes again within a minute is given nothing up, nor is a tail that nothing waits "
    "behind") {
  StreamReader reader;
  reader.on_message(numbered(kRun, 2), 0);
  Utime now = 0;
  for (; now < 50 * kUsPerSecond; now += kTick) REQUIRE(reader.on_tick(now).deliver.empty());
  reader.on_message(numbered(kRun, 0), now);
  for (; now < 100 * kUsPerSecond; now += kTick) REQUIRE(reader.on_tick(now).deliver.empty());
  CHECK(reader.on_message(numbered(kRun, 1), now).deliver.size() == 2);
  reader.on_head({kRun, 0, 5}, now);
  for (; now < 300 * kUsPerSecond; now += kTick) reader.on_tick(now);
  CHECK(reader.counts().lost == 0);
  CHECK(reader.on_tick(now + 10 * kUsPerSecond).resend.empty());
  reader.on_head({kRun, 0, 5}, now);
  const auto gaps = reader.on_tick(now + kUsPerSecond).resend;
  REQUIRE(gaps.size() == 1);
  CHECK(gaps[0].first == 3);
}

TEST_CASE("Nonsense is counted and changes nothing") {
  StreamReader reader({.furthest = 1000, .max_streams = 3});
  CHECK(reader.on_message(numbered(kRun, -1), 0).deliver.empty());
  CHECK(reader.on_message(numbered(kRun, 5000), 0).deliver.empty());
  CHECK(reader.on_head({kRun, 7, 3}, 0).deliver.empty());
  CHECK(reader.on_head({kRun, -7, 3}, 0).deliver.empty());
  CHECK(reader.on_head({kRun, 0, 2'000'000'000}, 0).deliver.empty());
  CHECK(reader.counts().impossible == 5);
  for (int stream = 1; stream <= 10; ++stream) reader.on_message(numbered(stream, 0), 0);
  CHECK(reader.counts().refused == 8);
  CHECK(reader.on_message(numbered(kRun, 0), 0).deliver.size() == 1);

  StreamWriter writer;
  REQUIRE(writer.on_publish(numbered(kRun, 0)));
  CHECK_FALSE(writer.on_publish(numbered(kRun, 2)));
  CHECK_FALSE(writer.on_publish(numbered(kRun, -3)));
  CHECK(writer.counts().out_of_order == 2);
  writer.on_resend({kRun, -2'000'000'000, 2'000'000'000});
  writer.on_resend({kRun, 5, 3});
  writer.on_resend({kRun + 1, 0, 3});
  CHECK(writer.on_tick(0).send.size() == 1);
}

TEST_CASE("What waits behind a gap is bounded, and still arrives in the end") {
  StreamReader reader({.waiting_bytes = 1'000});  // 10 messages
  for (int number = 1; number < 40; ++number) reader.on_message(numbered(kRun, number), 0);
  CHECK(reader.waiting() == 10);
  CHECK(reader.counts().refused == 29);
  CHECK(reader.on_message(numbered(kRun, 0), 0).deliver.size() == 11);
  const StreamActions tick = reader.on_tick(kUsPerSecond);
  REQUIRE(tick.resend.size() == 1);
  CHECK(tick.resend[0].first == 11);
  CHECK(tick.resend[0].last == 39);
}

TEST_CASE("Answers are limited in bytes a tick, and what several readers ask for is sent once") {
  StreamWriter writer({.resend_bytes_per_tick = 1'000});
  for (int number = 0; number < 40; ++number) REQUIRE(writer.on_publish(numbered(kRun, number)));
  writer.on_resend({kRun, 0, 39});
  writer.on_resend({kRun, 10, 29});
  std::vector<std::int32_t> sent;
  for (Utime now = 0; now < 10 * kTick; now += kTick) {
    const auto messages = writer.on_tick(now).send;
    CHECK(messages.size() <= 10);
    for (const auto& message : messages) sent.push_back(message.number);
  }
  CHECK(sent == range(0, 40));
}

TEST_CASE("Requests name the gaps, not what is there") {
  StreamReader reader({.span = 10, .ranges = 2});
  for (const int number : {0, 2, 4, 5, 8, 30}) reader.on_message(numbered(kRun, number), 0);
  const auto gaps = reader.on_tick(kUsPerSecond).resend;
  REQUIRE(gaps.size() == 2);
  CHECK((gaps[0].first == 1 && gaps[0].last == 1));
  CHECK((gaps[1].first == 3 && gaps[1].last == 3));
}

}  // namespace
}  // namespace covey
