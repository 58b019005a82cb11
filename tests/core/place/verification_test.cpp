// SPDX-License-Identifier: BSD-3-Clause
#include "core/place/verification.h"

#include <Eigen/LU>
#include <algorithm>
#include <catch2/catch.hpp>
#include <string>

#include "core/place/minimal_poses.h"
#include "tests/core/graph/factor_testing.h"
#include "tests/core/place/places.h"

namespace covey::place {
namespace {

using testing::RandomGeometry;
using testing::SeeOptions;

SE3 small_motion(RandomGeometry& random) {
  Vector6d xi;
  xi << random.vector<3>(0.4), random.vector<3>(0.12);
  return SE3::exp(xi);
}

struct Pair {
  FrameFeatures a;
  FrameFeatures b;
  SE3 T_A_B;
};

Pair make_pair(RandomGeometry& random, const SeeOptions& options = {}) {
  const auto place = testing::make_place(300, random);
  const SE3 T_W_A = testing::body_behind_camera();
  const SE3 T_W_B = T_W_A * small_motion(random);
  return {see(place, T_W_A, testing::forward_camera(), random, options),
          see(place, T_W_B, testing::forward_camera(), random, options), T_W_A.inverse() * T_W_B};
}

Pairs swapped(const Pairs& pairs) {
  Pairs result;
  for (const auto& [i, j] : pairs) result.emplace_back(j, i);
  std::sort(result.begin(), result.end());
  return result;
}

TEST_CASE("the Jacobians of a view are its derivatives") {
  RandomGeometry random(4);
  for (int trial = 0; trial < 20; ++trial) {
    graph::Values values;
    values.set<SE3>({'t', 0}, small_motion(random));
    values.set<graph::Vector<3>>({'p', 0},
                                 Eigen::Vector3d(random.normal(), random.normal(), random.uniform(2.0, 9.0)));
    REQUIRE(graph::testing::jacobian_error(OwnView<2>{{0.1, 0.2}}, {{'p', 0}}, values) < 1e-6);
    REQUIRE(graph::testing::jacobian_error(OwnView<3>{{0.1, 0.2, 0.3}}, {{'p', 0}}, values) < 1e-6);
    REQUIRE(graph::testing::jacobian_error(OtherView<2>{{0.1, 0.2}}, {{'t', 0}, {'p', 0}}, values) < 1e-6);
    REQUIRE(graph::testing::jacobian_error(OtherView<3>{{0.1, 0.2, 0.3}}, {{'t', 0}, {'p', 0}}, values) <
            1e-6);
  }
}

// Mean squared error over covariance of made-up pairs, whose features say `told` times the noise that they have.
double mean_nees(double told, RandomGeometry& random) {
  constexpr int kTrials = 40;
  double squared = 0.0;
  for (int trial = 0; trial < kTrials; ++trial) {
    Pair pair = make_pair(random);
    for (FrameFeatures* features : {&pair.a, &pair.b}) {
      features->noise.direction *= told;
      features->noise.inverse_depth *= told;
    }
    const Verification result = verify(pair.a, pair.b, {.correlation = 1.0, .calibration = 0.0});
    REQUIRE(result.refused == nullptr);
    REQUIRE(result.inliers > 100);
    REQUIRE(result.matches >= result.five_point);
    REQUIRE(result.five_point >= result.three_point);
    const Vector6d error = (result.T_A_B.inverse() * pair.T_A_B).log();
    REQUIRE(error.head<3>().norm() < 0.15);
    REQUIRE(error.tail<3>().norm() < 0.015);
    squared += error.dot(result.covariance.inverse() * error);
  }
  return squared / kTrials;
}

// Chi-square of 6 degrees of freedom each: mean 6, of 40 within 20 %; outliers that fit by chance and the kernel widen it a bit.
TEST_CASE("a place that two cameras saw gives their pose, as exactly as its covariance says") {
  RandomGeometry random(8);
  const double nees = mean_nees(1.0, random);
  REQUIRE(nees > 4.0);
  REQUIRE(nees < 9.0);
}

TEST_CASE("the covariance is that of the errors, not of what the cameras say of themselves") {
  RandomGeometry random(8);
  const double nees = mean_nees(2.0, random);
  REQUIRE(nees > 4.0);
  REQUIRE(nees < 9.0);
}

TEST_CASE("the other way round is the inverse, and the same twice") {
  RandomGeometry random(9);
  const Pair pair = make_pair(random);
  const Verification there = verify(pair.a, pair.b);
  const Verification again = verify(pair.a, pair.b);
  const Verification back = verify(pair.b, pair.a);
  REQUIRE(there.refused == nullptr);
  REQUIRE(back.refused == nullptr);
  REQUIRE(there.T_A_B.log() == again.T_A_B.log());
  REQUIRE(there.covariance == again.covariance);
  REQUIRE((there.T_A_B * back.T_A_B).log().norm() < 0.03);
}

TEST_CASE("what calibration may be off grows with distance and angle") {
  RandomGeometry random(10);
  const Pair pair = make_pair(random);
  const Verification exact = verify(pair.a, pair.b, {.calibration = 0.0});
  const Verification vague = verify(pair.a, pair.b, {.calibration = 0.02});
  REQUIRE(exact.refused == nullptr);
  REQUIRE(vague.refused == nullptr);
  const SE3 T_C_D = pair.a.T_B_C.inverse() * exact.T_A_B * pair.b.T_B_C;
  const double angle = 0.02 * T_C_D.rotation.log().norm();
  const Matrix6d added = vague.covariance - exact.covariance;
  REQUIRE(added.diagonal().tail<3>().isApproxToConstant(angle * angle, 1e-9));
  REQUIRE(added.topLeftCorner<3, 3>().trace() >= 3.0 * 0.02 * 0.02 * T_C_D.translation.squaredNorm());
}

TEST_CASE("another place is refused") {
  RandomGeometry random(11);
  for (int trial = 0; trial < 10; ++trial) {
    const Pair pair = make_pair(random);
    const Pair other = make_pair(random);
    REQUIRE(verify(pair.a, other.b).refused == std::string("matches"));
  }
}

// The same things at other places: descriptors match, geometry does not.
TEST_CASE("descriptors alone do not make a closure") {
  RandomGeometry random(12);
  auto place = testing::make_place(300, random);
  const auto a = see(place, testing::body_behind_camera(), testing::forward_camera(), random);
  for (auto& landmark : place) {
    landmark.p_W = {random.uniform(-6.0, 6.0), random.uniform(-3.0, 3.0), random.uniform(4.0, 15.0)};
  }
  const auto b = see(place, testing::body_behind_camera(), testing::forward_camera(), random);
  const Verification result = verify(a, b);
  REQUIRE(result.matches > 100);
  REQUIRE(result.refused != nullptr);
}

TEST_CASE("outliers up to half of the matches are borne") {
  RandomGeometry random(13);
  for (const double share : {0.3, 0.45, 0.55}) {
    const auto place = testing::make_place(300, random);
    auto moved = place;
    for (auto& landmark : moved) {
      if (random.uniform(0.0, 1.0) < share)
        landmark.p_W = {random.uniform(-5.0, 5.0), random.uniform(-2.0, 2.0), 7.0};
    }
    const SE3 T_W_A = testing::body_behind_camera();
    const SE3 T_W_B = T_W_A * small_motion(random);
    VerificationOptions options;
    options.five_point_iterations = 2000;
    const Verification result = verify(see(place, T_W_A, testing::forward_camera(), random),
                                       see(moved, T_W_B, testing::forward_camera(), random), options);
    INFO("share " << share << ", refused " << (result.refused ? result.refused : "no"));
    REQUIRE(result.refused == nullptr);
    REQUIRE((result.T_A_B.inverse() * T_W_A.inverse() * T_W_B).log().norm() < 0.1);
  }
}

// Of 300 points in a box; the camera looks along z.
const char* refused_in(const Eigen::Vector3d& least, const Eigen::Vector3d& most) {
  RandomGeometry random(14);
  auto place = testing::make_place(300, random);
  for (auto& landmark : place) {
    for (int axis = 0; axis < 3; ++axis) landmark.p_W[axis] = random.uniform(least[axis], most[axis]);
  }
  const SE3 T_W_A = testing::body_behind_camera();
  const SeeOptions options{.strangers = 0};
  const auto a = see(place, T_W_A, testing::forward_camera(), random, options);
  return verify(a, see(place, T_W_A, testing::forward_camera(), random, options)).refused;
}

TEST_CASE("points in a line, a corner or a plane are refused with that word, others are not") {
  REQUIRE(refused_in({-0.4, -3.0, 7.0}, {0.4, 3.0, 8.0}) == std::string("line"));
  REQUIRE(refused_in({1.0, 1.0, 7.0}, {2.5, 2.5, 8.0}) == std::string("corner"));
  REQUIRE(refused_in({-1.4, -1.0, 2.0}, {1.4, 1.0, 2.02}) == std::string("plane"));
  REQUIRE(refused_in({-4.0, -3.0, 5.0}, {4.0, 3.0, 10.0}) == nullptr);
}

TEST_CASE("poses that are not certain are refused") {
  RandomGeometry random(14);
  const Pair pair = make_pair(random);
  VerificationOptions strict;
  strict.most_sigma_m = 0.003;
  REQUIRE(verify(pair.a, pair.b, strict).refused == std::string("sigma"));
  strict.most_sigma_m = 1.0;
  strict.most_sigma_deg = 0.01;
  REQUIRE(verify(pair.a, pair.b, strict).refused == std::string("sigma"));
}

// A house of a type: 60 points that agree, and surroundings that do not.
TEST_CASE("two places that share a thing are not one") {
  RandomGeometry random(17);
  const auto house = testing::make_place(60, random);
  const auto street = [&] {
    auto place = testing::make_place(240, random);
    place.insert(place.end(), house.begin(), house.end());
    return place;
  };
  const SE3 T_W_A = testing::body_behind_camera();
  const auto a = see(street(), T_W_A, testing::forward_camera(), random);
  const auto b = see(street(), T_W_A * small_motion(random), testing::forward_camera(), random);
  const Verification result = verify(a, b);
  REQUIRE(result.inliers > 30);
  REQUIRE(result.refused == std::string("overlap"));
  VerificationOptions trusting;
  trusting.least_overlap = 0.0;
  REQUIRE(verify(a, b, trusting).refused == nullptr);
}

TEST_CASE("features without depth on one side are enough, without any they are not") {
  RandomGeometry random(15);
  Pair pair = make_pair(random);
  pair.b.depths_m.assign(pair.b.size(), 0.0F);
  const Verification result = verify(pair.a, pair.b);
  REQUIRE(result.refused == nullptr);
  REQUIRE((result.T_A_B.inverse() * pair.T_A_B).log().norm() < 0.06);
  REQUIRE(verify(pair.b, pair.a).refused == nullptr);
  pair.a.depths_m.assign(pair.a.size(), 0.0F);
  REQUIRE(verify(pair.a, pair.b).refused == std::string("three_point"));
}

// What another robot sends: the best of its features, of which the whole picture is not known.
TEST_CASE("a part of one side's features is enough, and does not make a wrong place right") {
  RandomGeometry random(18);
  for (int trial = 0; trial < 10; ++trial) {
    const Pair pair = make_pair(random);
    const FrameFeatures part = best_of(pair.b, 120);
    const Verification result = verify(pair.a, part);
    INFO("trial " << trial << ", refused " << (result.refused ? result.refused : "no"));
    REQUIRE(result.refused == nullptr);
    REQUIRE((result.T_A_B.inverse() * pair.T_A_B).log().norm() < 0.12);
    REQUIRE(result.overlap > 0.4);
    REQUIRE(verify(part, pair.a).refused == nullptr);
    REQUIRE(verify(make_pair(random).a, part).refused == std::string("matches"));
  }
}

TEST_CASE("descriptors match the same pairs both ways round, in order") {
  RandomGeometry random(19);
  const Pair pair = make_pair(random);
  const FrameFeatures part = best_of(pair.b, 100);
  const auto there = match_descriptors(pair.a.descriptors, part.descriptors);
  const auto back = match_descriptors(part.descriptors, pair.a.descriptors);
  REQUIRE(there.size() > 30);
  REQUIRE(std::is_sorted(there.begin(), there.end()));
  REQUIRE(swapped(back) == there);
}

TEST_CASE("empty and tiny features are refused, not a fault") {
  RandomGeometry random(16);
  const Pair pair = make_pair(random);
  FrameFeatures one;
  one.bearings_C = {pair.a.bearings_C[0]};
  one.depths_m = {pair.a.depths_m[0]};
  one.descriptors = {pair.a.descriptors[0]};
  for (const FrameFeatures& features : {FrameFeatures{}, one}) {
    REQUIRE(verify(features, pair.b).refused == std::string("matches"));
    REQUIRE(verify(pair.a, features).refused == std::string("matches"));
  }
}

}  // namespace
}  // namespace covey::place
