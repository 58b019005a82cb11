// SPDX-License-Identifier: BSD-3-Clause
#include "core/radio/link.h"

#include <algorithm>

namespace covey::radio {
namespace {

constexpr double kLargestLead =
    64'000.0;  // bytes by which an idle module may be behind the others when it comes back
constexpr Utime kCheckPeriodUs = kUsPerSecond;
constexpr double kBurstPeriodS = 0.01;

// Sequences of two runs of one bridge must not look like repeats of each other.
std::uint32_t first_sequence(Utime epoch) {
  return static_cast<std::uint32_t>((static_cast<std::uint64_t>(epoch) * 0x9e3779b97f4a7c15U) >> 32);
}

}  // namespace

Link::Link(int robot, Utime epoch, TreatmentTable table, LinkOptions options, const LinkModelOptions& model,
           Count count)
    : robot_(robot),
      epoch_(epoch),
      table_(std::move(table)),
      options_(options),
      count_(std::move(count)),
      model_(robot, model),
      budget_(model.rate_bytes_per_s, model.burst_bytes),
      pace_(kBurstDatagrams / kBurstPeriodS, kBurstDatagrams),
      sender_(robot, epoch, options.reliable),
      sequence_(first_sequence(epoch)) {}

void Link::send(std::string_view channel, ByteView payload, Utime now) {
  const auto drop = [&](const char* reason) { count_(fmt::format("dropped/OUT_{}/{}", channel, reason), 1); };
  const auto entry = table_.find(channel);
  if (entry == table_.end()) return drop("channel_unknown");
  const Treatment& treatment = entry->second;
  const auto addressing = peek_addressing(payload);
  if (!addressing || addressing->fingerprint != treatment.fingerprint) return drop("other_type");
  if (addressing->from != robot_) return drop("from_another_robot");
  if (const char* refused = refusal_of_ids(*addressing)) return drop(refused);
  if (addressing->to == robot_) return drop("to_itself");

  if (treatment.reliable || packet_bytes(channel, payload.size()) > kMaxDatagramBytes) {
    const char* refused = sender_.submit(treatment.module, treatment.priority, addressing->to,
                                         write_body(channel, payload), now);
    if (refused != nullptr) drop(refused);
  } else {
    enqueue(entry->first, treatment, payload);
  }
}

void Link::enqueue(const std::string& channel, const Treatment& treatment, ByteView payload) {
  Queue& queue = queues_[index_of(treatment.module)];
  queue.by_priority[-treatment.priority].push_back({channel, Bytes(payload.begin(), payload.end())});
  queue.bytes += payload.size();
  while (queue.bytes > options_.max_queue_bytes) {
    auto lowest = std::prev(queue.by_priority.end());
    const Waiting& oldest = lowest->second.front();
    count_(fmt::format("dropped/OUT_{}/queue_full", oldest.channel), 1);
    queue.bytes -= oldest.payload.size();
    lowest->second.pop_front();
    if (lowest->second.empty()) queue.by_priority.erase(lowest);
  }
}

void Link::receive(ByteView datagram, Utime now) {
  const ParsedPacket parsed = parse_packet(datagram);
  if (parsed.refused != nullptr) return drop_from_air(parsed.refused);
  const auto addressing = peek_addressing(parsed.packet.payload);
  if (!addressing) return drop_from_air("payload_too_short");
  if (const char* refused = refusal_of_ids(*addressing)) return drop_from_air(refused);
  if (addressing->from == robot_) return drop_from_air("own_echo");
  if (const char* lost = model_.offer(addressing->from, datagram, now)) drop_from_air(lost);
}

Link::Output Link::on_tick(Utime now) {
  Output output;
  for (const Bytes& datagram : model_.take_due(now)) hear(datagram, now, output);

  if (now >= next_check_) {
    next_check_ = now + kCheckPeriodUs;
    if (const int missed = sender_.on_tick(now)) count_("gave_up/radio", missed);
    for (auto& [robot, peer] : peers_) {
      if (const int expired = peer.assembler.expire(now)) count_("dropped/radio/fragment_timeout", expired);
    }
  }
  while (budget_.open(now) && pace_.open(now)) {
    const auto chosen = next(now);
    if (!chosen) break;
    output.air.push_back(to_air(chosen->first, chosen->second, now));
  }
  return output;
}

void Link::hear(ByteView datagram, Utime now, Output& output) {
  const Packet packet = parse_packet(datagram).packet;  // receive() let only good ones pass
  const Addressing addressing = *peek_addressing(packet.payload);
  const auto module = module_of(packet.channel, packet.payload, table_);
  if (!module) return drop_from_air("channel_unknown");
  const std::string name = name_of(*module);
  count_("received_bytes/" + name, static_cast<std::int64_t>(datagram.size()));
  count_("received_packets/" + name, 1);
  if (repeated(peers_[addressing.from], packet.sequence)) return drop_from_air("duplicate");
  if (const char* refused = hear_packet(packet, addressing, now, output)) drop_from_air(refused);
}

const char* Link::hear_packet(const Packet& packet, const Addressing& addressing, Utime now, Output& output) {
  if (packet.channel == kAckChannel) return hear_ack(packet, addressing, now);
  if (packet.channel == kFragmentChannel) return hear_fragment(packet, addressing, now, output);
  sender_.on_heard(addressing.from, now);
  return deliver(packet, addressing.from, output);
}

const char* Link::hear_ack(const Packet& packet, const Addressing& addressing, Utime now) {
  const auto ack = decode_ack(packet.payload);
  if (!ack) return "ack_undecodable";
  if (const char* refused = accept_epoch(addressing.from, ack->epoch, now)) return refused;
  sender_.on_heard(addressing.from, now);
  if (ack->to != robot_ || ack->n == 0) return nullptr;
  return sender_.on_ack(*ack, now);
}

const char* Link::hear_fragment(const Packet& packet, const Addressing& addressing, Utime now,
                                Output& output) {
  const auto fragment = decode_fragment(packet.payload);
  if (!fragment) return "fragment_undecodable";
  if (const char* refused = accept_epoch(addressing.from, fragment->epoch, now)) return refused;
  sender_.on_heard(addressing.from, now);
  if (addressing.to != kToEveryone && addressing.to != robot_) return "for_another_robot";
  Peer& peer = peers_[addressing.from];
  const Assembler::Result result = peer.assembler.add(*fragment, now);
  if (peer.assembler.has_arrived()) {
    if (!peer.ack_due) peer.ack_due = now + options_.ack_delay_us;
    peer.fragment_utime = fragment->utime;
    peer.fragment_heard = now;
  }
  if (result.refused != nullptr || !result.body) return result.refused;
  const ParsedPacket message = parse_body(*result.body);
  if (message.refused != nullptr) return message.refused;
  return deliver(message.packet, addressing.from, output);
}

// A whole message: only what the table knows, of the type it says, from whom it came, and meant for this
// robot.
const char* Link::deliver(const Packet& message, int from, Output& output) {
  const auto entry = table_.find(message.channel);
  if (entry == table_.end()) return "channel_unknown";
  const auto addressing = peek_addressing(message.payload);
  if (!addressing) return "payload_too_short";
  if (addressing->fingerprint != entry->second.fingerprint) return "other_type";
  if (addressing->from != from) return "from_mismatch";
  if (addressing->to != kToEveryone && addressing->to != robot_) return "for_another_robot";
  output.bus.push_back({entry->first, Bytes(message.payload.begin(), message.payload.end())});
  return nullptr;
}

// A new epoch is a new run of that robot's bridge: nothing of the old one counts any more. An old one is late
// mail, unless the robot has been silent so long that its clock must have gone back.
const char* Link::accept_epoch(int from, std::int64_t epoch, Utime now) {
  Peer& peer = peers_[from];
  if (peer.epoch && epoch < *peer.epoch && now - peer.epoch_heard <= options_.epoch_memory_us)
    return "epoch_stale";
  if (peer.epoch && epoch != *peer.epoch) {
    peer.assembler = Assembler();
    peer.ack_due.reset();
    sender_.on_restart(from, now);
  }
  peer.epoch = epoch;
  peer.epoch_heard = now;
  return nullptr;
}

bool Link::repeated(Peer& peer, std::uint32_t sequence) {
  if (std::find(peer.sequences.begin(), peer.sequences.end(), sequence) != peer.sequences.end()) return true;
  peer.sequences.push_back(sequence);
  if (peer.sequences.size() > kRememberedSequences) peer.sequences.pop_front();
  return false;
}

std::optional<std::pair<Module, Link::Waiting>> Link::next(Utime now) {
  if (auto ack = next_ack(now)) return std::pair(Module::kControl, std::move(*ack));
  if (auto waiting = next_of(Module::kControl, now)) return std::pair(Module::kControl, std::move(*waiting));
  std::array<Module, kModules - 1> order = {Module::kPlaceRecognition, Module::kGeometricVerification,
                                            Module::kDpgo};
  std::sort(order.begin(), order.end(), [&](Module left, Module right) {
    return queues_[index_of(left)].served_bytes < queues_[index_of(right)].served_bytes;
  });
  for (const Module module : order) {
    if (auto waiting = next_of(module, now)) return std::pair(module, std::move(*waiting));
  }
  return std::nullopt;
}

// Datagrams that cross as themselves and fragments take turns.
std::optional<Link::Waiting> Link::next_of(Module module, Utime now) {
  Queue& queue = queues_[index_of(module)];
  queue.fragment_next = !queue.fragment_next;
  for (int attempt = 0; attempt < 2; ++attempt, queue.fragment_next = !queue.fragment_next) {
    if (queue.fragment_next) {
      if (const auto fragment = sender_.next(module, now))
        return Waiting{kFragmentChannel, encode(*fragment)};
    } else if (!queue.by_priority.empty()) {
      const auto highest = queue.by_priority.begin();
      Waiting waiting = std::move(highest->second.front());
      highest->second.pop_front();
      if (highest->second.empty()) queue.by_priority.erase(highest);
      queue.bytes -= waiting.payload.size();
      return waiting;
    }
  }
  return std::nullopt;
}

// An ack that is due, or a sign of life.
std::optional<Link::Waiting> Link::next_ack(Utime now) {
  radio_ack_t ack{};
  ack.utime = now;
  ack.from = robot_;
  ack.epoch = epoch_;
  for (auto& [robot, peer] : peers_) {
    if (!peer.ack_due || now < *peer.ack_due) continue;
    ack.to = robot;
    ack.sender_epoch = peer.epoch.value_or(0);
    ack.heard_utime = peer.fragment_utime;
    ack.held_us = now - peer.fragment_heard;
    for (const Arrived& arrived : peer.assembler.take_arrived(kMaxAckEntries)) {
      ack.messages.push_back(arrived.message);
      ack.below.push_back(arrived.below);
      ack.masks.push_back(static_cast<std::int64_t>(arrived.mask));
    }
    if (!peer.assembler.has_arrived()) peer.ack_due.reset();
    if (ack.messages.empty()) continue;
    ack.n = static_cast<std::int32_t>(ack.messages.size());
    ack.number = acks_++;
    return Waiting{kAckChannel, encode(ack)};
  }
  if (last_said_ && now - *last_said_ < options_.sign_of_life_us) return std::nullopt;
  ack.to = kToEveryone;
  ack.number = acks_++;
  return Waiting{kAckChannel, encode(ack)};
}

Bytes Link::to_air(Module module, const Waiting& waiting, Utime now) {
  Bytes datagram = write_packet(sequence_++, waiting.channel, waiting.payload);
  last_said_ = now;
  budget_.spend(datagram.size());
  pace_.spend(1);
  Queue& queue = queues_[index_of(module)];
  queue.served_bytes += static_cast<double>(datagram.size());
  for (Queue& other : queues_)
    other.served_bytes = std::max(other.served_bytes, queue.served_bytes - kLargestLead);
  const std::string name = name_of(module);
  count_("sent_bytes/" + name, static_cast<std::int64_t>(datagram.size()));
  count_("sent_packets/" + name, 1);
  return datagram;
}

std::optional<Module> module_of(std::string_view channel, ByteView payload, const TreatmentTable& table) {
  if (channel == kAckChannel) return Module::kControl;
  if (channel == kFragmentChannel) {
    const auto fragment = decode_fragment(payload);
    const bool known = fragment && fragment->module >= 0 && fragment->module < static_cast<int>(kModules);
    return known ? static_cast<Module>(fragment->module) : Module::kControl;
  }
  const auto entry = table.find(channel);
  if (entry == table.end()) return std::nullopt;
  return entry->second.module;
}

}  // namespace covey::radio
