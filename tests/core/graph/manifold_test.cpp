// SPDX-License-Identifier: BSD-3-Clause
#include "core/graph/manifold.h"

#include <catch2/catch.hpp>

#include "core/graph/values.h"
#include "tests/core/geometry/random.h"

using namespace covey;
using namespace covey::graph;
using covey::testing::kTrials;
using covey::testing::RandomGeometry;

namespace {

constexpr Key kX{'x', 0};

Eigen::VectorXd minus(const Values& y, const Values& x) {
  Eigen::VectorXd delta(x.type(kX).tangent);
  graph::minus(x.type(kX), y.data(kX), x.data(kX), delta.data());
  return delta;
}

template <typename T>
void check_identities(const T& value_x, const T& value_y, const Eigen::VectorXd& d) {
  Values x;
  Values y;
  x.set(kX, value_x);
  y.set(kX, value_y);
  Values x_plus_d = x;
  x_plus_d.perturb(kX, d);
  REQUIRE((minus(x_plus_d, x) - d).norm() < 1e-9);
  Values reached = x;
  reached.perturb(kX, minus(y, x));
  REQUIRE(minus(reached, y).norm() < 1e-9);
  Values still = x;
  still.perturb(kX, 0.0 * d);
  REQUIRE(minus(still, x).norm() < 1e-14);

  const Eigen::MatrixXd J = minus_jacobian(x.type(kX), x_plus_d.data(kX), x.data(kX));
  for (Eigen::Index c = 0; c < d.size(); ++c) {
    constexpr double kStep = 1e-6;
    Values ahead = x_plus_d;
    Values behind = x_plus_d;
    ahead.perturb(kX, kStep * Eigen::VectorXd::Unit(d.size(), c));
    behind.perturb(kX, -kStep * Eigen::VectorXd::Unit(d.size(), c));
    REQUIRE((J.col(c) - (minus(ahead, x) - minus(behind, x)) / (2.0 * kStep)).norm() < 1e-7);
  }
}

}  // namespace

TEST_CASE("Manifolds: plus and minus undo each other and minus_jacobian is the derivative") {
  RandomGeometry random;
  for (int k = 0; k < kTrials; ++k) {
    check_identities(random.rotation(), random.rotation(), random.vector<3>(0.4));
    check_identities(random.planar_pose(), random.planar_pose(), random.vector<3>(0.4));
    check_identities(random.pose(), random.pose(), random.vector<6>(0.4));
    check_identities<Vector<5>>(random.vector<5>(), random.vector<5>(), random.vector<5>());
  }
}

TEST_CASE("Values: what is set is read back, by key and in order") {
  RandomGeometry random;
  Values values;
  const SE3 T = random.pose();
  const SE2 S = random.planar_pose();
  values.set({'y', 1}, S);
  values.set({'x', 7}, T);
  values.set({'x', 2}, Vector<3>(1.0, 2.0, 3.0));
  const double* stays = values.data({'x', 7});
  REQUIRE(values.keys() == std::vector<Key>{{'x', 2}, {'x', 7}, {'y', 1}});
  REQUIRE((values.get<SE3>({'x', 7}).matrix() - T.matrix()).norm() < 1e-14);
  REQUIRE((values.get<SE2>({'y', 1}).matrix() - S.matrix()).norm() < 1e-14);
  values.set({'x', 2}, Vector<3>(4.0, 5.0, 6.0));
  REQUIRE(values.get<Vector<3>>({'x', 2}).z() == 6.0);
  values.erase({'x', 2});
  REQUIRE_FALSE(values.has({'x', 2}));
  REQUIRE(values.size() == 2);
  REQUIRE(values.data({'x', 7}) == stays);
}
