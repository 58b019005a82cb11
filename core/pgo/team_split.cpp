// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/team_split.h"

#include <algorithm>

namespace covey::pgo {
namespace {

// Where each pose of a robot stands: place of its segment, and id within it.
KeyframeName name_of(const TeamMember& member, const PoseId& pose) {
  const auto next = std::upper_bound(member.first.begin(), member.first.end(), pose.index);
  const auto segment = static_cast<std::size_t>(next - member.first.begin()) - 1;
  return {pose.robot, member.graph.segments[segment].name, pose.index - member.first[segment]};
}

}  // namespace

std::map<int, TeamMember> split_team(const PoseGraph& graph, const std::optional<Poses>& start) {
  const std::vector<int> offsets = graph.offsets();
  std::map<int, TeamMember> team;
  std::vector<const Edge*> odometry(graph.poses(), nullptr);  // into each pose
  std::vector<bool> is_loop(graph.edges.size(), true);
  for (std::size_t e = 0; e < graph.edges.size(); ++e) {
    const Edge& edge = graph.edges[e];
    if (edge.kind != EdgeKind::kOdometry || edge.between_robots() || edge.to.index != edge.from.index + 1)
      continue;
    const Edge*& into = odometry[offsets[edge.to.robot] + edge.to.index];
    if (into != nullptr) continue;
    into = &edge;
    is_loop[e] = false;
  }
  for (int robot = 0; robot < graph.robots(); ++robot) {
    if (graph.poses_per_robot[robot] == 0) continue;
    TeamMember& member = team[robot];
    member.graph.robot = robot;
    for (int index = 0; index < graph.poses_per_robot[robot]; ++index) {
      const Edge* into = odometry[offsets[robot] + index];
      if (into == nullptr) {
        member.first.push_back(index);
        member.graph.segments.push_back({index + 1, {}});
        member.starts.push_back({start ? 1 : 0, {}});
      }
      auto& poses = member.graph.segments.back().poses;
      auto& T_S_K = member.starts.back().T_S_K;
      OdometryPose pose;
      if (into != nullptr) {
        pose.T_P_K = into->measurement;
        pose.T_O_K = poses.back().T_O_K * into->measurement;
        pose.precision = {into->kappa, into->tau};
      } else if (start) {
        pose.T_O_K = (*start)[offsets[robot] + index];
      }
      T_S_K.push_back(start ? (*start)[offsets[robot] + index] : pose.T_O_K);
      poses.push_back(pose);
    }
  }
  for (std::size_t e = 0; e < graph.edges.size(); ++e) {
    if (!is_loop[e]) continue;
    const Edge& edge = graph.edges[e];
    const GraphLoop loop{e,
                         name_of(team.at(edge.from.robot), edge.from),
                         name_of(team.at(edge.to.robot), edge.to),
                         edge.measurement,
                         {edge.kappa, edge.tau},
                         edge.known_inlier};
    if (edge.between_robots()) {
      team.at(edge.from.robot).graph.shared_loops[edge.to.robot].push_back(loop);
      team.at(edge.to.robot).graph.shared_loops[edge.from.robot].push_back(loop);
    } else {
      team.at(edge.from.robot).graph.private_loops.push_back(loop);
    }
  }
  return team;
}

Poses gather_poses(const PoseGraph& graph, const std::map<int, TeamMember>& team,
                   const std::map<int, std::vector<SegmentResult>>& segments) {
  const std::vector<int> offsets = graph.offsets();
  Poses poses(graph.poses());
  for (const auto& [robot, list] : segments) {
    for (std::size_t s = 0; s < list.size(); ++s) {
      std::copy(list[s].T_W_K.begin(), list[s].T_W_K.end(),
                poses.begin() + offsets[robot] + team.at(robot).first[s]);
    }
  }
  return poses;
}

std::vector<bool> gather_placed(const PoseGraph& graph, const std::map<int, TeamMember>& team,
                                const std::map<int, std::vector<SegmentResult>>& segments) {
  const std::vector<int> offsets = graph.offsets();
  std::vector<bool> placed(graph.poses(), false);
  for (const auto& [robot, list] : segments) {
    const TeamMember& member = team.at(robot);
    for (std::size_t s = 0; s < list.size(); ++s) {
      std::fill_n(placed.begin() + offsets[robot] + member.first[s], member.graph.segments[s].poses.size(),
                  list[s].placed);
    }
  }
  return placed;
}

}  // namespace covey::pgo
