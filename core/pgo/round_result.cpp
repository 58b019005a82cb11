// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/round_result.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/pgo/cost.h"

namespace covey::pgo {

std::vector<SegmentResult> placed_segments(const AgreedProblem& problem, const std::vector<SE3>& T_root_K) {
  const SE3 T_W_root = problem.root_pose();
  std::vector<SegmentResult> segments;
  auto next = T_root_K.begin();
  for (std::size_t s = 0; s < problem.graph.segments.size(); ++s) {
    const Segment& segment = problem.graph.segments[s];
    SegmentResult placed{segment.name, problem.placed(static_cast<int>(s)), {}};
    for (std::size_t k = 0; k < segment.poses.size(); ++k) placed.T_W_K.push_back(T_W_root * *next++);
    segments.push_back(std::move(placed));
  }
  return segments;
}

RoundResult round_result(const AgreedProblem& problem, const RoundSolution& solution, double barc2) {
  RoundResult result;
  result.name = problem.name;
  result.anchor = problem.anchor();
  result.frame = problem.world();
  result.robots = problem.part;
  result.segments = placed_segments(problem, solution.T_root_K);
  result.graph = problem.graph.hash;
  result.keyframes = problem.graph.poses();
  result.warnings = problem.warnings;
  for (std::size_t s = 0; s < problem.graph.segments.size(); ++s) {
    const auto& odometry = problem.graph.segments[s].poses;
    const auto& T = result.segments[s].T_W_K;
    for (std::size_t k = 1; k < T.size(); ++k) {
      result.owned_cost += squared_residual(odometry[k].T_P_K, odometry[k].precision, T[k - 1], T[k]);
    }
  }
  const auto add = [&](const GraphLoop& loop, double weight, double r2, bool owned) {
    add_loop({loop, weight, r2}, owned, barc2, result);
  };
  const auto own_pose = [&](const KeyframeName& keyframe) {
    return result.segments[problem.segment_place(keyframe.segment)].T_W_K[keyframe.id];
  };
  for (std::size_t e = 0; e < problem.graph.private_loops.size(); ++e) {
    const GraphLoop& loop = problem.graph.private_loops[e];
    add(loop, solution.private_weights[static_cast<Eigen::Index>(e)],
        squared_residual(loop.T_A_B, loop.precision, own_pose(loop.a), own_pose(loop.b)), true);
  }
  const SE3 T_W_root = problem.root_pose();
  for (std::size_t e = 0; e < problem.ends.size(); ++e) {
    const SharedLoop& end = problem.ends[e];
    const SE3 T_mine = own_pose(problem.own_end(end.loop));
    const SE3 T_peer = T_W_root * solution.T_root_K_public.at(end.peer)[end.peer_place];
    const bool a_mine = end.loop.a.robot == problem.robot();
    add(end.loop, solution.shared_weights[static_cast<Eigen::Index>(e)],
        squared_residual(end.loop.T_A_B, end.loop.precision, a_mine ? T_mine : T_peer,
                         a_mine ? T_peer : T_mine),
        problem.owns(end));
  }
  add_warnings(problem, barc2, result);
  return result;
}

void add_loop(const LoopResult& loop, bool owned, double barc2, RoundResult& result) {
  result.loops.push_back(loop);
  ++result.loops_used;
  if (loop.weight == 1.0) ++result.loops_kept;
  if (!owned) return;
  ++(loop.weight == 1.0   ? result.weights_one
     : loop.weight == 0.0 ? result.weights_zero
                          : result.weights_between);
  if (loop.weight == 1.0) ++result.owned_kept;
  result.owned_cost += std::min(loop.r2, barc2);
}

void add_warnings(const AgreedProblem& problem, double barc2, RoundResult& result) {
  for (const RejectedPair& pair : rejected_pairs(result.loops, problem.robot()))
    result.rejected.push_back(sentence(pair, barc2));
  for (const auto& [a, b] : problem.lone_pairs) {
    if (a.robot != problem.robot() || a.robot == b.robot) continue;
    result.warnings.push_back(fmt::format(
        "one closure alone joins robots {}-{}: it is kept, and nothing can confirm or contradict it", a.robot,
        b.robot));
  }
  for (const SegmentResult& segment : result.segments) {
    if (segment.placed) continue;
    result.warnings.push_back(
        fmt::format("segment {} of robot {} has no closure that connects it to the team", segment.segment,
                    problem.robot()));
  }
}

}  // namespace covey::pgo
