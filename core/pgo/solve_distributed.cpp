// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/solve_distributed.h"

#include <algorithm>
#include <utility>

#include "core/base/error.h"
#include "core/pgo/dgnc_round.h"
#include "core/pgo/team_split.h"

namespace covey::pgo {
namespace {

const char* kind_of(const RoundMessage& message) {
  return std::visit([](const auto& m) { return m.getTypeName(); }, message);
}

}  // namespace

DistributedResult solve_distributed(const PoseGraph& graph, const DistributedOptions& options) {
  const std::map<int, TeamMember> team = split_team(graph, options.start);
  COVEY_CHECK(!team.empty());
  std::vector<int> members;
  for (const auto& [robot, member] : team) members.push_back(robot);
  DgncOptions dgnc = options.dgnc;
  dgnc.alignment.keep_same_frame = options.start.has_value();
  std::map<int, DgncRound> rounds;
  for (const auto& [robot, member] : team) {
    rounds.emplace(robot, DgncRound({1, members.front()}, members, member.graph, member.starts, 0.0, dgnc));
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
        return gather_poses(graph, team, segments);
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
    for (SegmentResult& segment : segments[robot]) segment.placed &= mine.anchor == members.front();
    for (const LoopResult& loop : mine.loops) result.weights[loop.loop.key] = loop.weight;
    result.block_updates += mine.updates;
    result.messages = std::max(result.messages, round.number() + 1);
    result.stages = std::max(result.stages, mine.stages);
    result.updates = std::max(result.updates, mine.updates);
    for (const auto& said : {mine.rejected, mine.warnings})
      result.warnings.insert(result.warnings.end(), said.begin(), said.end());
    if (mine.anchor != members.front()) continue;
    result.cost += mine.owned_cost;
    result.kept += mine.owned_kept;
  }
  result.poses = gather_poses(graph, team, segments);
  result.placed = gather_placed(graph, team, segments);
  return result;
}

}  // namespace covey::pgo
