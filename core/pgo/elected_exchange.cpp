// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/elected_exchange.h"

#include <algorithm>
#include <set>
#include <utility>

#include "core/base/error.h"
#include "core/pgo/public_poses.h"

namespace covey::pgo {
namespace {

// The message with the head that the mail gives it.
template <typename T>
T addressed(const RoundMail& mail, T content) {
  const T head = mail.compose<T>();
  content.from = head.from;
  content.to = head.to;
  content.round = head.round;
  content.anchor = head.anchor;
  return content;
}

}  // namespace

ElectedExchange::ElectedExchange(const AgreedProblem& problem, const ElectedOptions& options, bool for_all)
    : problem_(problem), options_(options), for_all_(for_all) {
  for (const int robot : problem.part) names_[robot] = problem.members.at(robot).join.segments;
}

void ElectedExchange::send_first(RoundMail& mail) const {
  dpgo_graph_t part{};
  part.dimension = static_cast<std::int8_t>(options_.packing.dimension);
  if (!am_elected()) part = part_of(problem_.graph, names_, options_.packing);
  mail.send(addressed(mail, std::move(part)));
}

bool ElectedExchange::fits(int robot, const RoundMessage& message) const {
  if (!parts_are_there_) {
    const auto* part = std::get_if<dpgo_graph_t>(&message);
    if (part == nullptr || part->dimension != options_.packing.dimension) return false;
    const int segments = robot == elected() ? 0 : problem_.members.at(robot).join.n_segments;
    const bool full = part->n_gravity > 0;
    return part->n_segments == segments && (segments == 0 || full == options_.packing.full_covariances);
  }
  const auto* poses = std::get_if<dpgo_poses_t>(&message);
  if (poses == nullptr) return false;
  if (robot != elected()) return poses->n_segments == 0;
  return am_elected() || share_of(*poses, problem_.graph, names_, options_).has_value();
}

bool ElectedExchange::advance(RoundMail& mail) {
  if (parts_are_there_) {
    if (!am_elected()) poses_ = mail.from<dpgo_poses_t>(elected());
    return false;
  }
  parts_are_there_ = true;
  dpgo_poses_t answer{};
  answer.dimension = static_cast<std::int8_t>(options_.packing.dimension);
  if (am_elected()) {
    std::vector<dpgo_graph_t> parts = {part_of(problem_.graph, names_, options_.packing)};
    for (const int robot : problem_.part) {
      if (robot != elected()) parts.push_back(mail.from<dpgo_graph_t>(robot));
    }
    Gathered gathered = solve_parts(parts, options_);
    iterations_ = gathered.iterations;
    poses_ = std::move(gathered.poses);
    answer = for_all_ ? poses_ : without_own(poses_);
  }
  mail.send(addressed(mail, std::move(answer)));
  return true;
}

RoundResult ElectedExchange::result() const {
  const auto share = share_of(poses_, problem_.graph, names_, options_);
  COVEY_CHECK(share.has_value());
  // A robot none of whose segments is connected is a part of its own, in the frame of its first.
  StartFrame root{problem_.robot(), 0};
  for (const ElectedShare::Placed& placed : share->segments) {
    if (placed.anchor >= 0) root = {placed.anchor, placed.anchor_segment};
  }
  std::set<int> robots = {problem_.robot()};
  for (int s = 0; s < poses_.n_segments; ++s) {
    if (poses_.anchors[s] == root.robot) robots.insert(poses_.robots[s]);
  }
  const dpgo_join_t& join = problem_.members.at(root.robot).join;
  const SE3 T_W_F = pose_at(join.T_O_K, root.segment);

  RoundResult result;
  result.name = problem_.name;
  result.anchor = root.robot;
  result.frame = frame_name(problem_.name, root.robot, join.segments[root.segment]);
  result.robots.assign(robots.begin(), robots.end());
  result.graph = problem_.graph.hash;
  result.keyframes = problem_.graph.poses();
  result.updates = iterations_;
  result.warnings = problem_.warnings;
  for (std::size_t s = 0; s < share->segments.size(); ++s) {
    const Segment& segment = problem_.graph.segments[s];
    SegmentResult placed{segment.name, share->segments[s].anchor >= 0, {}};
    for (const SE3& T_F_K : share->segments[s].T_F_K) placed.T_W_K.push_back(T_W_F * T_F_K);
    if (!placed.placed) {
      for (const OdometryPose& pose : segment.poses) placed.T_W_K.push_back(pose.T_O_K);
    }
    for (std::size_t k = 1; k < segment.poses.size(); ++k) {
      const OdometryPose& pose = segment.poses[k];
      result.owned_cost += deciding_residual_sq(pose.T_P_K, pose.precision, pose.covariance,
                                                placed.T_W_K[k - 1], placed.T_W_K[k], options_);
    }
    result.segments.push_back(std::move(placed));
  }
  for (const ElectedShare::Decision& decision : share->loops) {
    const bool owned = problem_.other_end(decision.loop).robot >= problem_.robot();
    add_loop({decision.loop, decision.kept ? 1.0 : 0.0, decision.r2}, owned, options_.barc2, result);
  }
  add_warnings(problem_, options_.barc2, result);
  return result;
}

}  // namespace covey::pgo
