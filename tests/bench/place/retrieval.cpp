// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/place/retrieval.h"

#include <algorithm>
#include <map>
#include <utility>

#include "core/place/database.h"
#include "tests/bench/place/score.h"

namespace covey::bench {
namespace {

constexpr double kLeast = 0.003;  // similarity: what is less is no candidate
constexpr std::size_t kPoints = 60;

struct Words {
  place::PlaceDatabase database;
  std::vector<std::size_t> keyframes;  // by the database's number
};

// How many of some other robot's keyframes there are to be found: pairs of a keyframe and a robot.
int overlaps(const std::vector<Seen>& seen, const std::map<int, Words>& robots) {
  int count = 0;
  for (const Seen& here : seen) {
    for (const auto& [robot, words] : robots) {
      if (robot == here.view.name.robot) continue;
      count += std::any_of(words.keyframes.begin(), words.keyframes.end(),
                           [&](std::size_t k) { return are_near(here.view, seen[k].view); });
    }
  }
  return count;
}

std::map<int, Words> words_of(const std::vector<Seen>& seen) {
  std::map<int, Words> robots;
  for (std::size_t k = 0; k < seen.size(); ++k) {
    Words& words = robots[seen[k].view.name.robot];
    words.database.add(seen[k].bag);
    words.keyframes.push_back(k);
  }
  return robots;
}

}  // namespace

double expected_similarity(const std::vector<Seen>& seen, std::size_t k) {
  for (std::size_t before = k; before-- > 0;) {
    if (seen[before].view.name.robot == seen[k].view.name.robot)
      return std::max(0.02, place::similarity(seen[before].bag, seen[k].bag));
  }
  return 1.0;
}

std::vector<Candidate> best_candidates(const std::vector<Seen>& seen) {
  std::vector<Candidate> candidates;
  for (const auto& [robot, words] : words_of(seen)) {
    for (std::size_t k = 0; k < seen.size(); ++k) {
      if (seen[k].view.name.robot == robot) continue;
      const auto hits = words.database.query(seen[k].bag, kLeast);
      if (hits.empty()) continue;
      candidates.push_back({k, words.keyframes[static_cast<std::size_t>(hits.front().entry)],
                            hits.front().similarity / expected_similarity(seen, k)});
    }
  }
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Candidate& a, const Candidate& b) { return a.similarity > b.similarity; });
  return candidates;
}

nlohmann::json retrieval_curve(const std::vector<Seen>& seen, const std::vector<Candidate>& candidates) {
  const int wanted = std::max(1, overlaps(seen, words_of(seen)));
  const std::size_t step = std::max<std::size_t>(1, candidates.size() / kPoints);
  nlohmann::json curve = nlohmann::json::array();
  int right = 0;
  for (std::size_t k = 0; k < candidates.size(); ++k) {
    right += are_near(seen[candidates[k].here].view, seen[candidates[k].there].view) ? 1 : 0;
    if ((k + 1) % step != 0) continue;
    curve.push_back({{"similarity", candidates[k].similarity},
                     {"precision", static_cast<double>(right) / static_cast<double>(k + 1)},
                     {"recall", static_cast<double>(right) / wanted}});
  }
  return curve;
}

}  // namespace covey::bench
