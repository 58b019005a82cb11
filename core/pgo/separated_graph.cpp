// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/separated_graph.h"

#include <algorithm>
#include <utility>

#include "core/graph/key.h"
#include "core/pgo/vertex_cover.h"

namespace covey::pgo {
namespace {

std::vector<int> sorted_set(std::vector<int> values) {
  std::sort(values.begin(), values.end());
  values.erase(std::unique(values.begin(), values.end()), values.end());
  return values;
}

}  // namespace

SeparatedGraph::SeparatedGraph(const PoseGraph& graph)
    : graph_(graph), offsets_(graph.offsets()), pieces_(connected_parts(graph)) {
  find_separator();
  for (int robot = 0; robot < graph.robots(); ++robot) {
    if (graph.poses_per_robot[robot] > 0) parts_.push_back(part_of(robot));
  }
}

bool SeparatedGraph::is_separator(int pose) const {
  return std::binary_search(separator_.begin(), separator_.end(), pose);
}

int SeparatedGraph::place_in_separator(int pose) const {
  return static_cast<int>(std::lower_bound(separator_.begin(), separator_.end(), pose) - separator_.begin());
}

bool SeparatedGraph::couples(const RobotPart& part, const Edge& edge) const {
  if (!edge.between_robots()) return true;
  const bool is_from = edge.from.robot == part.robot;
  const bool mine = is_separator(flat(is_from ? edge.from : edge.to));
  const bool others = is_separator(flat(is_from ? edge.to : edge.from));
  if (mine != others) return others;
  return part.robot == std::min(edge.from.robot, edge.to.robot);
}

std::vector<int> SeparatedGraph::held_poses(const std::vector<int>& poses,
                                            const std::vector<int>& elsewhere) const {
  std::vector<bool> seen(pieces_.size() + 1, false);
  for (const int pose : elsewhere) seen[pieces_[pose]] = true;
  std::vector<int> held;
  for (const int pose : poses) {
    if (!seen[pieces_[pose]]) held.push_back(pose);
    seen[pieces_[pose]] = true;
  }
  return held;
}

std::vector<int> SeparatedGraph::public_poses() const {
  std::vector<int> poses;
  for (const Edge& edge : graph_.edges) {
    if (edge.between_robots()) poses.insert(poses.end(), {flat(edge.from), flat(edge.to)});
  }
  return sorted_set(std::move(poses));
}

void SeparatedGraph::find_separator() {
  std::map<std::pair<int, int>, std::vector<std::pair<graph::Key, graph::Key>>> shared;
  const auto key = [this](const PoseId& pose) {
    return graph::Key{'x', static_cast<std::uint64_t>(flat(pose))};
  };
  for (const Edge& edge : graph_.edges) {
    if (!edge.between_robots()) continue;
    const auto [a, b] = std::minmax(edge.from, edge.to);
    shared[{a.robot, b.robot}].emplace_back(key(a), key(b));
  }
  for (const auto& [pair, edges] : shared) {
    for (const graph::Key pose : vertex_cover(edges)) separator_.push_back(static_cast<int>(pose.id));
  }
  separator_ = sorted_set(std::move(separator_));
}

RobotPart SeparatedGraph::part_of(int robot) const {
  RobotPart part;
  part.robot = robot;
  std::vector<int> boundary;
  for (int pose = offsets_[robot]; pose < offsets_[robot + 1]; ++pose) {
    (is_separator(pose) ? boundary : part.poses).push_back(pose);
  }
  part.interior = static_cast<int>(part.poses.size());
  for (const Edge& edge : graph_.edges) {
    if (edge.from.robot != robot && edge.to.robot != robot) continue;
    part.edges.push_back(&edge);
    if (!edge.between_robots() || !couples(part, edge)) continue;
    boundary.push_back(flat(edge.from.robot == robot ? edge.to : edge.from));
  }
  boundary = sorted_set(std::move(boundary));
  part.poses.insert(part.poses.end(), boundary.begin(), boundary.end());
  for (std::size_t k = 0; k < part.poses.size(); ++k) part.place[part.poses[k]] = static_cast<int>(k);
  return part;
}

}  // namespace covey::pgo
