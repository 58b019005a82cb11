// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// How much k of n loops that agree on where two frames lie in each other say for it.
//
// Wrong loops agree with each other too: a straight street looks the same for kilometres, and of thirty wrong loops along it
// three put the two robots at the same distance. So what counts is by how much likelier k of n are if the place is right than
// if they agree by chance,
//
//   e = - log (n + 1) - log P(k or more of n by chance),     P <= exp(k - lambda - k log (k / lambda)),   lambda = n q < k
//
// where any share of the loops may be right (1 / (n + 1)) and q is the chance of a wrong loop to agree (Chernoff's bound for
// independent ones).

namespace covey::pgo {

constexpr double kUsualChance = 0.01;  // q where nothing is known of the loops

// searched: the place was found by looking for the most agreement among these loops, which makes it up to n times as likely
// that so many agree by chance.
double log_evidence(double inliers, int loops, double chance, bool searched);

}  // namespace covey::pgo
