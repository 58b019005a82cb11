// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The team's pose graph in a few poses per segment, for a start that is bent right. Rigid frames (start_frames.h) leave all drift
// where two segments meet for the second time; block updates spread it slowly, and while they do, right loops are taken for wrong
// ones. So before them the members gather a coarse graph at one of them and solve it (elected_exchange.h): a node is a public
// keyframe, the first one of a piece of the segment, or the last of all;
//
//   between nodes that follow each other   the start's relative pose, with the noise of the odometry between them
//   between other nodes of one robot       the same, where its loops between the two pieces fit the start
//   between nodes of two robots            what the loops between the two pieces agree on (frame_alignment.h), of those that
//                                          odometry's drift can explain
//
// Both ends of a shared loop hold the same public poses, so both make the same edge of it; the lower robot sends it.

#include <covey/dpgo_poses_t.hpp>

#include "core/pgo/agreed_problem.h"
#include "core/pgo/frame_alignment.h"

namespace covey::pgo {

struct CoarseOptions {
  int pieces = 16;          // of a segment, about, at most
  int shortest_piece = 20;  // keyframes
  int least_loops =
      10;  // with others, per robot: fewer close hardly any cycle, and bending costs own loops their fit
  double barc2 = 16.812;
  AlignmentOptions alignment{.min_inliers = 1};
};

// Whether all start from odometry, in the plane, with loops enough between them. In space a piece between two nodes can turn too
// far: sphere2500 is lost by it.
bool wants_bending(const AgreedProblem& problem, const CoarseOptions& options);

// Of a segment: the ids of its nodes, ascending. None where it has no public keyframe, against the protocol.
std::vector<int> coarse_nodes(const OpenedMember& member, int segment, const CoarseOptions& options = {});

// With the same members and segments; keyframe ids count the nodes.
AgreedProblem coarse_problem(const AgreedProblem& problem, const CoarseOptions& options);

// Bends the starts to where the nodes are, the own ones and the public keyframes of all.
void bend_starts(const dpgo_poses_t& nodes, const CoarseOptions& options, AgreedProblem& problem);

}  // namespace covey::pgo
