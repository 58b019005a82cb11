// SPDX-License-Identifier: BSD-3-Clause
#include "core/eval/radio_account.h"

#include <catch2/catch.hpp>

#include "core/radio/link.h"

namespace covey {
namespace {

constexpr std::int64_t kFingerprint = 42;

radio::TreatmentTable table() {
  return {{"SMALL", {.module = radio::Module::kPlaceRecognition, .fingerprint = kFingerprint}},
          {"SURE", {.module = radio::Module::kDpgo, .reliable = true, .fingerprint = kFingerprint}}};
}

// What every type that crosses the radio begins with, and `more` bytes.
radio::Bytes payload(int from, int to, std::size_t more) {
  radio::Bytes bytes;
  radio::append_u32(bytes, 0);
  radio::append_u32(bytes, static_cast<std::uint32_t>(kFingerprint));
  radio::append_u32(bytes, 0);
  radio::append_u32(bytes, 1);
  radio::append_u32(bytes, static_cast<std::uint32_t>(from));
  radio::append_u32(bytes, static_cast<std::uint32_t>(to));
  bytes.resize(bytes.size() + more);
  return bytes;
}

TEST_CASE("the account of the air is the bridge's own account") {
  std::map<std::string, std::int64_t> counted;
  radio::Link link(3, 1, table(), {}, {},
                   [&](const std::string& name, std::int64_t n) { counted[name] += n; });
  link.send("SMALL", payload(3, -1, 100), 1000);
  link.send("SURE", payload(3, 1, 5000), 1000);
  RadioAccount account;
  for (Utime now = 1000; now < 3'000'000; now += 10'000) {
    for (const radio::Bytes& datagram : link.on_tick(now).air) {
      const radio::ParsedPacket parsed = radio::parse_packet(datagram);
      REQUIRE(parsed.refused == nullptr);
      add_datagram(account, table(), std::string(parsed.packet.channel), parsed.packet.payload);
    }
  }
  CHECK(account.foreign.packets == 0);
  REQUIRE(account.total.packets > 6);
  CHECK(account.senders.at(3).bytes == account.total.bytes);
  for (std::size_t m = 0; m < radio::kModules; ++m) {
    const std::string name = radio::kModuleNames[m];
    CHECK(account.modules[m].bytes == counted["sent_bytes/" + name]);
    CHECK(account.modules[m].packets == counted["sent_packets/" + name]);
  }
}

TEST_CASE("what no bridge sent is counted apart") {
  RadioAccount account;
  add_datagram(account, table(), "UNKNOWN", payload(0, 1, 10));
  add_datagram(account, table(), "SMALL", payload(-7, 1, 10));
  add_datagram(account, table(), "SMALL", radio::Bytes(5));
  CHECK(account.foreign.packets == 3);
  CHECK(account.total.packets == 0);
}

}  // namespace
}  // namespace covey
