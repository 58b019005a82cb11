// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/place/memory.h"

#include <malloc.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <random>

#include "core/base/error.h"
#include "core/place/lcd_messages.h"

namespace covey::bench {
namespace {

// What waits to be used again was given back before.
double kb_in_memory() {
  malloc_trim(0);
  std::int64_t whole = 0;
  std::int64_t resident = 0;
  std::ifstream("/proc/self/statm") >> whole >> resident;
  return 1e-3 * static_cast<double>(resident * sysconf(_SC_PAGESIZE));
}

place::FrameFeatures make_features(int points, std::mt19937_64& random) {
  place::FrameFeatures features;
  for (int k = 0; k < points; ++k) {
    features.bearings_C.emplace_back(0.0F, 0.0F, 1.0F);
    features.depths_m.push_back(2.0F);
    features.descriptors.push_back({random(), random(), random(), random()});
  }
  return features;
}

}  // namespace

MemoryUse memory_of(const std::shared_ptr<const place::Vocabulary>& vocabulary,
                    const place::LcdOptions& options, int features, int keyframes) {
  constexpr int kOwn = 0;
  constexpr int kOther = 1;  // whose keyframes the first compares
  COVEY_CHECK(place::verifier_of(kOwn, kOther) == kOwn);
  place::LcdOptions all = options;
  all.keyframes = std::max(all.keyframes, keyframes);
  place::LcdAgent agent(kOwn, 1, vocabulary, all);
  std::mt19937_64 random(1);
  MemoryUse use;
  const auto add = [&](int robot) {
    const double before = kb_in_memory();
    for (int id = 0; id < keyframes; ++id) {
      const Utime utime = id * kUsPerSecond;
      place::FrameFeatures seen = make_features(features, random);
      const char* refused = nullptr;
      if (robot == kOwn) {
        refused = agent.add({robot, 1, id}, utime, std::move(seen), utime);
      } else {
        const place::WordCounts counts = vocabulary->counts(seen.descriptors);
        refused = agent.receive(place::bag_message({robot, 1, id}, utime, counts, vocabulary->hash()), utime);
      }
      COVEY_CHECK(refused == nullptr);
      agent.take_outgoing();
      agent.take_records();
    }
    return (kb_in_memory() - before) / keyframes;
  };
  use.own_kb = add(kOwn);
  use.other_kb = add(kOther);
  return use;
}

}  // namespace covey::bench
