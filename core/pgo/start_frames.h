// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The frames that the segments of a round's members start in, and where they lie in W. Each begins in its own; loops between
// two segments align their frames (frame_tree.h). Segments that an earlier round left in one frame stay so where no more
// loops speak for another alignment: a frame that a wrong loop made when there were few is not for ever. What is connected,
// through whichever robots, is one part of the team; W is a frame of the part's lowest robot.

#include <compare>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/geometry/se3.h"
#include "core/pgo/frame_tree.h"

namespace covey::pgo {

struct StartFrame {
  int robot = 0;
  int segment = 0;  // place in the robot's join
  auto operator<=>(const StartFrame&) const = default;
};

class StartFrames {
 public:
  // Ascending. solution: the name of the frame that an earlier round left, 0 for odometry.
  void add(const StartFrame& frame, std::int64_t solution, const FrameExtent& extent = {});

  bool has(const StartFrame& frame) const;
  int index_of(const StartFrame& frame) const;
  std::int64_t solution_of(const StartFrame& frame) const { return solutions_[index_of(frame)]; }
  bool same_solution(const StartFrame& a, const StartFrame& b) const;

  // Places in W what the alignments, by index_of, connect; returns the robots of the part that `robot` belongs to, ascending.
  std::vector<int> place(std::vector<PairAlignment> pairs, int robot);

  // After place(). pose_of: T_W_S; nothing for a frame that is not connected to W.
  const StartFrame& root() const { return frames_[root_]; }  // that is W
  const std::optional<SE3>& pose_of(const StartFrame& frame) const { return T_W_S_[index_of(frame)]; }
  // Whether all that is connected to W comes from one solution and lies as that had left it.
  bool unmoved() const;

 private:
  void tie_solutions(std::vector<PairAlignment>& pairs) const;
  std::vector<int> connected_to(int robot, const std::vector<PairAlignment>& pairs) const;

  std::vector<StartFrame> frames_;
  std::vector<std::int64_t> solutions_;  // of each frame
  std::vector<FrameExtent> extents_;
  std::vector<std::optional<SE3>> T_W_S_;
  int root_ = -1;
};

}  // namespace covey::pgo
