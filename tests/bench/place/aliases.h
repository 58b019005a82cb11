// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Planted aliases: what one sees from a place in a room of the world `rooms`, and from the same place in a room far away that is furnished
// alike. Whatever joins the two is wrong.

#include <functional>
#include <nlohmann/json.hpp>
#include <vector>

#include "core/place/verification.h"
#include "tests/bench/place/seen.h"

namespace covey::bench {

struct Alias {
  std::size_t here = 0;
  View there;  // of a robot beyond the team, whose keyframes nobody else has
};

// At most so many, evenly of all that there are.
std::vector<Alias> plant_aliases(const std::vector<Seen>& seen, std::size_t most);

// {"pairs", "similar": how many are so similar that features would be asked for, "accepted", "refused": {word: how many}}.
nlohmann::json try_aliases(const std::vector<Seen>& seen, const std::vector<Alias>& aliases,
                           const std::function<Seen(const View&)>& look, double ask_similarity,
                           const place::VerificationOptions& options);

}  // namespace covey::bench
