// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// One robot's end of the radio: what its processes want to say goes in, datagrams come out, and the other way
// round. A state machine without socket or clock:
//
//   Link link(robot, start_utime, table, link_options, model_options, count);
//   link.send("DPGO_POSES", payload, now);     // from the robot's own bus
//   link.receive(datagram, now);               // from the air
//   Link::Output output = link.on_tick(now);   // often: after each of the above, and every 10 ms
//   output.air   datagrams to send             output.bus   (channel, payload) for the robot's own bus
//
// A message that fits a datagram and may be lost crosses as itself, on its bare channel name; the others as
// radio_fragment_t, acknowledged by radio_ack_t. Both are plain LCM messages, so lcm-logger records the air.
//
// However much is due, a tick sends only what the receivers' buffers take; the rest waits for the next tick.
// Who goes first, within the budget of bytes: control; then the modules in turn, so that none starves another
// (the one that has sent the fewest bytes of late); within a module by priority.
//
// Everything is counted by name: "sent_bytes/dpgo", "sent_packets/...", "received_bytes/...",
// "received_packets/..." (whole datagrams), "dropped/radio/REASON" for what came from the air,
// "dropped/OUT_x/REASON" for what came from the bus, "gave_up/radio" for robots that missed a message for
// good.

#include <array>
#include <deque>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "core/radio/addressing.h"
#include "core/radio/assembler.h"
#include "core/radio/link_model.h"
#include "core/radio/packet.h"
#include "core/radio/reliable.h"
#include "core/radio/treatment.h"

namespace covey::radio {

// Datagrams of all sizes that a link without a rate puts on air at once, and in each 10 ms: a stock receive buffer of
// 212,992 bytes holds about 90, whatever is in them up to 1200 bytes.
inline constexpr double kBurstDatagrams = 50.0;

struct LinkOptions {
  ReliableOptions reliable;
  Utime ack_delay_us = 20'000;           // acks of that long share a datagram
  Utime sign_of_life_us = kUsPerSecond;  // said where nothing else was
  Utime epoch_memory_us =
      5 * kUsPerSecond;  // a robot whose clock went back is taken for new after that silence
  std::size_t max_queue_bytes =
      1'000'000;  // waiting datagrams, per module; the oldest of the lowest priority goes
};

using Count = std::function<void(const std::string& name, std::int64_t n)>;

class Link {
 public:
  struct Delivery {
    std::string channel;
    Bytes payload;
  };
  struct Output {
    std::vector<Bytes> air;
    std::vector<Delivery> bus;
  };

  Link(int robot, Utime epoch, TreatmentTable table, LinkOptions options, const LinkModelOptions& model,
       Count count);

  void send(std::string_view channel, ByteView payload, Utime now);
  void receive(ByteView datagram, Utime now);
  Output on_tick(Utime now);

  std::size_t open_messages() const { return sender_.open_messages(); }
  std::size_t peers() const { return peers_.size(); }

 private:
  static constexpr std::size_t kRememberedSequences = 256;

  struct Peer {
    std::optional<std::int64_t> epoch;
    Utime epoch_heard = 0;
    Assembler assembler;
    std::optional<Utime> ack_due;
    Utime fragment_utime = 0;  // of the newest fragment, in the sender's clock
    Utime fragment_heard = 0;
    std::deque<std::uint32_t> sequences;
  };
  struct Waiting {
    std::string channel;
    Bytes payload;
  };
  struct Queue {
    std::map<int, std::deque<Waiting>> by_priority;
    std::size_t bytes = 0;
    double served_bytes = 0.0;
    bool fragment_next = false;
  };

  void hear(ByteView datagram, Utime now, Output& output);
  const char* hear_packet(const Packet& packet, const Addressing& addressing, Utime now, Output& output);
  const char* hear_fragment(const Packet& packet, const Addressing& addressing, Utime now, Output& output);
  const char* hear_ack(const Packet& packet, const Addressing& addressing, Utime now);
  const char* deliver(const Packet& message, int from, Output& output);
  const char* accept_epoch(int from, std::int64_t epoch, Utime now);
  bool repeated(Peer& peer, std::uint32_t sequence);

  void enqueue(const std::string& channel, const Treatment& treatment, ByteView payload);
  std::optional<Waiting> next_of(Module module, Utime now);
  std::optional<Waiting> next_ack(Utime now);
  std::optional<std::pair<Module, Waiting>> next(Utime now);
  Bytes to_air(Module module, const Waiting& waiting, Utime now);

  void drop_from_air(const char* reason) { count_(std::string("dropped/radio/") + reason, 1); }

  int robot_;
  Utime epoch_;
  TreatmentTable table_;
  LinkOptions options_;
  Count count_;
  LinkModel model_;
  Budget budget_;
  Budget pace_;  // in datagrams
  ReliableSender sender_;
  std::map<int, Peer> peers_;
  std::array<Queue, kModules> queues_;
  std::uint32_t sequence_;
  std::int64_t acks_ = 0;
  std::optional<Utime> last_said_;
  Utime next_check_ = 0;
};

// Who pays for a datagram: by the table for a message that crosses as itself, as the fragment says, control
// for acks. Nothing for a channel that is none of ours.
std::optional<Module> module_of(std::string_view channel, ByteView payload, const TreatmentTable& table);

}  // namespace covey::radio
