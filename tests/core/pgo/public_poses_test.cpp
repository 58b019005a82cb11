// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/public_poses.h"

#include <catch2/catch.hpp>

namespace covey::pgo {
namespace {

TEST_CASE("poses survive the way through a message") {
  SE3 T{SO3::exp({0.3, -1.2, 0.7}), {1.0, -2.0, 30.0}};
  std::vector<double> values;
  append_pose({}, values);
  append_pose(T, values);
  REQUIRE(poses_are_good(values));
  REQUIRE((pose_at(values, 1).inverse() * T).log().norm() < 1e-12);
  values[7] = 3.0;
  REQUIRE_FALSE(poses_are_good(values));
}

TEST_CASE("rounding errors of differences die out, and zero rows are not sent") {
  std::srand(1);
  Lifted wanted = Lifted::Zero(5, 40);
  wanted.topRows<3>() = Eigen::MatrixXd::Random(3, 40) * 10.0;
  Lifted held = Lifted::Zero(5, 40);
  double error = 10.0;
  for (int update = 0; update < 3; ++update) {
    dpgo_update_t message{};
    encode_differences(wanted - held, message);
    REQUIRE(message.rows == 3);
    REQUIRE(message.n_values == 120);
    REQUIRE(fits(message, held));
    add_differences(message, held);
    const double next = (wanted - held).cwiseAbs().maxCoeff();
    REQUIRE(next < 1e-4 * error);
    error = next;
  }
  REQUIRE(held.bottomRows<2>().cwiseAbs().maxCoeff() == 0.0);
}

TEST_CASE("a message of another size does not fit") {
  dpgo_update_t message{};
  encode_differences(Lifted::Ones(3, 8), message);
  REQUIRE(fits(message, Lifted::Zero(5, 8)));
  REQUIRE_FALSE(fits(message, Lifted::Zero(5, 12)));
  REQUIRE_FALSE(fits(message, Lifted::Zero(2, 8)));
  encode_differences(Lifted::Zero(3, 8), message);
  REQUIRE(message.rows == 0);
  REQUIRE(fits(message, Lifted::Zero(5, 12)));
}

}  // namespace
}  // namespace covey::pgo
