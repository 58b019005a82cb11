// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/rejected_pairs.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace covey::pgo {
namespace {

constexpr std::size_t kMostResiduals =
    10;  // of one pair in a sentence; the smallest are those that nearly fit

std::string residuals_of(const RejectedPair& pair) {
  std::string words;
  const std::size_t said = std::min(pair.loops.size(), kMostResiduals);
  for (std::size_t k = 0; k < said; ++k) words += fmt::format("{}{:.4g}", k > 0 ? " " : "", pair.loops[k].r2);
  if (said < pair.loops.size()) words += fmt::format(" ... {:.4g}", pair.loops.back().r2);
  return words;
}

std::string kept_of(const RejectedPair& pair) {
  if (pair.kept.empty()) return fmt::format("robot {} has kept none with anybody", pair.robot);
  std::string words = fmt::format("robot {} has kept", pair.robot);
  const char* before = " ";
  for (const auto& [other, count] : pair.kept) {
    words += other == pair.robot ? fmt::format("{}{} with itself", before, count)
                                 : fmt::format("{}{} with robot {}", before, count, other);
    before = ", ";
  }
  return words;
}

}  // namespace

std::vector<RejectedPair> rejected_pairs(const std::vector<LoopResult>& loops, int robot) {
  std::map<int, RejectedPair> pairs;
  std::map<int, int> kept;
  for (const LoopResult& loop : loops) {
    const int peer = loop.loop.a.robot == robot ? loop.loop.b.robot : loop.loop.a.robot;
    if (loop.weight > 0.0) ++kept[peer];
    if (peer != robot) pairs[peer].loops.push_back(loop);
  }
  std::vector<RejectedPair> rejected;
  for (auto& [peer, pair] : pairs) {
    if (kept.count(peer) > 0) continue;
    std::sort(pair.loops.begin(), pair.loops.end(),
              [](const LoopResult& left, const LoopResult& right) { return left.r2 < right.r2; });
    rejected.push_back({robot, peer, std::move(pair.loops), kept});
  }
  return rejected;
}

std::string sentence(const RejectedPair& pair, double barc2) {
  std::string words =
      fmt::format("All closures of pair {}-{} were rejected: ", std::min(pair.robot, pair.peer),
                  std::max(pair.robot, pair.peer));
  if (pair.loops.size() == 1) {
    const GraphLoop& loop = pair.loops.front().loop;
    words += fmt::format("the only one, of keyframe {} of robot {} with keyframe {} of robot {},", loop.a.id,
                         loop.a.robot, loop.b.id, loop.b.robot);
  } else {
    words += fmt::format("{},", pair.loops.size());
  }
  return words + fmt::format(" with squared residual{} {} against barc^2 {:.4g}; {}",
                             pair.loops.size() == 1 ? "" : "s", residuals_of(pair), barc2, kept_of(pair));
}

}  // namespace covey::pgo
