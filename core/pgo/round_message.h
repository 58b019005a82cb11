// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// What the members of a round send each other (dgnc_round.h says when).

#include <compare>
#include <covey/dpgo_advance_t.hpp>
#include <covey/dpgo_alignment_t.hpp>
#include <covey/dpgo_coarse_t.hpp>
#include <covey/dpgo_graph_t.hpp>
#include <covey/dpgo_join_t.hpp>
#include <covey/dpgo_keyframes_t.hpp>
#include <covey/dpgo_keys_t.hpp>
#include <covey/dpgo_poses_t.hpp>
#include <cstdint>
#include <variant>

namespace covey::pgo {

using RoundMessage = std::variant<dpgo_join_t, dpgo_keys_t, dpgo_keyframes_t, dpgo_alignment_t,
                                  dpgo_advance_t, dpgo_coarse_t, dpgo_graph_t, dpgo_poses_t>;

struct RoundName {
  std::int64_t number = 0;
  int anchor = 0;
  auto operator<=>(const RoundName&) const = default;
};
constexpr std::int64_t kLargestRound =
    1'000'000'000'000;  // one a second for 30,000 years; leaves room to count on

// number, from and round of any message of a round.
int number_of(const RoundMessage& message);
int sender_of(const RoundMessage& message);
RoundName round_of(const RoundMessage& message);

// What a member says enters sums and products with everybody's poses: false where anything is not finite, beyond any
// measure, or not of the length that the message itself names.
bool values_are_good(const RoundMessage& message);
constexpr double kLargestResidualSq = 1e18;  // that is good

}  // namespace covey::pgo
