// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/trajectories.h"

#include "core/base/error.h"

namespace covey::pgo {

std::vector<Trajectory> to_trajectories(const PoseGraph& graph, const Poses& poses) {
  COVEY_CHECK(static_cast<int>(poses.size()) == graph.poses());
  std::vector<Trajectory> robots;
  std::size_t flat = 0;
  for (const int count : graph.poses_per_robot) {
    Trajectory trajectory;
    for (int index = 0; index < count; ++index) trajectory.push_back({keyframe_utime(index), poses[flat++]});
    robots.push_back(std::move(trajectory));
  }
  return robots;
}

Poses from_trajectories(const PoseGraph& graph, const std::vector<Trajectory>& robots) {
  COVEY_CHECK(static_cast<int>(robots.size()) == graph.robots());
  Poses poses;
  for (int robot = 0; robot < graph.robots(); ++robot) {
    auto stamped = robots[robot].begin();
    for (int index = 0; index < graph.poses_per_robot[robot]; ++index) {
      while (stamped != robots[robot].end() && stamped->utime < keyframe_utime(index)) ++stamped;
      if (stamped == robots[robot].end() || stamped->utime != keyframe_utime(index)) {
        throw_input_error("robot {}: the trajectory has no pose at {}.000000, which is pose {} of the graph",
                          robot, 1 + index, index);
      }
      poses.push_back(stamped->pose);
    }
  }
  return poses;
}

}  // namespace covey::pgo
