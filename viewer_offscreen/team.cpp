// SPDX-License-Identifier: BSD-3-Clause
#include "viewer_offscreen/team.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <tuple>

#include "procs/common/bus.h"
#include "viewer_offscreen/colour.h"

namespace covey::viewer {
namespace {

constexpr int kMostParts = 10'000;
constexpr double kFarthestM = 1e8;  // beyond the planet

using PoseName = std::tuple<int, std::int64_t, int>;  // robot, segment, id

struct KnownPose {
  Eigen::Vector3d p_W;
  int anchor;  // whose W
};

Eigen::Vector3d position(const trajectory_t& part, int k) {
  return Eigen::Map<const Eigen::Vector3d>(&part.T_W_K[7 * static_cast<std::size_t>(k) + 4]);
}

bool has_values(const trajectory_t& part) {
  if (part.n_values != 7LL * part.n) return false;
  for (int k = 0; k < part.n; ++k) {
    if (!(position(part, k).array().abs() < kFarthestM).all()) return false;
  }
  return true;
}

template <typename Message>
bool has_place(const Message& part) {
  return part.robot >= 0 && part.robot <= kLastRobot && part.parts >= 1 && part.parts <= kMostParts &&
         part.part >= 0 && part.part < part.parts;
}

bool has_poses(const std::vector<trajectory_t>& parts) {
  return std::any_of(parts.begin(), parts.end(), [](const trajectory_t& part) { return part.n > 0; });
}

std::optional<LoopLine> loop_line(const std::map<PoseName, KnownPose>& poses, const loop_weights_t& part,
                                  std::size_t k) {
  const auto a = poses.find({part.robots_a[k], part.segments_a[k], part.ids_a[k]});
  const auto b = poses.find({part.robots_b[k], part.segments_b[k], part.ids_b[k]});
  if (a == poses.end() || b == poses.end() || a->second.anchor != b->second.anchor) return std::nullopt;
  return LoopLine{a->second.p_W, b->second.p_W,
                  part.weights[k] > 0.5 ? LoopStatus::kAccepted : LoopStatus::kRejected};
}

}  // namespace

template <typename Message>
const char* Rounds<Message>::take(const Message& part) {
  if (part.utime < utime_) return "old";
  if (part.utime > utime_) parts_.clear();
  const bool whole = !newest_.empty() && newest_.front().utime == part.utime;
  if (whole || parts_.contains(part.part)) return "duplicate";
  if (!parts_.empty() && parts_.begin()->second.parts != part.parts) return "values";
  utime_ = part.utime;
  parts_[part.part] = part;
  if (static_cast<int>(parts_.size()) < part.parts) return nullptr;
  newest_.clear();
  for (auto& [number, message] : parts_) newest_.push_back(std::move(message));
  parts_.clear();
  ++completed_;
  return nullptr;
}

const char* Team::take(const trajectory_t& part) {
  if (!has_place(part) || !has_values(part)) return "values";
  return trajectories_[part.robot].take(part);
}

const char* Team::take(const loop_weights_t& part) {
  if (!has_place(part)) return "values";
  return loops_[part.robot].take(part);
}

int Team::rounds() const {
  int rounds = 0;
  for (const auto& [robot, said] : trajectories_) rounds += said.completed();
  for (const auto& [robot, said] : loops_) rounds += said.completed();
  return rounds;
}

int Team::robots() const {
  return static_cast<int>(std::count_if(trajectories_.begin(), trajectories_.end(),
                                        [](const auto& robot) { return has_poses(robot.second.newest()); }));
}

void Team::add_to(FigureContent& content) const {
  std::map<PoseName, KnownPose> poses;
  std::optional<int> first_anchor;
  for (const auto& [robot, rounds] : trajectories_) {
    if (!has_poses(rounds.newest())) continue;
    const int anchor = rounds.newest().front().anchor;
    if (!first_anchor) first_anchor = anchor;
    Curve curve;
    curve.name = anchor == *first_anchor ? fmt::format("robot{}", robot)
                                         : fmt::format("robot{} (W of robot{})", robot, anchor);
    curve.colour = palette_colour(robot);
    for (const trajectory_t& part : rounds.newest()) {
      for (int k = 0; k < part.n; ++k) {
        const auto i = static_cast<std::size_t>(k);
        curve.points_W.push_back(position(part, k));
        poses[{robot, part.segments[i], part.ids[i]}] = {curve.points_W.back(), anchor};
      }
    }
    content.trajectories.push_back(std::move(curve));
  }
  for (const auto& [speaker, rounds] : loops_) {
    for (const loop_weights_t& part : rounds.newest()) {
      for (std::size_t k = 0; k < part.weights.size(); ++k) {
        const int owner = std::min(part.robots_a[k], part.robots_b[k]);
        const auto said = loops_.find(owner);
        if (speaker != owner && said != loops_.end() && !said->second.newest().empty()) continue;
        if (const auto line = loop_line(poses, part, k)) content.loops.push_back(*line);
      }
    }
  }
}

}  // namespace covey::viewer
