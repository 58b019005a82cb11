// SPDX-License-Identifier: BSD-3-Clause
#include "core/graph/manifold.h"

namespace covey::graph {
namespace {

template <typename T>
void group_plus(const double* x, const double* delta, double* result) {
  const Eigen::Map<const Vector<Manifold<T>::kTangent>> d(delta);
  Manifold<T>::store(Manifold<T>::load(x) * T::exp(d), result);
}

template <typename T>
Vector<Manifold<T>::kTangent> group_minus(const double* y, const double* x) {
  return (Manifold<T>::load(x).inverse() * Manifold<T>::load(y)).log();
}

template <typename T>
void store_group_minus(const double* y, const double* x, double* delta) {
  Eigen::Map<Vector<Manifold<T>::kTangent>>{delta} = group_minus<T>(y, x);
}

}  // namespace

void plus(VariableType type, const double* x, const double* delta, double* result) {
  switch (type.space) {
    case Space::kVector:
      for (int k = 0; k < type.ambient; ++k) result[k] = x[k] + delta[k];
      return;
    case Space::kSO3:
      return group_plus<SO3>(x, delta, result);
    case Space::kSE2:
      return group_plus<SE2>(x, delta, result);
    case Space::kSE3:
      return group_plus<SE3>(x, delta, result);
  }
}

void minus(VariableType type, const double* y, const double* x, double* delta) {
  switch (type.space) {
    case Space::kVector:
      for (int k = 0; k < type.ambient; ++k) delta[k] = y[k] - x[k];
      return;
    case Space::kSO3:
      return store_group_minus<SO3>(y, x, delta);
    case Space::kSE2:
      return store_group_minus<SE2>(y, x, delta);
    case Space::kSE3:
      return store_group_minus<SE3>(y, x, delta);
  }
}

Eigen::MatrixXd minus_jacobian(VariableType type, const double* y, const double* x) {
  switch (type.space) {
    case Space::kSO3:
      return SO3::right_jacobian_inverse(group_minus<SO3>(y, x));
    case Space::kSE2:
      return SE2::right_jacobian_inverse(group_minus<SE2>(y, x));
    case Space::kSE3:
      return SE3::right_jacobian_inverse(group_minus<SE3>(y, x));
    case Space::kVector:
      break;
  }
  return Eigen::MatrixXd::Identity(type.tangent, type.tangent);
}

}  // namespace covey::graph
