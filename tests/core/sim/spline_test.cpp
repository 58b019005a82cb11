// SPDX-License-Identifier: BSD-3-Clause
#include "core/sim/spline.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <random>

namespace covey::sim {
namespace {

using Spline = UniformSpline<2>;

Spline random_spline() {
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  std::vector<Spline::Point> control;
  for (int k = 0; k < 20; ++k) control.emplace_back(normal(random), normal(random));
  return {1'000'000, 100'000, control};
}

TEST_CASE("the basis sums to one, and its derivatives to zero") {
  for (const double u : {0.0, 0.1, 0.5, 0.9, 1.0}) CHECK(spline_basis<5>(u).sum() == Approx(1.0));
  // The uniform quintic B-spline at a knot: 1, 26, 66, 26, 1 over 120.
  Eigen::Matrix<double, 6, 1> at_knot;
  at_knot << 1, 26, 66, 26, 1, 0;
  CHECK((spline_basis<5>(0.0) - at_knot / 120.0).norm() < 1e-12);
}

TEST_CASE("a straight line stays one") {
  std::vector<Spline::Point> control;
  for (int k = 0; k < 10; ++k) control.emplace_back(0.1 * (k - 2), -0.2 * (k - 2));
  const Spline spline(0, 100'000, control);
  CHECK(spline.end() == 500'000);
  for (const Utime t : {0, 123'456, 400'000, 500'000}) {
    const Spline::Sample sample = spline.at(t);
    CHECK((sample.value - Spline::Point(to_seconds(t), -2.0 * to_seconds(t))).norm() < 1e-12);
    CHECK((sample.rate - Spline::Point(1.0, -2.0)).norm() < 1e-12);
    CHECK(sample.acceleration.norm() < 1e-10);
  }
}

TEST_CASE("derivatives are those of the values, also across knots") {
  const Spline spline = random_spline();
  const Utime h = 500;
  for (Utime t = spline.begin() + h; t + h <= spline.end(); t += 12'345) {
    const auto before = spline.at(t - h);
    const auto after = spline.at(t + h);
    const double span = to_seconds(2 * h);
    CHECK(((after.value - before.value) / span - spline.at(t).rate).norm() < 1e-3);
    CHECK(((after.rate - before.rate) / span - spline.at(t).acceleration).norm() < 3e-2);
  }
  for (Utime knot = 1'100'000; knot < spline.end(); knot += 100'000) {
    CHECK((spline.at(knot).acceleration - spline.at(knot - 1).acceleration).norm() < 0.05);
  }
}

}  // namespace
}  // namespace covey::sim
