// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Every type that crosses the radio begins with int64 utime, int32 from, int32 to. LCM encodes a message as
// its fingerprint and then its fields, so these stand in the first 24 bytes of every payload and are read
// without the type.

#include <optional>

#include "core/base/time.h"
#include "core/radio/bytes.h"

namespace covey::radio {

inline constexpr int kMaxRobots = 64;  // ids 0 ... 63: bounds what a receiver keeps per sender
inline constexpr int kToEveryone = -1;
inline constexpr std::size_t kAddressingBytes = 24;

struct Addressing {
  std::int64_t fingerprint = 0;
  Utime utime = 0;
  std::int32_t from = 0;
  std::int32_t to = 0;  // kToEveryone or a robot
};

inline std::optional<Addressing> peek_addressing(ByteView payload) {
  if (payload.size() < kAddressingBytes) return std::nullopt;
  return Addressing{read_i64(payload, 0), read_i64(payload, 8), read_i32(payload, 16), read_i32(payload, 20)};
}

// Null when both ids can be: otherwise the reason.
inline const char* refusal_of_ids(const Addressing& addressing) {
  if (addressing.from < 0 || addressing.from >= kMaxRobots) return "from_impossible";
  if (addressing.to < kToEveryone || addressing.to >= kMaxRobots) return "to_impossible";
  return nullptr;
}

}  // namespace covey::radio
