// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Bytes as LCM puts them on the wire: big-endian, unaligned.

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace covey::radio {

using Bytes = std::vector<std::uint8_t>;
using ByteView = std::span<const std::uint8_t>;

// The caller has checked that the bytes are there.
inline std::uint32_t read_u32(ByteView bytes, std::size_t at) {
  return static_cast<std::uint32_t>(bytes[at]) << 24 | static_cast<std::uint32_t>(bytes[at + 1]) << 16 |
         static_cast<std::uint32_t>(bytes[at + 2]) << 8 | static_cast<std::uint32_t>(bytes[at + 3]);
}
inline std::uint64_t read_u64(ByteView bytes, std::size_t at) {
  return static_cast<std::uint64_t>(read_u32(bytes, at)) << 32 | read_u32(bytes, at + 4);
}
inline std::int32_t read_i32(ByteView bytes, std::size_t at) {
  return static_cast<std::int32_t>(read_u32(bytes, at));
}
inline std::int64_t read_i64(ByteView bytes, std::size_t at) {
  return static_cast<std::int64_t>(read_u64(bytes, at));
}

inline void append_u32(Bytes& bytes, std::uint32_t value) {
  for (int shift = 24; shift >= 0; shift -= 8) bytes.push_back(static_cast<std::uint8_t>(value >> shift));
}

}  // namespace covey::radio
