// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// One radio datagram: LCM's small message ("LC02"), and nothing else of LCM's protocol.
//
//   u32 0x4c433032 | u32 sequence | channel, 1 to 63 printable characters, zero byte | payload, to the end
//
// big-endian, at most 1200 bytes in all, so that no link splits it. LCM's own fragments ("LC03") are refused:
// their receiver is where liblcm 1.3.1 dies. Everything that is refused comes with a word that names the
// reason.

#include <string_view>

#include "core/radio/bytes.h"

namespace covey::radio {

inline constexpr std::size_t kMaxDatagramBytes = 1200;
inline constexpr std::size_t kMaxChannelLength = 63;
inline constexpr std::uint32_t kSmallMessageMagic = 0x4c433032;
inline constexpr std::uint32_t kFragmentMagic = 0x4c433033;

// Views into the datagram that it was parsed from.
struct Packet {
  std::uint32_t sequence = 0;
  std::string_view channel;
  ByteView payload;
};

struct ParsedPacket {
  Packet packet;
  const char* refused =
      nullptr;  // "too_short", "too_long", "lcm_fragment", "magic", "channel_..."; null: good
};

ParsedPacket parse_packet(ByteView datagram);

// Splits "channel, zero byte, payload", the body of a packet and of a reassembled message, under the same
// rules.
ParsedPacket parse_body(ByteView body);

std::size_t packet_bytes(std::string_view channel, std::size_t payload_bytes);

// The channel is valid and the whole is not larger than kMaxDatagramBytes.
bool fits_packet(std::string_view channel, std::size_t payload_bytes);

// Only for what fits_packet; a body may have any length.
Bytes write_packet(std::uint32_t sequence, std::string_view channel, ByteView payload);
Bytes write_body(std::string_view channel, ByteView payload);

}  // namespace covey::radio
