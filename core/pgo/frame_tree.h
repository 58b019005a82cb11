// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// All frames of a team in one, from how the frames of pairs may lie in each other (frame_alignment.h): a tree that grows by
// one frame at a time, to the place that most loops of a pair agree on. Where so many could agree by chance, it gives way to
// another for which the evidence (alignment_evidence.h) is clearly better over all pairs that the frame forms with frames which
// have their places. So loops of two pairs that confirm each other, around a cycle of three frames, outweigh some more of one pair
// that stand alone. The chance of wrong loops to agree comes from the pair's loops that do not agree with the place.
//
// Around a cycle odometry has drifted, in proportion to the way.

#include <optional>
#include <utility>
#include <vector>

#include "core/geometry/se3.h"
#include "core/pgo/frame_alignment.h"

namespace covey::pgo {

// One of the possible alignments of a pair.
struct PairAlignment {
  int a = 0;
  int b = 0;
  AlignmentResult alignment;  // T_A_B: frame of b in frame of a
};

// Of the poses of a frame that have loops to others.
struct FrameExtent {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  double way = 0.0;  // m, from each to the next
};
FrameExtent extent_of(const std::vector<SE3>& poses);

// Whether drift around a cycle through two frames can make such a difference of two relative poses between their keyframes.
bool explained_by_drift(const SE3& T, const SE3& U, const FrameExtent& a, const FrameExtent& b);

struct Frames {
  std::vector<std::optional<SE3>> T_W_O;   // per frame; W is the anchor's; nothing for who is not connected
  std::vector<std::pair<int, int>> edges;  // of the tree, as (parent, child), in the order in which it grew
};

// Grows the tree from the anchor. Of equal places it takes that of the lower ids; alignments that are not ok are left out.
Frames spanning_tree(const std::vector<PairAlignment>& alignments, const std::vector<FrameExtent>& extents,
                     int anchor = 0);

}  // namespace covey::pgo
