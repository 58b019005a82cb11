// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The bridges' own messages, in and out of bytes. The generated decoders allocate what a count field says
// before they look at how much is there, so lengths are checked here first, against the bytes, and the
// decoder never sees a lie.

#include <covey/radio_ack_t.hpp>
#include <covey/radio_fragment_t.hpp>
#include <optional>

#include "core/radio/bytes.h"

namespace covey::radio {

inline constexpr const char* kFragmentChannel = "RADIO_FRAGMENT";
inline constexpr const char* kAckChannel = "RADIO_ACK";

inline constexpr int kFragmentBytes = 1100;          // body bytes in every fragment of a message but the last
inline constexpr int kMaxMessageBytes = 512 * 1024;  // a whole body
inline constexpr int kMaxAckEntries = 48;            // keeps an ack within a datagram
inline constexpr std::int64_t kMessageWindow = 16384;  // numbers that a sender may have open at once
inline constexpr int kFragmentWindow = 64;  // fragments beyond the first missing one that an ack can name

constexpr int fragments_of(std::int64_t total_bytes) {
  return static_cast<int>((total_bytes + kFragmentBytes - 1) / kFragmentBytes);
}

Bytes encode(const radio_fragment_t& fragment);
Bytes encode(const radio_ack_t& ack);

// Empty where the bytes are not exactly one message of the type.
std::optional<radio_fragment_t> decode_fragment(ByteView payload);
std::optional<radio_ack_t> decode_ack(ByteView payload);

}  // namespace covey::radio
