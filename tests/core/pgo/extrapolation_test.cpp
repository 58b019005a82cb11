// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/extrapolation.h"

#include <catch2/catch.hpp>

#include "core/pgo/central.h"
#include "core/pgo/experiment.h"
#include "core/pgo/start.h"
#include "tests/core/pgo/worlds.h"

namespace covey::pgo {
namespace {

struct Fixture {
  PoseGraph graph = cut_into_robots(make_walk({.poses = 100, .grid = 4, .seed = 3}).graph, 3);
  std::vector<RobotBlock> blocks = split_into_blocks(graph, 5, {});
  Poses optimum = solve_least_squares(graph, chordal_start(graph)).poses;
  std::mt19937_64 random{3};

  std::vector<Lifted> lifted(const Poses& poses) const {
    std::vector<Lifted> X;
    for (const RobotBlock& block : blocks) {
      X.emplace_back(5, 4 * block.solver.poses());
      for (int k = 0; k < block.solver.poses(); ++k)
        X.back().middleCols<4>(4 * k) = lift(poses[block.first + k], 5);
    }
    return X;
  }
  std::vector<Lifted> public_parts(const std::vector<Lifted>& X) const {
    std::vector<Lifted> parts;
    for (std::size_t b = 0; b < blocks.size(); ++b) parts.push_back(public_part(blocks[b], X[b]));
    return parts;
  }
  double cost(const std::vector<Lifted>& X) const {
    const std::vector<Lifted> known = public_parts(X);
    double sum = 0.0;
    for (std::size_t b = 0; b < blocks.size(); ++b) {
      const Lifted targets = targets_of(blocks[b], known);
      sum +=
          blocks[b].solver.cost(targets, X[b]) - 0.5 * blocks[b].solver.shared_residuals(targets, X[b]).sum();
    }
    return sum;
  }
  Poses disturbed(double sigma) {
    std::normal_distribution<double> normal(0.0, sigma);
    Poses poses = optimum;
    for (SE3& T : poses) T = T * SE3::exp(Vector6d::NullaryExpr([&] { return normal(random); }));
    return poses;
  }
};

TEST_CASE("directions that lead to the optimum are followed to it, by each robot as far as it must") {
  Fixture fixture;
  const std::vector<Lifted> best = fixture.lifted(fixture.optimum);
  const std::vector<Lifted> X = fixture.lifted(fixture.disturbed(1e-3));
  const std::vector<Lifted> elsewhere = fixture.lifted(fixture.disturbed(1e-3));
  std::vector<std::vector<Lifted>> directions(X.size());
  const double scales[] = {0.5, -3.0, 20.0};
  for (std::size_t b = 0; b < X.size(); ++b)
    directions[b] = {scales[b] * (best[b] - X[b]), elsewhere[b] - X[b], 2.0 * (elsewhere[b] - X[b])};
  const Extrapolation ahead = extrapolate(fixture.blocks, X, fixture.public_parts(X), directions);
  REQUIRE(fixture.cost(ahead.X) - fixture.cost(best) < 1e-3 * (fixture.cost(X) - fixture.cost(best)));
  for (const std::int64_t numbers : ahead.numbers_sent) REQUIRE((numbers >= 9 && numbers <= 9 + 2 * 9));
}

TEST_CASE("along directions that lead nowhere nothing is lost") {
  Fixture fixture;
  const std::vector<Lifted> X = fixture.lifted(fixture.disturbed(1e-3));
  std::vector<std::vector<Lifted>> directions(X.size());
  const std::vector<Lifted> elsewhere = fixture.lifted(fixture.disturbed(1e-3));
  for (std::size_t b = 0; b < X.size(); ++b)
    directions[b] = {elsewhere[b] - X[b], Lifted::Zero(X[b].rows(), X[b].cols())};
  const Extrapolation ahead = extrapolate(fixture.blocks, X, fixture.public_parts(X), directions);
  REQUIRE(fixture.cost(ahead.X) <= fixture.cost(X));
}

}  // namespace
}  // namespace covey::pgo
