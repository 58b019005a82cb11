// SPDX-License-Identifier: BSD-3-Clause
#include "core/geometry/alignment.h"

#include <catch2/catch.hpp>

#include "tests/core/geometry/random.h"

using namespace covey;
using Points = std::vector<Eigen::Vector3d>;

namespace {

Points random_points(testing::RandomGeometry& random, int count) {
  Points points;
  for (int k = 0; k < count; ++k) points.push_back(random.vector<3>(5.0));
  return points;
}

double rms_with(const SE3& T, const Points& from, const Points& to) {
  double squared = 0.0;
  for (std::size_t k = 0; k < from.size(); ++k) squared += (to[k] - T * from[k]).squaredNorm();
  return std::sqrt(squared / static_cast<double>(from.size()));
}

}  // namespace

TEST_CASE("Alignment: exact motions are found, with scale when asked for") {
  testing::RandomGeometry random;
  for (int k = 0; k < testing::kTrials; ++k) {
    const SE3 truth = random.pose();
    const double scale = random.uniform(0.2, 4.0);
    const Points from = random_points(random, 3 + random.index(20));
    Points to;
    Points scaled;
    for (const auto& p : from) {
      to.push_back(truth * p);
      scaled.push_back(truth * Eigen::Vector3d(scale * p));
    }
    const Alignment rigid = align_points(from, to);
    REQUIRE((rigid.T_to_from.matrix() - truth.matrix()).norm() < 1e-9);
    REQUIRE(rigid.rms < 1e-11);
    REQUIRE(rigid.scale == 1.0);
    const Alignment similar = align_points(from, scaled, true);
    REQUIRE(similar.scale == Approx(scale).epsilon(1e-11));
    REQUIRE(similar.rms < 1e-11);
  }
}

TEST_CASE("Alignment: with noise no nearby motion is better") {
  testing::RandomGeometry random;
  for (int k = 0; k < testing::kTrials; ++k) {
    const Points from = random_points(random, 3 + random.index(20));
    const SE3 truth = random.pose();
    Points to;
    for (const auto& p : from) to.push_back(truth * p + random.vector<3>(0.5));
    const Alignment alignment = align_points(from, to);
    REQUIRE(alignment.rms == Approx(rms_with(alignment.T_to_from, from, to)));
    const SE3 other = alignment.T_to_from * SE3::exp(random.vector<6>(0.01));
    REQUIRE(alignment.rms <= rms_with(other, from, to));
  }
}

TEST_CASE("Alignment: a mirrored set is answered by a rotation, not a reflection") {
  testing::RandomGeometry random;
  const Points from = random_points(random, 10);
  Points to;
  for (const auto& p : from) to.emplace_back(p.x(), p.y(), -p.z());
  REQUIRE(align_points(from, to).T_to_from.rotation.matrix().determinant() == Approx(1.0));
}

TEST_CASE("Alignment: planar sets move in the plane, also on a line") {
  testing::RandomGeometry random;
  for (int k = 0; k < testing::kTrials; ++k) {
    const SE2 truth = random.planar_pose();
    Points from;
    Points to;
    for (int n = 0; n < 5; ++n) {
      const Eigen::Vector2d p = k % 2 == 0 ? random.vector<2>() : Eigen::Vector2d(n, 2.0 * n);
      from.emplace_back(p.x(), p.y(), 0.0);
      to.emplace_back((truth * p).x(), (truth * p).y(), 0.0);
    }
    const Alignment alignment = align_points(from, to);
    REQUIRE(alignment.rms < 1e-12);
    REQUIRE((alignment.T_to_from.rotation.matrix().topLeftCorner<2, 2>() - rotation_2d(truth.angle)).norm() <
            1e-12);
  }
}

TEST_CASE("Alignment: one point is a translation of some kind") {
  REQUIRE(align_points({{1.0, 2.0, 3.0}}, {{4.0, 5.0, 6.0}}).rms < 1e-12);
}
