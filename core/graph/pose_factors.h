// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Factors on rotations and poses. T stands for SO3, SE2 or SE3.
//
//   Prior<T>            r = Log(measured^-1 x)                        for a Vector<N>: x - measured
//   Between<T>          r = Log(measured^-1 x_i^-1 x_j)               measured = x_i_j; covariance in j,
//   [rho; phi] ChordalBetween2/3   the edge of a pose graph in the cost of CONVENTIONS.md, with E = (R_i
//   R_ij)^-1 R_j of angle a:
//                       |r|^2 = kappa |R_j - R_i R_ij|_F^2 + tau |t_j - t_i - R_i t_ij|^2
//                       r = [sqrt(tau) (R_i^T (t_j - t_i) - t_ij); sqrt(8 kappa) q(E)], q = axis * sin(a / 2)
//
// since |R_j - R_i R_ij|_F^2 = |I - E|_F^2 = 4 (1 - cos a) = 8 sin^2(a / 2), in 2D and 3D alike: the same
// cost as with the d^2 differences of the entries in d (d - 1) / 2 numbers. Noise is unit: kappa and tau are
// the noise. Cost: Rosen et al., "SE-Sync", IJRR 2019.

#include "core/graph/factor.h"

namespace covey::graph {

template <typename T>
struct Prior {
  using Variables = VariableList<T>;
  static constexpr int kDim = Manifold<T>::kTangent;
  using Jacobian = Eigen::Matrix<double, kDim, kDim>;

  T measured;

  Vector<kDim> evaluate(const T& x, Jacobian* J) const {
    if constexpr (Manifold<T>::kType.space == Space::kVector) {
      if (J) J->setIdentity();
      return x - measured;
    } else {
      const Vector<kDim> r = (measured.inverse() * x).log();
      if (J) *J = T::right_jacobian_inverse(r);
      return r;
    }
  }
};

template <typename T>
struct Between {
  using Variables = VariableList<T, T>;
  static constexpr int kDim = Manifold<T>::kTangent;
  using Jacobian = Eigen::Matrix<double, kDim, kDim>;

  T measured;

  Vector<kDim> evaluate(const T& x_i, const T& x_j, Jacobian* J_i, Jacobian* J_j) const {
    const T relative = x_i.inverse() * x_j;
    const Vector<kDim> r = (measured.inverse() * relative).log();
    if (J_i) {
      *J_j = T::right_jacobian_inverse(r);
      *J_i = -*J_j * relative.inverse().adjoint();
    }
    return r;
  }
};

struct ChordalBetween2 {
  using Variables = VariableList<SE2, SE2>;
  static constexpr int kDim = 3;

  SE2 measured;
  double kappa = 1.0;  // 1 / rad^2
  double tau = 1.0;    // 1 / m^2

  Eigen::Vector3d evaluate(const SE2& T_i, const SE2& T_j, Eigen::Matrix3d* J_i, Eigen::Matrix3d* J_j) const;
};

struct ChordalBetween3 {
  using Variables = VariableList<SE3, SE3>;
  static constexpr int kDim = 6;

  SE3 measured;
  double kappa = 1.0;
  double tau = 1.0;

  Vector6d evaluate(const SE3& T_i, const SE3& T_j, Matrix6d* J_i, Matrix6d* J_j) const;
};

}  // namespace covey::graph
