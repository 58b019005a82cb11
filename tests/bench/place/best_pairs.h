// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Pictures of a team's best pairs of keyframes, for each two robots: the closure with the most inliers, and the refused pair that came
// nearest. Both left images side by side with their matches: green where the measured pose explains them, red where it does not; orange where
// there is none.

#include <covey/loop_t.hpp>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <vector>

#include "core/geometry/camera.h"
#include "core/place/verification.h"
#include "tests/bench/place/retrieval.h"
#include "tests/bench/place/seen.h"

namespace covey::bench {

struct BestPairs {
  std::filesystem::path folder;
  std::function<cv::Mat(const View&)> picture;  // left
  PinholeCamera camera;
  place::VerificationOptions verification;
};

// Writes <a>-<b>_accepted.png and <a>-<b>_refused.png. [{"a", "b", "accepted" or "refused": the word, "id_a", "id_b", "inliers", "picture"}].
nlohmann::json draw_best_pairs(const BestPairs& options, const std::vector<Seen>& seen,
                               const std::vector<Candidate>& candidates, const std::vector<loop_t>& loops);

}  // namespace covey::bench
