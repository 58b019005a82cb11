// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The one-line check of a factor: its analytic Jacobians against central differences in the tangent spaces,
// at given values.
//
//   REQUIRE(jacobian_error(RangeFactor{3.2}, {pose_key, point_key}, values) < 1e-6);
//
// The result is the largest difference of an entry, relative to the largest entry (at least 1) of the
// Jacobian.

#include <algorithm>
#include <memory>

#include "core/graph/graph.h"

namespace covey::graph::testing {

using RowMajorMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

inline Eigen::VectorXd evaluate(const Factor& factor, const Values& values) {
  Eigen::VectorXd r(factor.residual_dim());
  factor.evaluate(variable_pointers(factor, values).data(), r.data(), nullptr);
  return r;
}

inline std::vector<RowMajorMatrix> analytic_jacobians(const Factor& factor, const Values& values) {
  std::vector<RowMajorMatrix> blocks;
  std::vector<double*> pointers;
  for (const VariableType type : factor.types()) blocks.emplace_back(factor.residual_dim(), type.tangent);
  for (RowMajorMatrix& block : blocks) pointers.push_back(block.data());
  Eigen::VectorXd r(factor.residual_dim());
  factor.evaluate(variable_pointers(factor, values).data(), r.data(), pointers.data());
  COVEY_CHECK((r - evaluate(factor, values)).norm() <= 1e-12 * (1.0 + r.norm()));
  return blocks;
}

inline RowMajorMatrix numeric_jacobian(const Factor& factor, const Values& values, std::size_t variable,
                                       double step) {
  const Key key = factor.keys()[variable];
  const int tangent = factor.types()[variable].tangent;
  RowMajorMatrix J(factor.residual_dim(), tangent);
  for (int c = 0; c < tangent; ++c) {
    Values ahead = values;
    Values behind = values;
    ahead.perturb(key, step * Eigen::VectorXd::Unit(tangent, c));
    behind.perturb(key, -step * Eigen::VectorXd::Unit(tangent, c));
    J.col(c) = (evaluate(factor, ahead) - evaluate(factor, behind)) / (2.0 * step);
  }
  return J;
}

inline double jacobian_error(const Factor& factor, const Values& values, double step = 1e-6) {
  const std::vector<RowMajorMatrix> analytic = analytic_jacobians(factor, values);
  double error = 0.0;
  for (std::size_t k = 0; k < analytic.size(); ++k) {
    const double size = std::max(1.0, analytic[k].cwiseAbs().maxCoeff());
    const RowMajorMatrix difference = analytic[k] - numeric_jacobian(factor, values, k, step);
    error = std::max(error, difference.cwiseAbs().maxCoeff() / size);
  }
  return error;
}

template <FactorModel Model>
double jacobian_error(const Model& model, const Key (&keys)[Model::Variables::kCount], const Values& values,
                      const Noise<Model::kDim>& noise = {}, double step = 1e-6) {
  Graph graph;
  return jacobian_error(graph.factor(graph.add(model, keys, noise)), values, step);
}

}  // namespace covey::graph::testing
