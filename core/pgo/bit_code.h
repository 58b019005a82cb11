// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Bits in bytes, highest first, and small whole numbers in few bits: Rice's code of a number u >= 0 with parameter k is
// u >> k ones, a zero, then the k low bits of u. Of numbers around zero, -1, 1, -2, 2 ... become 1, 2, 3, 4 ... first.
// Source: Rice, Plaunt, "Adaptive Variable-Length Coding for Efficient Compression of Spacecraft Television Data", 1971.

#include <cstdint>
#include <vector>

namespace covey::pgo {

constexpr int kLargestRice = 15;        // parameter
constexpr int kLargestCoded = 1 << 19;  // |number|

class BitWriter {
 public:
  void put(std::uint32_t value, int bits);
  void put_rice(std::int32_t number, int k);  // |number| <= kLargestCoded
  const std::vector<std::uint8_t>& bytes() const { return bytes_; }

 private:
  std::vector<std::uint8_t> bytes_;
  int free_ = 0;  // bits of the last byte
};

// Beyond the end it reads zeros, and says so.
class BitReader {
 public:
  explicit BitReader(const std::vector<std::uint8_t>& bytes) : bytes_(bytes) {}
  std::uint32_t get(int bits);
  std::int32_t get_rice(int k);
  // All bytes were read, no bit beyond them, and no number that a writer does not write.
  bool ended_well() const { return good_ && (position_ + 7) / 8 == bytes_.size(); }

 private:
  const std::vector<std::uint8_t>& bytes_;
  std::size_t position_ = 0;
  bool good_ = true;
};

// The parameter that codes these numbers in the fewest bits.
int best_rice(const std::vector<std::int32_t>& numbers);

}  // namespace covey::pgo
