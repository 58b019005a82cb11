// SPDX-License-Identifier: BSD-3-Clause
// Graduated non-convexity over a team's second-order steps: what a round does with SchurBlock and SchurTeam, in a few lines.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "core/graph/gnc.h"
#include "core/pgo/central.h"
#include "core/pgo/cost.h"
#include "core/pgo/experiment.h"
#include "core/pgo/solve_schur.h"
#include "core/pgo/start.h"
#include "core/pgo/tls.h"

using namespace covey;
using namespace covey::pgo;

namespace {

constexpr double kBarc2 = 16.812;
constexpr double kMuStep = 2.0;
constexpr double kLargestMu = 30.0;  // beyond, weights are binary
constexpr double kOneStepMu = 1e-3;  // below, one step to a stage
constexpr double kTolerance = 1e-3;
constexpr double kLastTolerance = 1e-7;

struct Run {
  Poses poses;
  int rounds = 0;
};

class Team {
 public:
  Team(const PoseGraph& graph, const Poses& start) : graph_(graph), members_(schur_members(graph, start)) {}

  Run run() {
    double mu = tls_first_mu(largest_residual(), kBarc2);
    weigh(mu);
    bool last = false;
    for (run_.rounds = 1; run_.rounds < 100; ++run_.rounds) {
      if (!step()) continue;
      const bool settled = team_.promised() <= (last ? kLastTolerance : kTolerance) * team_.cost();
      if (!settled && (last || mu >= kOneStepMu)) continue;
      if (last && weigh(mu) == 0) break;
      if (last) continue;
      mu *= kMuStep;
      last = mu > kLargestMu;
      if (last) mu = std::numeric_limits<double>::infinity();
      weigh(mu);
    }
    run_.poses = gather_poses(graph_, members_);
    return run_;
  }

 private:
  bool step() {
    std::vector<dpgo_reduced_t> reduced;
    for (SchurMember& member : members_) reduced.push_back(member.block.reduce());
    const dpgo_move_t move = team_.solve(reduced);
    for (SchurMember& member : members_) REQUIRE(member.block.step(move));
    return move.taken;
  }

  template <typename Use>
  void for_each_candidate(Use&& use) {
    for (SchurMember& member : members_) {
      for (std::size_t id = 0; id < member.edges.size(); ++id) {
        if (member.block.holds(id) && !graph_.edges[member.edges[id]].known_inlier) use(member.block, id);
      }
    }
  }
  double largest_residual() {
    double largest = 0.0;
    for_each_candidate([&](SchurBlock& block, graph::FactorId id) {
      largest = std::max(largest, block.squared_residual(id));
    });
    return largest;
  }
  // Returns how many weights change.
  int weigh(double mu) {
    int changed = 0;
    for_each_candidate([&](SchurBlock& block, graph::FactorId id) {
      const double r2 = block.squared_residual(id);
      const double weight = std::isinf(mu) ? (r2 <= kBarc2 ? 1.0 : 0.0) : graph::gnc_weight(r2, kBarc2, mu);
      if (weight != block.weight(id)) ++changed;
      block.set_weight(id, weight);
    });
    return changed;
  }

  const PoseGraph& graph_;
  std::vector<SchurMember> members_;
  SchurTeam team_;
  Run run_;
};

}  // namespace

TEST_CASE(
    "graduated non-convexity over second-order steps keeps lone closures and ends where the central one "
    "does") {
  const StataWorld world = stata_like({.poses_per_robot = 600, .closures_per_robot = 50});
  const Poses start = robust_start(world.graph, {.min_inliers = 1}).poses;
  const Run run = Team(world.graph, start).run();
  CHECK(run.rounds <= 50);
  const RobustCost cost = robust_cost(world.graph, run.poses, kBarc2);
  CHECK(cost.cost <= (1.0 + 1e-3) * solve_robust(world.graph, start, {.barc2 = kBarc2}).cost);
  int between = 0;
  for (std::size_t e = 0; e < world.graph.edges.size(); ++e) {
    if (!world.graph.edges[e].between_robots()) continue;
    ++between;
    CHECK(cost.kept[e]);
  }
  CHECK(between == 3);
}
