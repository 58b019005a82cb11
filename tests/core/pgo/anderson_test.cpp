// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/anderson.h"

#include <Eigen/Dense>
#include <catch2/catch.hpp>
#include <numeric>
#include <vector>

namespace covey::pgo {
namespace {

TEST_CASE(
    "a linear iteration of n dimensions is solved in about n steps, which alone it would take hundreds for") {
  constexpr int kSize = 6;
  std::srand(1);
  const Eigen::MatrixXd basis = Eigen::MatrixXd::Random(kSize, kSize).householderQr().householderQ();
  const Eigen::VectorXd factors = Eigen::VectorXd::LinSpaced(kSize, 0.1, 0.99);
  const Eigen::MatrixXd M = basis * factors.asDiagonal() * basis.transpose();
  const Eigen::VectorXd fixed_point = Eigen::VectorXd::Random(kSize);

  Anderson anderson(kSize);
  Eigen::VectorXd x = Eigen::VectorXd::Zero(kSize);
  std::vector<Eigen::VectorXd> results;
  std::vector<Eigen::VectorXd> steps;
  for (int k = 0; k < kSize + 2; ++k) {
    const Eigen::VectorXd next = fixed_point + M * (x - fixed_point);
    results.insert(results.begin(), next);
    steps.insert(steps.begin(), next - x);
    std::vector<double> products;
    for (int j = 0; j <= anderson.steps() && j <= kSize; ++j) products.push_back(steps[0].dot(steps[j]));
    anderson.add(products);
    const std::vector<double> a = anderson.coefficients();
    REQUIRE(std::accumulate(a.begin(), a.end(), 0.0) == Approx(1.0));
    x.setZero();
    for (std::size_t j = 0; j < a.size(); ++j) x += a[j] * results[j];
  }
  REQUIRE((x - fixed_point).norm() < 1e-4 * fixed_point.norm());
}

TEST_CASE(
    "without steps to look back at, or with steps that say nothing, the newest result is taken as it is") {
  Anderson none(0);
  none.add({4.0});
  none.add({1.0});
  REQUIRE(none.coefficients() == std::vector<double>{1.0});
  Anderson anderson(3);
  anderson.add({4.0});
  REQUIRE(anderson.coefficients() == std::vector<double>{1.0});
  anderson.add({4.0, 4.0});  // the same step twice
  REQUIRE(anderson.coefficients() == std::vector<double>{1.0});
  anderson.restart();
  REQUIRE(anderson.steps() == 0);
}

}  // namespace
}  // namespace covey::pgo
