// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Where one robot's odometry frame lies in another's, from loop closures half of which may be wrong. frame_tree.h then puts all
// frames into one.
//
// A closure between pose i of robot a and pose j of robot b gives a candidate for the pose of b's frame in a's,
//
//   T_A_B = T_A_i T_i_j T_B_j^-1                                                                    (paper, eq. 4)
//
// Right closures agree, wrong ones scatter. The robust average minimises the truncated least squares
//
//   sum_k min(r_k^2, c^2),   r_k^2 = |Log(R^T R_k)|^2 / sigma_R^2 + |t - t_k|^2 / sigma_t^2         (paper, eq. 5)
//
// with c^2 the chi-square quantile of `probability`, by graduated non-convexity (Yang et al., RA-L 2020).
//
// Paper: Tian, Chang, Herrera Arias, Nieto-Granda, How, Carlone, "Kimera-Multi", T-RO 2022.

#include <vector>

#include "core/geometry/se3.h"

namespace covey::pgo {

struct AlignmentOptions {
  int dimension = 3;
  double rotation_sigma = 0.1;     // rad
  double translation_sigma = 0.5;  // m
  double probability = 0.99;       // of a right candidate staying below the threshold
  int min_inliers = 2;             // fewer agreeing candidates do not make an alignment
  bool keep_same_frame = false;    // what is thought to be one frame stays one, whatever candidates say
};

struct AlignmentResult {
  SE3 T_A_B;
  int inliers = 0;         // candidates that agree with T_A_B
  int total = 0;           // candidates
  double rms = 0.0;        // of the inliers' r_k, in sigmas
  bool ok = false;         // inliers >= min_inliers
  std::vector<bool> kept;  // per candidate
};

AlignmentResult align_pair(const std::vector<SE3>& candidates, const AlignmentOptions& options = {});
// Where the two frames are thought to be one already: T_A_B is exactly the identity, unless more candidates agree with another
// alignment, and that is not near it.
AlignmentResult confirm_same_frame(const std::vector<SE3>& candidates, const AlignmentOptions& options = {});

// What the candidates may mean: align_pair's alignment, then that of the candidates which do not agree with it, and so on, as
// long as more agree than chance brings to any place (alignment_evidence.h); only the first where it is beyond doubt.
std::vector<AlignmentResult> possible_alignments(const std::vector<SE3>& candidates,
                                                 const AlignmentOptions& options = {});

}  // namespace covey::pgo
