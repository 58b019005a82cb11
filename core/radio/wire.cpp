// SPDX-License-Identifier: BSD-3-Clause
#include "core/radio/wire.h"

#include "core/base/error.h"

namespace covey::radio {
namespace {

// Bytes before the count field `n`, fingerprint included, and bytes per element.
constexpr std::size_t kFragmentHead = 8 + 8 + 4 + 4 + 8 + 8 + 8 + 4 + 4 + 4 + 1;
constexpr std::size_t kAckHead = 8 + 8 + 4 + 4 + 8 + 8 + 8 + 8 + 8;
constexpr std::size_t kAckEntry = 8 + 4 + 8;

template <typename T>
Bytes encode_any(const T& message) {
  Bytes bytes(static_cast<std::size_t>(message.getEncodedSize()));
  COVEY_CHECK(message.encode(bytes.data(), 0, static_cast<int>(bytes.size())) >= 0);
  return bytes;
}

// `head` bytes, an int32 count, and that many elements: exactly.
bool has_exact_length(ByteView payload, std::size_t head, std::size_t element, int most) {
  if (payload.size() < head + 4) return false;
  const std::int32_t n = read_i32(payload, head);
  return n >= 0 && n <= most && payload.size() == head + 4 + static_cast<std::size_t>(n) * element;
}

template <typename T>
std::optional<T> decode_any(ByteView payload) {
  T message{};
  const int size = static_cast<int>(payload.size());
  if (message.decode(payload.data(), 0, size) != size) return std::nullopt;
  return message;
}

}  // namespace

Bytes encode(const radio_fragment_t& fragment) { return encode_any(fragment); }
Bytes encode(const radio_ack_t& ack) { return encode_any(ack); }

std::optional<radio_fragment_t> decode_fragment(ByteView payload) {
  if (!has_exact_length(payload, kFragmentHead, 1, kFragmentBytes)) return std::nullopt;
  return decode_any<radio_fragment_t>(payload);
}

std::optional<radio_ack_t> decode_ack(ByteView payload) {
  if (!has_exact_length(payload, kAckHead, kAckEntry, kMaxAckEntries)) return std::nullopt;
  return decode_any<radio_ack_t>(payload);
}

}  // namespace covey::radio
