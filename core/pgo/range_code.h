// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Bits in fewer bits. A bit that its model expects with probability p takes -log2 p bits of the code; models learn from the
// bits that went through them, in the writer as in the reader. Whole numbers only, so that both do the same on every machine.
//
// The code is a number in [0, 1): each bit narrows the interval that is left to its model's share for zeros or the rest, and
// in the end any number inside will do. A model's share is (zeros + 1/2) / (bits + 1) of the last ones it has seen.
//
// A whole number is its size, that is how many binary digits |n| has, one model for each "it has more", then the digits below
// the first one and the sign as they are.
//
// Sources: Martin, "Range encoding: an algorithm for removing redundancy from a digitised message", 1979; Krichevsky, Trofimov,
// "The performance of universal encoding", IEEE Trans. Information Theory 1981 (the models).

#include <array>
#include <cstdint>
#include <vector>

namespace covey::pgo {

constexpr int kMostDigits = 20;
constexpr int kLargestCoded = (1 << kMostDigits) - 1;  // |number|

class BitModel {
 public:
  std::uint32_t zeros() const { return zeros_; }
  std::uint32_t all() const { return all_; }
  void learn(bool bit);

 private:
  std::uint16_t zeros_ = 1;  // in halves
  std::uint16_t all_ = 2;
};

struct NumberModel {
  std::array<BitModel, kMostDigits> more;  // [k]: has more than k digits
};

class RangeWriter {
 public:
  void put(bool bit, BitModel& model);
  void put(std::int32_t number, NumberModel& model);  // |number| <= kLargestCoded
  std::vector<std::uint8_t> finish();                 // the last call

 private:
  void put_plain(std::uint32_t digits, int count);
  void raise_low(std::uint32_t by);
  void shift();

  std::vector<std::uint8_t> bytes_;
  std::uint32_t low_ = 0;  // the interval is [low, low + range) 2^-32 of what the bytes leave open
  std::uint32_t range_ = 0xffffffffU;
};

// Beyond the end it reads zeros.
class RangeReader {
 public:
  explicit RangeReader(const std::vector<std::uint8_t>& bytes);
  bool get(BitModel& model);
  std::int32_t get(NumberModel& model);
  // Whether a writer that put what was read would have written as many bytes.
  bool ended_well() const;

 private:
  std::uint32_t get_plain(int count);
  void shift();

  const std::vector<std::uint8_t>& bytes_;
  std::size_t position_ = 0;
  std::uint32_t offset_ = 0;  // of the code in the interval
  std::uint32_t range_ = 0xffffffffU;
};

}  // namespace covey::pgo
