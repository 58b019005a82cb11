// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Messages that look like the radio's types: fingerprint, utime, from, to, and filling.

#include "core/radio/addressing.h"
#include "core/radio/link.h"

namespace covey::radio {

inline constexpr std::int64_t kTestFingerprint = 0x1122334455667788;

inline Bytes test_payload(int from, int to, std::size_t bytes, std::uint32_t tag = 0) {
  Bytes payload;
  const auto append_u64 = [&](std::uint64_t value) {
    append_u32(payload, static_cast<std::uint32_t>(value >> 32));
    append_u32(payload, static_cast<std::uint32_t>(value));
  };
  append_u64(kTestFingerprint);
  append_u64(1'000'000);
  append_u32(payload, static_cast<std::uint32_t>(from));
  append_u32(payload, static_cast<std::uint32_t>(to));
  append_u32(payload, tag);
  while (payload.size() < bytes) payload.push_back(static_cast<std::uint8_t>(payload.size() * 7 + tag));
  return payload;
}

inline std::uint32_t tag_of(ByteView payload) { return read_u32(payload, kAddressingBytes); }

inline TreatmentTable test_table() {
  return {{"PLAIN", {.module = Module::kDpgo, .fingerprint = kTestFingerprint}},
          {"SURE", {.module = Module::kDpgo, .reliable = true, .fingerprint = kTestFingerprint}},
          {"PLACE", {.module = Module::kPlaceRecognition, .fingerprint = kTestFingerprint}}};
}

// A link whose counts can be looked at.
struct TestLink {
  std::map<std::string, std::int64_t> counts;
  Link link;

  TestLink(int robot, Utime epoch, const LinkModelOptions& model = {}, LinkOptions options = {})
      : link(robot, epoch, test_table(), options, model,
             [this](const std::string& name, std::int64_t n) { counts[name] += n; }) {}
};

}  // namespace covey::radio
