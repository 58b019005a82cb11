// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// What a robot believed while it drove, from what was said on its bus in the order in which it was said: at the moment of a
// keyframe K, the last finished round's pose of the newest keyframe L that it had solved, taken on by odometry,
//
//   T_W_K = T_W_L T_O_L^-1 T_O_K         W: the anchor's frame, O: odometry's frame of the segment that K and L are in.
//
// Later rounds change nothing of it. Keyframes count that came after the robot's first round in the anchor's frame and
// whose segment that round had placed: before, the robot had no pose in W.

#include <covey/keyframe_t.hpp>
#include <covey/trajectory_t.hpp>
#include <map>
#include <utility>

#include "core/geometry/trajectory.h"

namespace covey {

class OnlineTrajectory {
 public:
  // anchor: whose O is W; rounds in the frame of another robot are not looked at.
  OnlineTrajectory(int robot, int anchor) : robot_(robot), anchor_(anchor) {}

  // In the order of the bus. What is said twice counts the first time; what is of another robot, or holds no pose where one
  // should be, is left out.
  void take(const keyframe_t& keyframe);
  void take(const trajectory_t& part);

  int keyframes() const { return static_cast<int>(T_O_K_.size()); }  // heard
  Trajectory believed() const;  // of those that count, by the keyframes' stamps

 private:
  using Name = std::pair<Utime, int>;  // segment, id

  void finish_round();

  int robot_;
  int anchor_;
  std::map<Name, SE3> T_O_K_;
  std::map<Name, SE3> T_W_K_;  // the last finished round
  std::map<Utime, SE3> believed_;
  std::map<int, trajectory_t> parts_;  // of the round that is being said
};

}  // namespace covey
