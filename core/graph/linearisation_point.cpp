// SPDX-License-Identifier: BSD-3-Clause
#include "core/graph/linearisation_point.h"

namespace covey::graph {
namespace {

// J <- J M
void carry(VariableType type, const double* x, const double* x_0, int rows, double* jacobian) {
  if (type.space == Space::kVector) return;
  using RowMajorMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  Eigen::Map<RowMajorMatrix> J(jacobian, rows, type.tangent);
  J = J * minus_jacobian(type, x, x_0);
}

}  // namespace

LinearisationPoint::LinearisationPoint(const Graph& graph, const Factor& factor) : factor_(factor) {
  const std::vector<Key>& keys = factor.keys();
  for (std::size_t k = 0; k < keys.size(); ++k) {
    if (!graph.held().has(keys[k])) continue;
    held_.resize(keys.size(), nullptr);
    held_[k] = graph.held().data(keys[k]);
  }
}

void LinearisationPoint::evaluate(const double* const* x, double* residual, double* const* jacobians) const {
  if (held_.empty() || !jacobians) return factor_.evaluate(x, residual, jacobians);
  x_0_.assign(x, x + held_.size());
  for (std::size_t k = 0; k < held_.size(); ++k) {
    if (held_[k]) x_0_[k] = held_[k];
  }
  factor_.evaluate(x_0_.data(), residual, jacobians);
  for (std::size_t k = 0; k < held_.size(); ++k) {
    if (held_[k] && jacobians[k])
      carry(factor_.types()[k], x[k], held_[k], factor_.residual_dim(), jacobians[k]);
  }
  factor_.evaluate(x, residual, nullptr);
}

}  // namespace covey::graph
