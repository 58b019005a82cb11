// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// A pose graph as its robots have it, cut at a separator: a smallest vertex cover of the loops of each pair of robots
// (vertex_cover.h), which both of a pair can work out. Without the separator's poses no loop joins two robots, so each can
// eliminate its own interior alone, and what remains is a matter of the separator. A robot's part has its own poses, and the other
// robots' separator poses that its loops touch; a loop's two diagonal blocks are with the robots of its poses, the block between
// them is with one of the two.

#include <map>
#include <vector>

#include "core/pgo/pose_graph.h"

namespace covey::pgo {

// Poses by flat index: the robot's own interior first, then the separator poses that it touches, ascending each.
struct RobotPart {
  int robot = 0;
  std::vector<int> poses;
  int interior = 0;
  std::vector<const Edge*> edges;  // with an end at this robot
  std::map<int, int> place;        // in `poses`

  int boundary() const { return static_cast<int>(poses.size()) - interior; }
  int boundary_pose(int k) const { return poses[interior + k]; }
};

class SeparatedGraph {
 public:
  explicit SeparatedGraph(const PoseGraph& graph);  // kept by reference

  const PoseGraph& graph() const { return graph_; }
  const std::vector<RobotPart>& parts() const { return parts_; }  // of the robots that have poses
  const std::vector<int>& separator() const { return separator_; }
  int flat(const PoseId& pose) const { return offsets_[pose.robot] + pose.index; }
  bool owns(const RobotPart& part, int pose) const {
    return offsets_[part.robot] <= pose && pose < offsets_[part.robot + 1];
  }
  int place_in_separator(int pose) const;

  // Which of the robots that know an edge has the block between its two poses: the one whose pose is eliminated, of two
  // separator poses the lower robot.
  bool couples(const RobotPart& part, const Edge& edge) const;

  // The poses of a list whose translations are held: the first of each connected piece of the graph that no pose of `elsewhere`
  // belongs to. A robot sees from its own edges whether a piece of its interior touches the separator, the first robot from the
  // names of the pieces that come with the complements.
  std::vector<int> held_poses(const std::vector<int>& poses, const std::vector<int>& elsewhere) const;

  // Poses that the others have to know: both ends of all shared edges.
  std::vector<int> public_poses() const;

 private:
  bool is_separator(int pose) const;
  void find_separator();
  RobotPart part_of(int robot) const;

  const PoseGraph& graph_;
  std::vector<int> offsets_;
  std::vector<int> pieces_;  // connected ones, of each pose
  std::vector<int> separator_;
  std::vector<RobotPart> parts_;
};

}  // namespace covey::pgo
