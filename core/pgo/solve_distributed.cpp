// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/solve_distributed.h"

#include <algorithm>
#include <utility>

#include "core/base/error.h"
#include "core/pgo/dgnc_round.h"

namespace covey::pgo {
namespace {

struct TeamMember {
  GraphSnapshot graph;
  std::vector<SegmentStart> starts;
  std::vector<int> first;  // pose index of each segment's first pose
};

// Where each pose of a robot stands: place of its segment, and id within it.
KeyframeName name_of(const TeamMember& member, const PoseId& pose) {
  const auto next = std::upper_bound(member.first.begin(), member.first.end(), pose.index);
  const auto segment = static_cast<std::size_t>(next - member.first.begin()) - 1;
  return {pose.robot, member.graph.segments[segment].name, pose.index - member.first[segment]};
}

// One entry per robot with poses.
std::map<int, TeamMember> split(const PoseGraph& graph, const std::optional<Poses>& start) {
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

Poses gather(const PoseGraph& graph, const std::map<int, TeamMember>& team,
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

const char* kind_of(const RoundMessage& message) {
  return std::visit([](const auto& m) { return m.getTypeName(); }, message);
}

}  // namespace

DistributedResult solve_distributed(const PoseGraph& graph, const DistributedOptions& options) {
  const std::map<int, TeamMember> team = split(graph, options.start);
  COVEY_CHECK(!team.empty());
  std::vector<int> members;
  for (const auto& [robot, member] : team) members.push_back(robot);
  std::map<int, DgncRound> rounds;
  for (const auto& [robot, member] : team) {
    rounds.emplace(robot,
                   DgncRound({1, members.front()}, members, member.graph, member.starts, 0.0, options.dgnc));
  }

  DistributedResult result;
  const DgncRound& anchor = rounds.at(members.front());
  int asked = 0;
  for (;;) {
    for (auto& [robot, round] : rounds) {
      for (const RoundMessage& message : round.take_outgoing()) {
        result.bytes[kind_of(message)] +=
            std::visit([](const auto& m) { return m.getEncodedSize(); }, message);
        for (auto& [other, receiver] : rounds) {
          if (other != robot) receiver.receive(message);
        }
      }
    }
    bool moved = false;
    for (auto& [robot, round] : rounds) moved = round.advance() || moved;
    if (!moved) break;
    if (options.stop && anchor.updates() > asked && !anchor.done()) {
      asked = anchor.updates();
      const auto poses = [&] {
        std::map<int, std::vector<SegmentResult>> segments;
        for (const auto& [robot, round] : rounds) segments[robot] = round.current();
        return gather(graph, team, segments);
      };
      if (options.stop({asked, anchor.mu(), poses})) {
        for (auto& [robot, round] : rounds) round.stop();
        break;
      }
    }
  }

  std::map<int, std::vector<SegmentResult>> segments;
  result.weights.assign(graph.edges.size(), 1.0);
  for (const auto& [robot, round] : rounds) {
    COVEY_CHECK(round.done());
    const RoundResult& mine = round.result();
    segments[robot] = mine.segments;
    for (const LoopResult& loop : mine.loops) result.weights[loop.loop.key] = loop.weight;
    result.block_updates += mine.updates;
    result.messages = std::max(result.messages, round.number() + 1);
    result.stages = std::max(result.stages, mine.stages);
    result.updates = std::max(result.updates, mine.updates);
    result.warnings.insert(result.warnings.end(), mine.warnings.begin(), mine.warnings.end());
    if (mine.anchor != members.front()) continue;
    result.cost += mine.owned_cost;
    result.kept += mine.owned_kept;
  }
  result.poses = gather(graph, team, segments);
  result.placed.assign(graph.poses(), false);
  const std::vector<int> offsets = graph.offsets();
  for (const auto& [robot, round] : rounds) {
    if (round.result().anchor != members.front()) continue;
    for (std::size_t s = 0; s < segments[robot].size(); ++s) {
      if (!segments[robot][s].placed) continue;
      std::fill_n(result.placed.begin() + offsets[robot] + team.at(robot).first[s],
                  segments[robot][s].T_W_K.size(), true);
    }
  }
  return result;
}

}  // namespace covey::pgo
