// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// What the words alone are worth: each keyframe's most similar one of each other robot, of whatever time, is right if it is near (score.h).

#include <nlohmann/json.hpp>
#include <vector>

#include "tests/bench/place/seen.h"

namespace covey::bench {

// To the keyframe before, of its own robot: what similarity is measured by. 1 where there is none.
double expected_similarity(const std::vector<Seen>& seen, std::size_t k);

struct Candidate {
  std::size_t here = 0;
  std::size_t there = 0;
  double similarity = 0.0;  // over that to the keyframe before
};

// One for each keyframe and other robot that has anything like it, the most similar first.
std::vector<Candidate> best_candidates(const std::vector<Seen>& seen);

// [{"similarity", "precision", "recall"}] of those from this similarity on; recall among keyframes to which one of that robot is near.
nlohmann::json retrieval_curve(const std::vector<Seen>& seen, const std::vector<Candidate>& candidates);

}  // namespace covey::bench
