// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The spaces that variables live in. A value is stored as `ambient` doubles; a perturbation has `tangent` of
// them and acts on the right: plus(x, d) = x * Exp(d), minus(y, x) = Log(x^-1 * y), with translation before
// rotation.
//
//   T                ambient (as stored)            tangent
//   Vector<N>        N                              N           1 <= N <= 16
//   SO3              4: quaternion x y z w          3: phi
//   SE2              3: x y angle                   3: rho theta
//   SE3              7: x y z, quaternion x y z w   6: rho phi
//
//   plus(x, minus(y, x)) = y,   minus(plus(x, d), x) = d for |d| < pi,   plus(x, 0) = x
//   minus(plus(y, d), x) = minus(y, x) + minus_jacobian(y, x) d   to first order in d

#include <Eigen/Core>
#include <cstdint>

#include "core/geometry/se2.h"
#include "core/geometry/se3.h"

namespace covey::graph {

template <int N>
using Vector = Eigen::Matrix<double, N, 1>;

constexpr int kMaxAmbient = 16;

enum class Space : std::uint8_t { kVector, kSO3, kSE2, kSE3 };

struct VariableType {
  Space space = Space::kVector;
  std::uint8_t ambient = 0;
  std::uint8_t tangent = 0;

  bool operator==(const VariableType&) const = default;
};

// How a value type is stored. Specialised below for every T of the table.
template <typename T>
struct Manifold;

template <int N>
struct Manifold<Eigen::Matrix<double, N, 1>> {
  static_assert(N >= 1 && N <= kMaxAmbient);
  static constexpr int kTangent = N;
  static constexpr VariableType kType{Space::kVector, N, N};
  static Vector<N> load(const double* x) { return Eigen::Map<const Vector<N>>(x); }
  static void store(const Vector<N>& value, double* x) { Eigen::Map<Vector<N>>{x} = value; }
};

template <>
struct Manifold<SO3> {
  static constexpr int kTangent = 3;
  static constexpr VariableType kType{Space::kSO3, 4, 3};
  static SO3 load(const double* x) { return SO3::from_quaternion({x[3], x[0], x[1], x[2]}); }
  static void store(const SO3& value, double* x) {
    Eigen::Map<Eigen::Vector4d>{x} = value.quaternion().coeffs();
  }
};

template <>
struct Manifold<SE2> {
  static constexpr int kTangent = 3;
  static constexpr VariableType kType{Space::kSE2, 3, 3};
  static SE2 load(const double* x) { return {x[2], {x[0], x[1]}}; }
  static void store(const SE2& value, double* x) {
    Eigen::Map<Eigen::Vector3d>{x} << value.translation, wrap_angle(value.angle);
  }
};

template <>
struct Manifold<SE3> {
  static constexpr int kTangent = 6;
  static constexpr VariableType kType{Space::kSE3, 7, 6};
  static SE3 load(const double* x) { return {Manifold<SO3>::load(x + 3), {x[0], x[1], x[2]}}; }
  static void store(const SE3& value, double* x) {
    Eigen::Map<Eigen::Vector3d>{x} = value.translation;
    Manifold<SO3>::store(value.rotation, x + 3);
  }
};

// The same operations where the type is known at run time only; pointers as in the table. `result` may be
// `x`.
void plus(VariableType type, const double* x, const double* delta, double* result);
void minus(VariableType type, const double* y, const double* x, double* delta);
// tangent x tangent
Eigen::MatrixXd minus_jacobian(VariableType type, const double* y, const double* x);

}  // namespace covey::graph
