// SPDX-License-Identifier: BSD-3-Clause
#include "core/graph/graph.h"

#include <catch2/catch.hpp>

#include "core/graph/pose_factors.h"
#include "tests/core/graph/factor_testing.h"

using namespace covey;
using namespace covey::graph;

namespace {

// The example of factor.h.
struct RangeFactor {
  using Variables = VariableList<SE3, Vector<3>>;
  static constexpr int kDim = 1;

  double range_m = 0.0;

  Vector<1> evaluate(const SE3& T_W_B, const Vector<3>& p_W, Eigen::Matrix<double, 1, 6>* J_pose,
                     Eigen::Matrix<double, 1, 3>* J_point) const {
    const Eigen::Vector3d v_W = p_W - T_W_B.translation;
    const double distance_m = v_W.norm();
    if (J_pose) {
      const Eigen::RowVector3d n_W = v_W.transpose() / distance_m;
      *J_pose << -n_W * T_W_B.rotation.matrix(), Eigen::RowVector3d::Zero();
      *J_point = n_W;
    }
    return Vector<1>(distance_m - range_m);
  }
};

// The same with a wrong sign, which the check must see.
struct WrongRangeFactor : RangeFactor {
  Vector<1> evaluate(const SE3& T_W_B, const Vector<3>& p_W, Eigen::Matrix<double, 1, 6>* J_pose,
                     Eigen::Matrix<double, 1, 3>* J_point) const {
    const Vector<1> r = RangeFactor::evaluate(T_W_B, p_W, J_pose, J_point);
    if (J_pose) *J_pose = -*J_pose;
    return r;
  }
};

constexpr Key kPose{'x', 0};
constexpr Key kPoint{'l', 0};

Values range_values() {
  Values values;
  values.set(kPose, SE3::exp((Vector6d() << 1.0, 2.0, 3.0, 0.1, 0.2, 0.3).finished()));
  values.set(kPoint, Vector<3>(4.0, 6.0, 3.5));
  return values;
}

}  // namespace

TEST_CASE("Factor: a small struct is enough, and a wrong Jacobian is found") {
  using graph::testing::jacobian_error;
  const Values values = range_values();
  REQUIRE(jacobian_error(RangeFactor{3.2}, {kPose, kPoint}, values, Noise<1>::sigma(0.1)) < 1e-6);
  REQUIRE(jacobian_error(WrongRangeFactor{{3.2}}, {kPose, kPoint}, values) > 0.1);
}

TEST_CASE("Graph: ids stay, are reused after removal, and find their variables") {
  Graph graph;
  const FactorId range = graph.add(RangeFactor{3.2}, {kPose, kPoint});
  const FactorId prior = graph.add(Prior<SE3>{}, {kPose});
  const FactorId point = graph.add(Prior<Vector<3>>{{1.0, 2.0, 3.0}}, {kPoint});
  REQUIRE(graph.keys() == std::vector<Key>{kPoint, kPose});
  REQUIRE(graph.ids_touching({kPose}) == std::vector<FactorId>{range, prior});
  REQUIRE(graph.ids_touching({kPose, kPoint}).size() == 3);
  graph.remove(prior);
  REQUIRE_FALSE(graph.has(prior));
  REQUIRE(graph.size() == 2);
  REQUIRE(graph.ids() == std::vector<FactorId>{range, point});
  REQUIRE(graph.add(Prior<SE3>{}, {kPose}) == prior);
  const Graph copy = graph;
  graph.remove(range);
  REQUIRE(copy.has(range));
}

TEST_CASE("Graph: the cost is the sum of squares, without one half, through noise and kernels") {
  Graph graph;
  Values values;
  values.set(kPoint, Vector<3>(3.0, 0.0, 0.0));
  graph.add(Prior<Vector<3>>{Vector<3>::Zero()}, {kPoint});
  REQUIRE(cost(graph, values) == Approx(9.0));
  graph.add(Prior<Vector<3>>{Vector<3>::Zero()}, {kPoint}, Noise<3>::sigma(0.5));
  REQUIRE(cost(graph, values) == Approx(9.0 + 36.0));
  graph.add(Prior<Vector<3>>{Vector<3>::Zero()}, {kPoint}, {}, Robust::huber(1.0));
  REQUIRE(cost(graph, values) == Approx(9.0 + 36.0 + 5.0));
}

TEST_CASE("Noise: covariance, information and sigmas say the same") {
  const Eigen::Vector3d sigmas(0.1, 1.0, 10.0);
  const Eigen::Matrix3d covariance = sigmas.cwiseAbs2().asDiagonal();
  const auto squared = [](const Noise<3>& noise) {
    return Eigen::Matrix3d(noise.sqrt_information().transpose() * noise.sqrt_information());
  };
  const Eigen::Matrix3d expected = sigmas.cwiseAbs2().cwiseInverse().asDiagonal();
  REQUIRE((squared(Noise<3>::sigmas(sigmas)) - expected).norm() < 1e-10);
  REQUIRE((squared(Noise<3>::covariance(covariance)) - expected).norm() < 1e-10);
  REQUIRE((squared(Noise<3>::information(expected)) - expected).norm() < 1e-10);
  const Eigen::Matrix3d semidefinite = Eigen::Vector3d(1.0, 0.0, 4.0).asDiagonal();
  REQUIRE((squared(Noise<3>::information(semidefinite)) - semidefinite).norm() < 1e-12);
  REQUIRE(Noise<3>::covariance(semidefinite).sqrt_information().allFinite());
}

TEST_CASE("Robust: derivatives agree with differences, and small residuals are untouched") {
  for (const Robust kernel : {Robust{}, Robust::huber(1.5), Robust::cauchy(1.5)}) {
    for (const double s : {0.01, 1.0, 2.0, 3.0, 100.0}) {
      constexpr double kStep = 1e-5;
      const double first = (kernel.cost(s + kStep) - kernel.cost(s - kStep)) / (2.0 * kStep);
      const double second = (kernel.derivative(s + kStep) - kernel.derivative(s - kStep)) / (2.0 * kStep);
      REQUIRE(kernel.derivative(s) == Approx(first).epsilon(1e-6));
      REQUIRE(kernel.second_derivative(s) == Approx(second).epsilon(1e-6).margin(1e-9));
      REQUIRE(kernel.cost(s) <= s);
    }
    REQUIRE(kernel.cost(1e-8) == Approx(1e-8));
  }
}
