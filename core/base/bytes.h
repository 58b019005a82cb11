// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Encoded messages are plain bytes; a generated type T goes to and from them here.

#include <cstdint>
#include <exception>
#include <vector>

namespace covey {

using Bytes = std::vector<std::uint8_t>;

// The count fields of `message` must equal the sizes of its vectors: lcm-gen's encoder trusts them.
template <typename T>
Bytes encode(const T& message) {
  Bytes bytes(static_cast<std::size_t>(message.getEncodedSize()));
  message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  return bytes;
}

// False where the bytes are not exactly one T. A count that asks for more memory than there is counts as
// undecodable too: lcm-gen's decoder resizes before it looks at how many bytes are left.
template <typename T>
bool decode(const Bytes& bytes, T& message) noexcept {
  try {
    return message.decode(bytes.data(), 0, static_cast<int>(bytes.size())) == static_cast<int>(bytes.size());
  } catch (const std::exception&) {
    return false;
  }
}

}  // namespace covey
