// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// A 64-bit hash for telling whether two robots hold the same data (FNV-1a over bytes, lowest first, then a finalising mix).
// Not for secrets: whoever wants a collision can make one.

#include <bit>
#include <cstdint>

namespace covey::pgo {

class Hash {
 public:
  void add(std::uint64_t word) {
    for (int i = 0; i < 8; ++i) {
      state_ ^= (word >> (8 * i)) & 0xff;
      state_ *= 0x100000001b3ULL;
    }
  }
  void add(double value) {
    add(std::bit_cast<std::uint64_t>(value == 0.0 ? 0.0 : value));
  }  // 0 and -0 are one
  std::uint64_t value() const {
    const std::uint64_t mixed = (state_ ^ (state_ >> 31)) * 0x9e3779b97f4a7c15ULL;
    return mixed ^ (mixed >> 29);
  }

 private:
  std::uint64_t state_ = 0xcbf29ce484222325ULL;
};

}  // namespace covey::pgo
