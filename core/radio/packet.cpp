// SPDX-License-Identifier: BSD-3-Clause
#include "core/radio/packet.h"

#include <algorithm>

#include "core/base/error.h"

namespace covey::radio {
namespace {

constexpr std::size_t kHeaderBytes = 8;

bool printable(std::uint8_t c) { return c >= 0x21 && c <= 0x7e; }

const char* refusal_of_channel(ByteView name) {
  if (name.empty()) return "channel_empty";
  if (name.size() > kMaxChannelLength) return "channel_too_long";
  if (!std::all_of(name.begin(), name.end(), printable)) return "channel_unprintable";
  return nullptr;
}

ParsedPacket refuse(const char* reason) { return {.packet = {}, .refused = reason}; }

}  // namespace

ParsedPacket parse_body(ByteView body) {
  const auto end = std::find(body.begin(), body.end(), 0);
  if (end == body.end()) return refuse("channel_unterminated");
  const ByteView name(body.begin(), end);
  if (const char* reason = refusal_of_channel(name)) return refuse(reason);
  ParsedPacket parsed;
  parsed.packet.channel = std::string_view(reinterpret_cast<const char*>(name.data()), name.size());
  parsed.packet.payload = body.subspan(name.size() + 1);
  return parsed;
}

ParsedPacket parse_packet(ByteView datagram) {
  if (datagram.size() > kMaxDatagramBytes) return refuse("too_long");
  if (datagram.size() < kHeaderBytes) return refuse("too_short");
  const std::uint32_t magic = read_u32(datagram, 0);
  if (magic == kFragmentMagic) return refuse("lcm_fragment");
  if (magic != kSmallMessageMagic) return refuse("magic");
  ParsedPacket parsed = parse_body(datagram.subspan(kHeaderBytes));
  parsed.packet.sequence = read_u32(datagram, 4);
  return parsed;
}

std::size_t packet_bytes(std::string_view channel, std::size_t payload_bytes) {
  return kHeaderBytes + channel.size() + 1 + payload_bytes;
}

bool fits_packet(std::string_view channel, std::size_t payload_bytes) {
  const Bytes name(channel.begin(), channel.end());
  return refusal_of_channel(name) == nullptr && packet_bytes(channel, payload_bytes) <= kMaxDatagramBytes;
}

Bytes write_body(std::string_view channel, ByteView payload) {
  Bytes body(channel.begin(), channel.end());
  COVEY_CHECK(refusal_of_channel(body) == nullptr);
  body.push_back(0);
  body.insert(body.end(), payload.begin(), payload.end());
  return body;
}

Bytes write_packet(std::uint32_t sequence, std::string_view channel, ByteView payload) {
  COVEY_CHECK(packet_bytes(channel, payload.size()) <= kMaxDatagramBytes);
  Bytes datagram;
  datagram.reserve(packet_bytes(channel, payload.size()));
  append_u32(datagram, kSmallMessageMagic);
  append_u32(datagram, sequence);
  const Bytes body = write_body(channel, payload);
  datagram.insert(datagram.end(), body.begin(), body.end());
  return datagram;
}

}  // namespace covey::radio
