// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Seeded random geometry for tests. Every tenth rotation vector is an edge case: zero, tiny, or within 1e-9
// of pi.

#include <Eigen/Core>
#include <numbers>
#include <random>

#include "core/geometry/se2.h"
#include "core/geometry/se3.h"

namespace covey::testing {

class RandomGeometry {
 public:
  explicit RandomGeometry(std::uint64_t seed = 1) : random_(seed) {}

  double uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  double normal() { return normal_(random_); }
  int index(int count) { return std::uniform_int_distribution<int>(0, count - 1)(random_); }
  template <int N>
  Eigen::Matrix<double, N, 1> vector(double sigma = 1.0) {
    return Eigen::Matrix<double, N, 1>::NullaryExpr([&] { return sigma * normal(); });
  }

  // An angle in [0, pi).
  double angle() {
    ++count_;
    if (count_ % 10 != 0) return uniform(0.0, 3.14);
    constexpr double kEdges[] = {
        0.0, 1e-12, 1e-9, 1e-5, 1e-3, 0.4999, 0.5001, std::numbers::pi - 1e-6, std::numbers::pi - 1e-9};
    return kEdges[(count_ / 10) % std::size(kEdges)];
  }
  Eigen::Vector3d rotation_vector() { return angle() * vector<3>().normalized(); }
  Vector6d twist() {
    Vector6d xi;
    xi << vector<3>(3.0), rotation_vector();
    return xi;
  }
  Eigen::Vector3d planar_twist() {
    Eigen::Vector3d xi;
    xi << vector<2>(3.0), angle() * (normal() < 0.0 ? -1.0 : 1.0);
    return xi;
  }
  SO3 rotation() { return SO3::exp(rotation_vector()); }
  SE3 pose() { return {rotation(), vector<3>(3.0)}; }
  SE2 planar_pose() { return SE2::exp(planar_twist()); }
  std::mt19937_64& engine() { return random_; }

 private:
  std::mt19937_64 random_;
  std::normal_distribution<double> normal_;
  int count_ = 0;
};

constexpr int kTrials = 1000;

}  // namespace covey::testing
