// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// A step of the whole team along directions in which its robots have moved before: what momentum guesses, computed.
//
// With tangent directions D_bi of block b at X (r x 4n each, zero for all other blocks), the second-order model of the team's
// cost F(retract(X, sum_bi c_bi D_bi)) is minimised over all coefficients. Of two robots' directions only public poses meet:
//
//   g_bi = <D_bi, E_b>,   H_bi,bj = <D_bi, Hess_b D_bj>,   H_bi,cj = -2 sum over edges b-c <my_side(D_bi), other_side(D_cj)>_Omega
//
// so each robot finds its rows from its own block and from its neighbours' public directions, which are differences of poses
// that it was sent anyway. The robots send each other these few numbers, and all solve the same small system.
//
// With the displacement of the last sweep and that of the sweeps before as directions this is block Gauss-Seidel accelerated by
// conjugate gradients with a short memory and a coefficient of its own for every robot. Sources: Knyazev, "Toward the Optimal
// Preconditioned Eigensolver", SISC 2001 (locally optimal directions); Bridson, Greif, "A Multipreconditioned Conjugate
// Gradient Algorithm", SIMAX 2006 (a coefficient for each block).

#include <cstdint>
#include <vector>

#include "core/pgo/robot_blocks.h"

namespace covey::pgo {

struct Extrapolation {
  std::vector<Lifted> X;                   // of each block
  std::vector<std::int64_t> numbers_sent;  // by each block's robot
};

// directions[b]: of block b, r x 4n; their tangent parts at X are taken.
Extrapolation extrapolate(const std::vector<RobotBlock>& blocks, const std::vector<Lifted>& X,
                          const std::vector<Lifted>& public_poses,
                          std::vector<std::vector<Lifted>> directions);

}  // namespace covey::pgo
