// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/start_frames.h"

#include <algorithm>
#include <cstddef>
#include <map>
#include <set>

namespace covey::pgo {
namespace {

// Inliers that an earlier solution counts for by itself: where closures say anything, they are believed first.
constexpr int kSameSolution = 0;

}  // namespace

void StartFrames::add(const StartFrame& frame, std::int64_t solution, const FrameExtent& extent) {
  frames_.push_back(frame);
  solutions_.push_back(solution);
  extents_.push_back(extent);
}

bool StartFrames::has(const StartFrame& frame) const {
  return std::binary_search(frames_.begin(), frames_.end(), frame);
}

int StartFrames::index_of(const StartFrame& frame) const {
  return static_cast<int>(std::lower_bound(frames_.begin(), frames_.end(), frame) - frames_.begin());
}

bool StartFrames::same_solution(const StartFrame& a, const StartFrame& b) const {
  return solution_of(a) != 0 && solution_of(a) == solution_of(b);
}

std::vector<int> StartFrames::place(std::vector<PairAlignment> pairs, int robot) {
  tie_solutions(pairs);
  std::vector<int> part = connected_to(robot, pairs);
  // W is the frame of the anchor's start that reaches most segments (usually it has only one).
  std::ptrdiff_t most = 0;
  for (int f = 0; f < static_cast<int>(frames_.size()); ++f) {
    if (frames_[f].robot != part.front()) continue;
    const Frames grown = spanning_tree(pairs, extents_, f);
    const auto reached =
        std::count_if(grown.T_W_O.begin(), grown.T_W_O.end(), [](const auto& T) { return T.has_value(); });
    if (reached <= most) continue;
    most = reached;
    root_ = f;
    T_W_S_ = grown.T_W_O;
  }
  return part;
}

// The frames of one solution are tied to the first of them.
bool StartFrames::unmoved() const {
  for (std::size_t f = 0; f < frames_.size(); ++f) {
    if (!T_W_S_[f]) continue;
    if (solutions_[f] == 0 || solutions_[f] != solutions_[root_]) return false;
    if (!T_W_S_[f]->matrix().isIdentity(0.0)) return false;
  }
  return true;
}

void StartFrames::tie_solutions(std::vector<PairAlignment>& pairs) const {
  std::map<std::int64_t, int> first_of;
  for (int b = 0; b < static_cast<int>(frames_.size()); ++b) {
    if (solutions_[b] == 0) continue;
    const auto [first, fresh] = first_of.emplace(solutions_[b], b);
    if (fresh) continue;
    PairAlignment pair{first->second, b, {}};
    pair.alignment.inliers = kSameSolution;
    pair.alignment.ok = true;
    pairs.push_back(pair);
  }
}

std::vector<int> StartFrames::connected_to(int robot, const std::vector<PairAlignment>& pairs) const {
  std::set<int> reached{robot};
  for (bool grown = true; grown;) {
    grown = false;
    for (const PairAlignment& pair : pairs) {
      if (!pair.alignment.ok) continue;
      const int a = frames_[pair.a].robot;
      const int b = frames_[pair.b].robot;
      if (reached.count(a) == reached.count(b)) continue;
      reached.insert({a, b});
      grown = true;
    }
  }
  return {reached.begin(), reached.end()};
}

}  // namespace covey::pgo
