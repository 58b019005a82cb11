// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Which seeds a sweep takes: COVEY_SEEDS=500 takes 1 ... 500, COVEY_SEEDS=101-200 those alone; without it the first few.

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <random>

namespace covey {

struct Seeds {
  int first = 1;
  int last = 1;
  bool asked = false;  // by COVEY_SEEDS
};

inline Seeds seeds_or(int few) {
  const char* words = std::getenv("COVEY_SEEDS");
  if (words == nullptr) return {1, few, false};
  Seeds seeds{1, 1, true};
  if (std::sscanf(words, "%d-%d", &seeds.first, &seeds.last) < 2) {
    seeds.first = 1;
    seeds.last = std::atoi(words);
  }
  return seeds;
}

// The same on every machine.
class SeededRandom {
 public:
  explicit SeededRandom(std::uint64_t seed) : random_(seed) {}
  double uniform(double low, double high) {
    return low + (high - low) * static_cast<double>(random_() >> 11) * 0x1p-53;
  }
  int below(int n) { return static_cast<int>(random_() % static_cast<std::uint64_t>(n)); }
  bool chance(double probability) { return uniform(0.0, 1.0) < probability; }

 private:
  std::mt19937_64 random_;
};

}  // namespace covey
