// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// A binary descriptor of 256 bits (ORB: Rublee et al., ICCV 2011) and its distance. In messages it is 32 bytes, in the order in
// which OpenCV gives them; the words here are those bytes in the order of the machine.

#include <array>
#include <bit>
#include <cstdint>
#include <cstring>

namespace covey::place {

using Descriptor = std::array<std::uint64_t, 4>;
constexpr std::size_t kDescriptorBytes = sizeof(Descriptor);
constexpr int kDescriptorBits = 256;

inline Descriptor descriptor_from(const std::uint8_t* bytes) {
  Descriptor descriptor;
  std::memcpy(descriptor.data(), bytes, kDescriptorBytes);
  return descriptor;
}

// Counting bits is one instruction since 2008, which compilers leave out for older machines' sake: functions that do little else say so.
#if defined(__x86_64__)
#define COVEY_COUNTS_BITS __attribute__((target("popcnt")))
#else
#define COVEY_COUNTS_BITS
#endif

// The number of bits that differ.
inline int hamming(const Descriptor& a, const Descriptor& b) {
  int bits = 0;
  for (std::size_t k = 0; k < a.size(); ++k) bits += std::popcount(a[k] ^ b[k]);
  return bits;
}

}  // namespace covey::place
