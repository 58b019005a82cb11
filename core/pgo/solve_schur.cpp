// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/solve_schur.h"

#include <set>

#include "core/base/error.h"
#include "core/geometry/se2.h"
#include "core/graph/pose_factors.h"
#include "core/pgo/cost.h"
#include "core/pgo/edge_factors.h"

namespace covey::pgo {
namespace {

// A prior with the precision of an edge. Its residual is zero in the end, since the rest does not care where the whole lies.
void hold(graph::Graph& factors, const graph::Values& values, graph::Key key, double kappa, double tau) {
  if (values.type(key).space == graph::Space::kSE2) {
    const Eigen::Vector3d information(tau, tau, 2.0 * kappa);
    factors.add(graph::Prior<SE2>{values.get<SE2>(key)}, {key},
                graph::Noise<3>::information(information.asDiagonal()));
  } else {
    Vector6d information;
    information << Eigen::Vector3d::Constant(tau), Eigen::Vector3d::Constant(2.0 * kappa);
    factors.add(graph::Prior<SE3>{values.get<SE3>(key)}, {key},
                graph::Noise<6>::information(information.asDiagonal()));
  }
}

struct Part {
  graph::Graph factors;
  graph::Values values;
  std::vector<std::size_t> edges;
};

// The factors that touch each robot's poses, and the starts of all poses that these touch.
std::map<int, Part> split(const PoseGraph& graph, const Poses& start) {
  std::map<int, Part> parts;
  const std::vector<int> offsets = graph.offsets();
  const auto set_start = [&](Part& part, const PoseId& pose) {
    set_pose(part.values, schur_key(pose.robot, pose.index), start[offsets[pose.robot] + pose.index],
             graph.dimension);
  };
  for (int robot = 0; robot < graph.robots(); ++robot) {
    for (int index = 0; index < graph.poses_per_robot[robot]; ++index)
      set_start(parts[robot], {robot, index});
  }
  for (std::size_t e = 0; e < graph.edges.size(); ++e) {
    const Edge& edge = graph.edges[e];
    for (const int robot : std::set{edge.from.robot, edge.to.robot}) {
      Part& part = parts.at(robot);
      set_start(part, edge.from);
      set_start(part, edge.to);
      add_edge(part.factors, edge, graph.dimension, schur_key(edge.from.robot, edge.from.index),
               schur_key(edge.to.robot, edge.to.index));
      part.edges.push_back(e);
    }
  }
  return parts;
}

}  // namespace

std::vector<SchurMember> schur_members(const PoseGraph& graph, const Poses& start,
                                       const SchurOptions& options) {
  COVEY_CHECK(graph.poses() > 0 && static_cast<int>(start.size()) == graph.poses());
  std::map<int, Part> parts = split(graph, start);
  auto& [anchor, anchor_part] = *parts.begin();
  const Edge any = graph.edges.empty() ? Edge{} : graph.edges.front();
  hold(anchor_part.factors, anchor_part.values, schur_key(anchor, 0), any.kappa, any.tau);
  std::vector<SchurMember> members;
  for (auto& [robot, part] : parts) {
    members.push_back({SchurBlock(robot, part.factors, part.values, options), std::move(part.edges)});
  }
  return members;
}

Poses gather_poses(const PoseGraph& graph, const std::vector<SchurMember>& members) {
  Poses poses;
  for (const auto& [block, edges] : members) {
    for (int index = 0; index < graph.poses_per_robot[block.robot()]; ++index) {
      poses.push_back(get_pose(block.poses(), schur_key(block.robot(), index)));
    }
  }
  return poses;
}

SolveSchurResult solve_schur(const PoseGraph& graph, const Poses& start, const SolveSchurOptions& options) {
  std::vector<SchurMember> members = schur_members(graph, start, options.step);
  SchurTeam team(options.step);
  SolveSchurResult result;
  while (result.rounds < options.max_rounds && !result.converged && !team.stuck()) {
    std::vector<dpgo_reduced_t> reduced;
    for (SchurMember& member : members) reduced.push_back(member.block.reduce());
    const dpgo_move_t step = team.solve(reduced);
    for (std::size_t k = 1; k < reduced.size(); ++k)  // the first one's own needs no message
      result.bytes[dpgo_reduced_t::getTypeName()] += reduced[k].getEncodedSize();
    if (members.size() > 1) result.bytes[dpgo_move_t::getTypeName()] += step.getEncodedSize();
    for (SchurMember& member : members) COVEY_CHECK(member.block.step(step));
    if (!step.taken) continue;
    ++result.rounds;
    result.costs.push_back(team.cost());
    result.separating_poses = step.n;
    result.converged = team.promised() <= options.tolerance * team.cost();
    if (options.stop && options.stop([&] { return gather_poses(graph, members); })) break;
  }
  result.block_updates = result.rounds * static_cast<int>(members.size());
  result.poses = gather_poses(graph, members);
  result.cost = cost(graph, result.poses);
  return result;
}

}  // namespace covey::pgo
