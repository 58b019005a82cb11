// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/frame_alignment.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <numbers>
#include <random>

using namespace covey;
using namespace covey::pgo;

namespace {

constexpr double kPi = std::numbers::pi;

struct Draw {
  std::mt19937_64 random;

  double uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  }
  double normal(double sigma) { return std::normal_distribution<double>(0.0, sigma)(random); }
  SE3 anywhere() {
    const Eigen::Vector4d q(normal(1), normal(1), normal(1), normal(1));
    return {SO3::from_quaternion(Eigen::Quaterniond(q)),
            {uniform(-10, 10), uniform(-10, 10), uniform(-10, 10)}};
  }
  SE3 near(const SE3& T, double rotation_sigma, double translation_sigma) {
    const SO3 dR = SO3::exp({normal(rotation_sigma), normal(rotation_sigma), normal(rotation_sigma)});
    const Eigen::Vector3d dt(normal(translation_sigma), normal(translation_sigma), normal(translation_sigma));
    return {T.rotation * dR, T.translation + dt};
  }
};

}  // namespace

TEST_CASE("seven of ten candidates may be wrong") {
  for (int seed = 0; seed < 50; ++seed) {
    Draw draw{std::mt19937_64(seed)};
    const SE3 truth = draw.anywhere();
    std::vector<SE3> candidates;
    std::vector<bool> right;
    for (int k = 0; k < 100; ++k) {
      right.push_back(k % 10 < 3);
      candidates.push_back(right.back() ? draw.near(truth, 0.03, 0.15) : draw.anywhere());
    }
    const AlignmentResult result = align_pair(candidates);
    CAPTURE(seed);
    CHECK(result.ok);
    CHECK(result.total == 100);
    CHECK(result.inliers == 30);
    CHECK(result.kept == right);
    CHECK((result.T_A_B.rotation.inverse() * truth.rotation).log().norm() < 0.03);
    CHECK((result.T_A_B.translation - truth.translation).norm() < 0.15);
  }
}

TEST_CASE("wrong candidates that lie on one side do not drag the alignment") {
  Draw draw{std::mt19937_64(7)};
  const SE3 truth{SO3::exp({0.0, 0.0, 2.5}), {30.0, -20.0, 1.0}};
  std::vector<SE3> candidates;
  for (int k = 0; k < 20; ++k) candidates.push_back(draw.near(truth, 0.02, 0.1));
  for (int k = 0; k < 60; ++k) {
    SE3 wrong = draw.near(truth, 0.3, 0.0);
    wrong.translation.x() += 5.0 + 1.5 * k;
    candidates.push_back(wrong);
  }
  const AlignmentResult result = align_pair(candidates);
  CHECK(result.inliers == 20);
  CHECK((result.T_A_B.translation - truth.translation).norm() < 0.1);
}

TEST_CASE("rotations that straddle half a turn are averaged, not cancelled") {
  std::vector<SE3> candidates;
  for (int k = -5; k <= 5; ++k)
    candidates.push_back({SO3::exp({0.0, 0.0, kPi + 0.01 * k}), Eigen::Vector3d::Zero()});
  const AlignmentResult result = align_pair(candidates);
  CHECK(result.inliers == 11);
  CHECK((result.T_A_B.rotation.inverse() * SO3::exp({0.0, 0.0, kPi})).log().norm() < 1e-9);
}

TEST_CASE("frames that are one stay so exactly, unless more candidates agree with something far from it") {
  Draw draw{std::mt19937_64(3)};
  const SE3 elsewhere{SO3::exp({0.0, 0.0, 1.0}), {5.0, 0.0, 0.0}};
  const auto candidates = [&](int here, int there) {
    std::vector<SE3> list;
    for (int k = 0; k < here; ++k) list.push_back(draw.near(SE3{}, 0.05, 0.2));
    for (int k = 0; k < there; ++k) list.push_back(draw.near(elsewhere, 0.05, 0.2));
    return list;
  };
  for (const auto& [here, there] : {std::pair(4, 0), std::pair(3, 3), std::pair(1, 1)}) {
    const AlignmentResult same = confirm_same_frame(candidates(here, there), {.min_inliers = 1});
    CHECK(same.T_A_B.matrix().isIdentity(0.0));
    CHECK(same.inliers == here);
  }
  const AlignmentResult moved = confirm_same_frame(candidates(2, 4), {.min_inliers = 1});
  CHECK((moved.T_A_B.translation - elsewhere.translation).norm() < 0.5);
  CHECK(moved.inliers == 4);
}

TEST_CASE("one candidate is no agreement, none is no alignment") {
  CHECK(!align_pair({}).ok);
  const AlignmentResult single = align_pair({SE3{SO3::exp({0.1, 0.2, 0.3}), {1, 2, 3}}});
  CHECK(single.inliers == 1);
  CHECK(!single.ok);
  AlignmentOptions options;
  options.min_inliers = 1;
  CHECK(align_pair({SE3{}}, options).ok);
}

TEST_CASE("where loops disagree, each place that some agree on is possible") {
  Draw draw{std::mt19937_64(5)};
  const SE3 places[] = {draw.anywhere(), draw.anywhere(), draw.anywhere()};
  std::vector<SE3> candidates;
  std::vector<int> of;
  for (const int place : {1, 0, 2, 1, 0, 0, 1, 0}) {
    candidates.push_back(draw.near(places[place], 0.02, 0.1));
    of.push_back(place);
  }
  const auto possible = possible_alignments(candidates, {.min_inliers = 1});
  REQUIRE(possible.size() == 3);
  for (int place = 0; place < 3; ++place) {
    const AlignmentResult& alignment = possible[place];
    CHECK(alignment.inliers == std::count(of.begin(), of.end(), place));
    CHECK(alignment.total == 8);
    for (std::size_t k = 0; k < of.size(); ++k) CHECK(alignment.kept[k] == (of[k] == place));
    CHECK((alignment.T_A_B.translation - places[place].translation).norm() < 0.5);
  }
  for (int k = 0; k < 30; ++k) candidates.push_back(draw.near(places[0], 0.02, 0.1));
  CHECK(possible_alignments(candidates, {.min_inliers = 1}).size() == 1);  // beyond doubt
  CHECK(possible_alignments({}).empty());
}
