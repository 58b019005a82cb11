// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/place/aliases.h"

#include <algorithm>
#include <utility>

#include "core/sim/mesh_world.h"
#include "tests/bench/place/retrieval.h"

namespace covey::bench {
namespace {

constexpr int kBeyondTeam = 100;  // robots

SE3 pose_of(const Eigen::Isometry3d& T) { return SE3::from_matrix(T.matrix()); }

}  // namespace

std::vector<Alias> plant_aliases(const std::vector<Seen>& seen, std::size_t most) {
  std::vector<Alias> all;
  int robot = kBeyondTeam;
  for (const sim::AlikeRooms& alike : sim::alike_rooms()) {
    for (const auto& [T_W_A, T_W_B] : {std::pair(alike.T_W_A, alike.T_W_B), {alike.T_W_B, alike.T_W_A}}) {
      for (std::size_t k = 0; k < seen.size(); ++k) {
        const View& view = seen[k].view;
        if (!sim::rooms_inside().contains(T_W_A.inverse() * view.T_W_B.translation)) continue;
        View there = view;
        there.name.robot = robot + view.name.robot;
        there.T_W_B = pose_of(T_W_B) * pose_of(T_W_A).inverse() * view.T_W_B;
        all.push_back({k, there});
      }
      robot += kBeyondTeam;
    }
  }
  const std::size_t step = std::max<std::size_t>(1, (all.size() + most - 1) / most);
  std::vector<Alias> some;
  for (std::size_t k = 0; k < all.size(); k += step) some.push_back(all[k]);
  return some;
}

nlohmann::json try_aliases(const std::vector<Seen>& seen, const std::vector<Alias>& aliases,
                           const std::function<Seen(const View&)>& look, double ask_similarity,
                           const place::VerificationOptions& options) {
  int similar = 0;
  int accepted = 0;
  nlohmann::json refused = nlohmann::json::object();
  for (const Alias& alias : aliases) {
    const Seen there = look(alias.there);
    const Seen& here = seen[alias.here];
    const double expected = expected_similarity(seen, alias.here);
    similar += place::similarity(here.bag, there.bag) >= ask_similarity * expected ? 1 : 0;
    const place::Verification verification = place::verify(here.features, there.features, options);
    if (verification.refused == nullptr) {
      ++accepted;
    } else {
      refused[verification.refused] = refused.value(verification.refused, 0) + 1;
    }
  }
  return {{"pairs", aliases.size()}, {"similar", similar}, {"accepted", accepted}, {"refused", refused}};
}

}  // namespace covey::bench
