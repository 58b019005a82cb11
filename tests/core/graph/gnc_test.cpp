// SPDX-License-Identifier: BSD-3-Clause
#include "core/graph/gnc.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "tests/core/graph/worlds.h"

using namespace covey;
using namespace covey::graph;
using graph::testing::make_ring;
using graph::testing::worst_translation_error;

namespace {

double truncated_cost(const Graph& graph, const Values& values, const GncOptions& options) {
  double sum = cost(graph, values);
  for (const FactorId id : options.candidates) {
    const double squared = squared_residual(graph.factor(id), values);
    sum += std::min(squared, options.barc_squared) - squared;
  }
  return sum;
}

}  // namespace

TEST_CASE("GNC: weights run from 1 to 0 without a jump and become binary") {
  constexpr double kBarcSquared = 4.0;
  for (const double mu : {1e-4, 1e-2, 1.0, 100.0}) {
    const double lower = mu / (mu + 1.0) * kBarcSquared;
    const double upper = (mu + 1.0) / mu * kBarcSquared;
    REQUIRE(gnc_weight(0.0, kBarcSquared, mu) == 1.0);
    REQUIRE(gnc_weight(lower * 1.000001, kBarcSquared, mu) == Approx(1.0).margin(1e-4));
    REQUIRE(gnc_weight(upper * 0.999999, kBarcSquared, mu) == Approx(0.0).margin(1e-4));
    REQUIRE(gnc_weight(upper, kBarcSquared, mu) == 0.0);
    const double width = upper - lower;
    REQUIRE(gnc_weight(lower + 0.3 * width, kBarcSquared, mu) >
            gnc_weight(lower + 0.6 * width, kBarcSquared, mu));
  }
}

TEST_CASE("GNC: true loops are kept and false ones dropped at any share of outliers") {
  for (const int false_loops : {0, 5, 20, 60}) {
    for (const std::uint64_t seed : {1, 2, 3}) {
      const auto world = make_ring(false_loops, seed);
      GncOptions options;
      options.candidates = world.loops;
      Values values = world.start;
      const GncResult result = solve_gnc(world.graph, values, options);
      REQUIRE(result.converged);
      REQUIRE(result.weights.size() == world.loops.size());
      int kept_true = 0;
      for (int k = 0; k < world.true_loops; ++k) kept_true += result.weights[k] == 1.0;
      REQUIRE(kept_true >= world.true_loops - 1);  // one in a hundred lies beyond the 99 % threshold
      REQUIRE(result.inliers == kept_true);
      REQUIRE(result.final_cost == Approx(truncated_cost(world.graph, values, options)));
      REQUIRE(result.initial_cost == Approx(truncated_cost(world.graph, world.start, options)));
      REQUIRE(result.final_cost <= result.initial_cost);
      REQUIRE(worst_translation_error(values, world.truth) < 1.0);
    }
  }
}

TEST_CASE("GNC: known inliers keep their weight even when they disagree") {
  Graph graph;
  Values values;
  values.set({'v', 0}, Vector<1>(0.0));
  graph.add(Prior<Vector<1>>{Vector<1>(0.0)}, {{'v', 0}});
  graph.add(Prior<Vector<1>>{Vector<1>(100.0)}, {{'v', 0}});
  const GncResult result = solve_gnc(graph, values, {});
  REQUIRE(result.converged);
  REQUIRE(values.get<Vector<1>>({'v', 0})(0) == Approx(50.0));
  REQUIRE(result.final_cost == Approx(5000.0));
}

TEST_CASE("GNC: averaging without any known inlier finds the majority") {
  covey::testing::RandomGeometry random(3);
  Graph graph;
  GncOptions options;
  const SE3 truth = random.pose();
  const auto noise = Noise<6>::sigmas((Vector6d() << 0.5, 0.5, 0.5, 0.1, 0.1, 0.1).finished());
  for (int k = 0; k < 30; ++k) {
    const SE3 measured = k < 12 ? truth * SE3::exp(0.05 * random.vector<6>()) : random.pose();
    options.candidates.push_back(graph.add(Prior<SE3>{measured}, {{'x', 0}}, noise));
  }
  Values values;
  values.set({'x', 0}, SE3{});
  options.solve_before_weighting = true;
  const GncResult result = solve_gnc(graph, values, options);
  REQUIRE(result.inliers >= 12);
  REQUIRE(result.inliers <= 14);
  REQUIRE((truth.inverse() * values.get<SE3>({'x', 0})).log().norm() < 0.2);
}

TEST_CASE("GNC: loops a hundred thousand sigmas off at the start are not rejected at once") {
  Graph graph;
  Values values;
  GncOptions options;
  for (int k = 0; k <= 20; ++k) values.set({'x', static_cast<std::uint64_t>(k)}, SE2{0.0, {1.1 * k, 0.0}});
  const auto add = [&](int i, int j, double length_m, double sigma) {
    const Key keys[] = {{'x', static_cast<std::uint64_t>(i)}, {'x', static_cast<std::uint64_t>(j)}};
    return graph.add(Between<SE2>{{0.0, {length_m, 0.0}}}, keys, Noise<3>::sigma(sigma));
  };
  for (int k = 1; k <= 20; ++k) add(k - 1, k, 1.1, 0.1);  // too long by a tenth: the loops know better
  for (int k = 4; k <= 20; k += 4) options.candidates.push_back(add(0, k, k, 1e-5));
  options.candidates.push_back(add(0, 10, 3.0, 1e-5));
  graph.set_constant({'x', 0});
  const GncResult result = solve_gnc(graph, values, options);
  REQUIRE(result.inliers == 5);
  REQUIRE(result.weights.back() == 0.0);
  REQUIRE(values.get<SE2>({'x', 20}).translation.x() == Approx(20.0).epsilon(1e-6));
}

TEST_CASE("GNC: mu grows by its step until decisions are made, then by even steps, then weights are binary") {
  REQUIRE(next_mu(1e-4, 1.4, 6) == Approx(1.4e-4));
  REQUIRE(next_mu(0.9 * kMuOfDecisions, 1.4, 6) == kMuOfDecisions);
  double mu = kMuOfDecisions;
  for (int k = 0; k < 6; ++k) mu = next_mu(mu, 1.4, 6);
  REQUIRE(mu == Approx(3.0));
  REQUIRE(std::isinf(next_mu(mu, 1.4, 6)));
}

TEST_CASE("GNC: where decisions are made each round goes on until weights and values agree") {
  const auto world = make_ring(20, 1);
  GncOptions options;
  options.candidates = world.loops;
  options.mu_initial = kMuOfDecisions;
  options.max_rounds = 1;
  options.max_weighings = 1;
  Values once = world.start;
  const GncResult first = solve_gnc(world.graph, once, options);
  options.max_weighings = 100;
  Values until_settled = world.start;
  const GncResult settled = solve_gnc(world.graph, until_settled, options);
  REQUIRE(settled.rounds.size() == 1);
  REQUIRE(settled.iterations > first.iterations);
}

TEST_CASE("GNC: when everything is rejected it says so") {
  const auto world = make_ring(0);
  GncOptions options;
  options.candidates = world.loops;
  options.barc_squared = 1e-9;
  Values values = world.start;
  const GncResult result = solve_gnc(world.graph, values, options);
  REQUIRE(result.inliers == 0);
}
