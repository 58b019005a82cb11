// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// One robot solves for all: the elected one, which is the lowest, gathers the whole pose graph, solves it as central.h does, and
// says where everybody is. What distributed solving is compared with.
//
//   every other robot    part_of(own graph)                       -> dpgo_graph_t       (elected_messages.h)
//   the elected          solve_parts(its own part and theirs)     -> dpgo_poses_t
//   everybody            share_of(poses, own graph)
//
// A segment is aligned and placed like a robot of its own (start_frames.h). Where loops do not connect all robots, each part of
// the team is solved for itself, in the frame of its lowest robot.
//
// The squared residuals are those of the snapshots' kappa and tau; for the plane (dimension 2) these are those of robust_form
// (pose_graph.h). With full covariances, in space, they are those of measured_noise.h, which also refines the poses; F is then
// where it was, not the keyframe, which gravity may have turned.

#include <functional>
#include <optional>
#include <vector>

#include "core/pgo/elected_messages.h"
#include "core/pgo/frame_alignment.h"

namespace covey::pgo {

struct ElectedOptions {
  PackingOptions packing{};
  double barc2 = 16.812;
  NoiseOptions noise{};  // of full covariances
  double mu_step = 1.4;  // of graduated non-convexity
  AlignmentOptions alignment{.min_inliers = 1};
  std::function<void()> each_step = {};  // core/graph/solve.h
};

struct Gathered {
  dpgo_poses_t poses;  // of all robots, the elected too
  int iterations = 0;  // of the solver
};
// parts: ascending by robot, the elected's own the first. A loop whose ends nobody has is left out.
Gathered solve_parts(const std::vector<dpgo_graph_t>& parts, const ElectedOptions& options);

// The same without the sender's own poses, which nobody else needs: what is sent.
dpgo_poses_t without_own(dpgo_poses_t poses);

// What a robot takes from it.
struct ElectedShare {
  struct Placed {
    int anchor =
        -1;  // robot whose first keyframe F of a segment the poses are relative to; -1: not connected, no poses
    int anchor_segment = 0;
    std::vector<SE3> T_F_K;
  };
  struct Decision {
    GraphLoop loop;
    bool kept = false;
    double r2 = 0.0;  // infinite where an end is not connected
  };
  std::vector<Placed> segments;
  std::vector<Decision> loops;  // private, then those with each peer
};
// None where the poses do not fit the graph.
std::optional<ElectedShare> share_of(const dpgo_poses_t& poses, const GraphSnapshot& graph,
                                     const SegmentNames& names, const ElectedOptions& options);

// The squared residual by which the elected decides, of a measured T_A_B with either noise.
double deciding_residual_sq(const SE3& T_A_B, const Precision& precision, const Matrix6d& covariance,
                            const SE3& T_W_A, const SE3& T_W_B, const ElectedOptions& options);

}  // namespace covey::pgo
