// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// How far a solution of a pose graph can be from the best there is, whatever start it came from.
//
// With X = [R_1 t_1 ... R_n t_n] (d x (d + 1) n), the cost of CONVENTIONS.md is F = tr(X Q X^T). Its relaxation to a
// semidefinite program has the dual: maximise tr(Lambda) over symmetric d x d blocks Lambda_i on the rotations' columns with
// S = Q - Lambda positive semidefinite. A candidate proposes Lambda_i = sym(R_i^T (X Q)_i), so that tr(Lambda) = F where the
// translations are the best for the rotations; eta >= 0 is the smallest shift for which
//
//   S + eta blockdiag(I_d, 0, I_d, 0, ...)   is positive semidefinite,   hence   F - eta n d <= cost of any poses,
//
// and the certified relative gap is eta n d / F. At an optimum with a tight relaxation eta is zero. A candidate whose gradient is
// not zero pays for it in the second order; so that it is not the first, its translations are replaced by the best ones before
// Lambda is taken (`cost` is still that of the candidate, the gap is to it).
//
// What is proven. eta is found between `resolution` and the largest eigenvalue of any Lambda_i, which always suffices, by trials: a
// sparse Cholesky factorisation that goes through proves that an eta is enough, one that breaks down that it is not, and Lanczos'
// method with one that went through gives vectors whose curvature proves from below what is needed. So the value is at most
// 1 + accuracy above the smallest eta, and the bound holds up to the rounding of one factorisation (about 1e-16 of the diagonal times
// the fill of a row). The gauge needs no slack: moving all poses of a connected part by one translation is an exact null vector, so one
// translation of the part is held, which leaves definiteness as it was. The d null vectors of S at an optimum are made eta by the shift
// itself, which is why no smaller gap than `resolution` is asked for.
//
// Distributed, for a graph of several robots. For each eta a robot factorises its interior and sends its Schur complement on the
// separator (separated_graph.h) to the first robot, who factorises the sum (team_matrix.h): S + eta ... is definite exactly where all of
// these are. Translations are found in the same way. Lambda_i needs the edges of pose i and the public poses at their other ends.
// Only public poses and complements on them leave a robot.
//
// Sources: Rosen, Carlone, Bandeira, Leonard, "SE-Sync", IJRR 2019, section 4 (S, Lambda, dual); Tian, Khosoussi, Rosen, How,
// "Distributed Certifiably Correct Pose-Graph Optimization", T-RO 2021, section V (verification by a team).

#include <cstdint>
#include <vector>

#include "core/pgo/pose_graph.h"

namespace covey::pgo {

struct CertificateOptions {
  double resolution = 1e-8;  // the smallest gap that is asked for
  double accuracy = 0.02;    // relative, of eta
};

struct Certificate {
  double cost = 0.0;  // of the candidate, weighted
  double eta = 0.0;
  double lower_bound = 0.0;  // no poses cost less
  // (cost - lower_bound) / cost; relative to 1e-6 per edge where the cost is less (a graph without noise).
  double gap = 0.0;
  int trials = 0;          // of eta
  std::int64_t bytes = 0;  // sent between robots, all together, a broadcast counted once
  int separator = 0;       // poses
};

// weights: one per edge, 0 to leave it out; empty for all 1. `graph` in robust_form for a robust solution (pose_graph.h). A graph
// of one robot is certified centrally (as_one_robot), a team's by the team.
Certificate certify(const PoseGraph& graph, const Poses& poses, const std::vector<double>& weights = {},
                    const CertificateOptions& options = {});

}  // namespace covey::pgo
