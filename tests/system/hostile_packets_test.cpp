// SPDX-License-Identifier: BSD-3-Clause
// 10,000 seeded forged, truncated and oversized packets at the radio port of a real radio_bridge: it lives, counts each of
// them, and a good message still gets through. Among them are those that kill liblcm 1.3.1: a fragment whose offset wraps
// in 32 bits, and a channel name without its zero byte.
#include <algorithm>
#include <random>
#include <thread>

#include "core/radio/link.h"
#include "tests/procs/radio_bridge/radio_stage.h"

namespace covey {
namespace {

using radio::append_u32;

constexpr int kPackets = 10'000;
constexpr int kVictim = 1;

class Attacker {
 public:
  explicit Attacker(std::uint64_t seed) : random_(seed) {}

  Bytes next() {
    switch (random_() % 9) {
      case 0:
        return noise(random_() % 2000);
      case 1:
        return lcm_fragment();
      case 2:
        return small_message("UNTERMINATED" + std::string(random_() % 1200, 'A'), false);
      case 3:
        return small_message(std::string(random_() % 200, 'A'), true);
      case 4:
        return mutated(good());
      case 5:
        return truncated(good());
      case 6:
        return oversized();
      case 7:
        return truncated(lcm_fragment());
      default:
        return noise(random_() % 9);
    }
  }

 private:
  Bytes noise(std::size_t bytes) {
    Bytes packet(bytes);
    for (auto& byte : packet) byte = static_cast<std::uint8_t>(random_());
    return packet;
  }

  // LCM's own fragment header, with offsets and counts that wrap.
  Bytes lcm_fragment() {
    const std::uint32_t extremes[] = {0, 1, 0x7fffffff, 0x80000000, 0xfffffe00, 0xffffffff};
    Bytes packet;
    append_u32(packet, radio::kFragmentMagic);
    append_u32(packet, static_cast<std::uint32_t>(random_() % 4));
    append_u32(packet, random_() % 2 == 0 ? 1000 : extremes[random_() % 6]);   // message size
    append_u32(packet, extremes[random_() % 6]);                               // fragment offset
    append_u32(packet, static_cast<std::uint32_t>(random_() % 3) << 16 | 2U);  // fragment of fragments
    for (const char c : std::string("IN_VICTIM")) packet.push_back(static_cast<std::uint8_t>(c));
    packet.push_back(0);
    packet.resize(550, 0x41);
    return packet;
  }

  Bytes small_message(const std::string& channel, bool terminated) {
    Bytes packet;
    append_u32(packet, radio::kSmallMessageMagic);
    append_u32(packet, static_cast<std::uint32_t>(random_()));
    packet.insert(packet.end(), channel.begin(), channel.end());
    if (terminated) packet.push_back(0);
    return packet;
  }

  Bytes good() {
    const int from = static_cast<int>(random_() % 8) + 2;
    const std::uint64_t kind = random_() % 3;
    Bytes payload;
    std::string channel;
    if (kind == 0) {
      channel = a_channel();
      payload = message_for(channel, from, random_() % 2 == 0 ? -1 : kVictim, 60 + random_() % 500);
    } else if (kind == 1) {
      channel = radio::kFragmentChannel;
      radio_fragment_t fragment{};
      fragment.from = from;
      fragment.to = kVictim;
      fragment.epoch = static_cast<std::int64_t>(random_() % 3);
      fragment.message = static_cast<std::int64_t>(random_() % 10);
      fragment.total_bytes = 2 * radio::kFragmentBytes;
      fragment.fragments = 2;
      fragment.n = radio::kFragmentBytes;
      fragment.data = noise(radio::kFragmentBytes);
      payload = radio::encode(fragment);
    } else {
      channel = radio::kAckChannel;
      radio_ack_t ack{};
      ack.from = from;
      ack.to = kVictim;
      ack.n = 2;
      ack.messages = {static_cast<std::int64_t>(random_()), 3};
      ack.below = {static_cast<std::int32_t>(random_()), 3};
      ack.masks = {-1, static_cast<std::int64_t>(random_())};
      payload = radio::encode(ack);
    }
    return radio::write_packet(static_cast<std::uint32_t>(random_()), channel, payload);
  }

  Bytes mutated(Bytes packet) {
    const std::size_t reach = std::min<std::size_t>(packet.size(), 110);
    for (auto flips = random_() % 6 + 1; flips > 0; --flips) {
      packet[random_() % reach] = static_cast<std::uint8_t>(random_());
    }
    return packet;
  }

  Bytes truncated(Bytes packet) {
    packet.resize(random_() % packet.size());
    return packet;
  }

  Bytes oversized() {
    Bytes packet = good();
    packet.resize(1201 + random_() % (random_() % 4 == 0 ? 60'000 : 1500), 0x41);
    return packet;
  }

  std::mt19937_64 random_;
};

std::int64_t packets_counted(const RadioStage& stage, const status_t& status) {
  std::int64_t counted = stage.counter(kVictim, "kernel_drops/7800");
  for (std::size_t i = 0; i < status.counter_names.size(); ++i) {
    const std::string& name = status.counter_names[i];
    const std::string reason = name.substr(name.rfind('/') + 1);
    // What reached a module was counted there, and may have been refused after that.
    const bool refused_before = name.rfind("dropped/radio/", 0) == 0 && reason.rfind("fragment_", 0) != 0 &&
                                reason.rfind("ack_", 0) != 0 && reason.rfind("epoch_", 0) != 0 &&
                                reason != "duplicate" && reason != "for_another_robot" &&
                                reason != "other_type" && reason != "from_mismatch";
    if (refused_before || name.rfind("received_packets/", 0) == 0) counted += status.counter_values[i];
  }
  return counted;
}

TEST_CASE("no packet ends a radio_bridge: 10000 hostile ones, each counted, and a good message after them") {
  RadioStage stage({kVictim});
  stage.start(kVictim);
  RadioSocket radio(RadioUrl{}, "");
  Attacker attacker(20260101);
  int sent = 0;
  while (sent < kPackets) {
    if (radio.send(attacker.next()) == nullptr) ++sent;
    if (sent % 50 == 0) std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  const status_t& status = stage.robot(kVictim).status;
  const bool all_counted = stage.wait_until([&] { return packets_counted(stage, status) >= kPackets; });
  INFO(stage.robot(kVictim).bridge->output());
  INFO(packets_counted(stage, status) << " of " << kPackets << " counted");
  REQUIRE(all_counted);
  for (const char* reason : {"lcm_fragment", "channel_unterminated", "channel_too_long", "channel_empty",
                             "magic", "too_short", "too_long", "payload_too_short", "from_impossible"}) {
    INFO(reason);
    REQUIRE(stage.counter(kVictim, std::string("dropped/radio/") + reason) > 0);
  }
  REQUIRE_FALSE(stage.robot(kVictim).bridge->wait(0.01));

  // A small message, and a large one in fragments that must be acknowledged, of a robot in whose name much was forged.
  const std::string channel = a_channel();
  const Bytes small = message_for(channel, 2, kVictim, 500, 77);
  const Bytes large = message_for(channel, 2, kVictim, 20'000, 78);
  std::vector<Bytes>& heard = stage.robot(kVictim).heard["IN_" + channel];
  heard.clear();
  radio::Link friendly(2, stage.loop().now(), radio_table(), {}, {}, [](const std::string&, std::int64_t) {});
  friendly.send(channel, small, stage.loop().now());
  friendly.send(channel, large, stage.loop().now());
  stage.loop().add_fd(radio.fd(), [&] {
    radio.receive([&](radio::ByteView datagram) { friendly.receive(datagram, stage.loop().now()); });
  });
  const bool arrived = stage.wait_until([&] {
    for (const auto& datagram : friendly.on_tick(stage.loop().now()).air) radio.send(datagram);
    return std::count(heard.begin(), heard.end(), small) == 1 &&
           std::count(heard.begin(), heard.end(), large) == 1 && friendly.open_messages() == 0;
  });
  INFO(stage.robot(kVictim).bridge->output());
  REQUIRE(arrived);
  stage.loop().remove_fd(radio.fd());
  stage.robot(kVictim).bridge->kill(SIGTERM);
  REQUIRE(stage.robot(kVictim).bridge->wait(10.0) == 0);
}

}  // namespace
}  // namespace covey
