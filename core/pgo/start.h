// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Where to start solving a pose graph from.
//
// odometry_start    each robot's odometry chained from its own first pose at identity; robots lie on top of each other.
//                   Where the chain of a robot is broken, its other edges bridge it; what none reaches begins at identity
//                   again.
// chordal_start     the least-squares cost without the constraint that rotations are rotations: linear in the rotation
//                   matrices, which are then projected, then linear in the translations. Needs a connected graph; knows no
//                   outliers. Source: Carlone, Tron, Daniilidis, Dellaert, "Initialization techniques for 3D SLAM", ICRA
//                   2015, section III-B.
// robust_start      odometry_start of each robot, put into one frame by robust alignment of every pair of robots over all
//                   its loops and a spanning tree (frame_tree.h); the anchor is the first robot with poses.
// naive_start       the same with one random loop per edge of a random tree instead of an alignment: what goes wrong
//                   without robust_start.

#include <cstdint>
#include <vector>

#include "core/pgo/frame_tree.h"
#include "core/pgo/pose_graph.h"

namespace covey::pgo {

Poses odometry_start(const PoseGraph& graph);

Poses chordal_start(const PoseGraph& graph);

struct RobustStart {
  Poses poses;                            // of robots without a frame: in their own
  Frames frames;                          // where each robot's odometry frame lies in the anchor's
  std::vector<PairAlignment> alignments;  // the possible ones of each pair of robots that has loops
  std::vector<FrameExtent> extents;       // of each robot
};
RobustStart robust_start(const PoseGraph& graph, AlignmentOptions options = {});

Poses naive_start(const PoseGraph& graph, std::uint64_t seed);

}  // namespace covey::pgo
