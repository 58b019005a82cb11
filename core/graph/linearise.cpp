// SPDX-License-Identifier: BSD-3-Clause
#include "core/graph/linearise.h"

#include <cmath>

#include "core/graph/linearisation_point.h"

namespace covey::graph {
namespace {

using RowMajorMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

int number_columns(const Graph& graph, const Values& values, Linearisation& model) {
  int columns = 0;
  for (const Key key : graph.keys()) {
    if (graph.is_constant(key)) continue;
    model.first_column[key] = columns;
    columns += values.type(key).tangent;
  }
  return columns;
}

int number_rows(const Graph& graph, Linearisation& model) {
  int rows = 0;
  for (const FactorId id : graph.ids()) {
    model.first_row[id] = rows;
    rows += graph.factor(id).residual_dim();
  }
  return rows;
}

}  // namespace

Linearisation linearise(const Graph& graph, const Values& values) {
  Linearisation model;
  const int columns = number_columns(graph, values, model);
  const int rows = number_rows(graph, model);
  model.r.resize(rows);
  std::vector<Eigen::Triplet<double>> triplets;
  for (const auto& [id, first_row] : model.first_row) {
    const Factor& factor = graph.factor(id);
    std::vector<RowMajorMatrix> blocks;
    std::vector<double*> jacobians;
    for (const VariableType type : factor.types()) blocks.emplace_back(factor.residual_dim(), type.tangent);
    for (RowMajorMatrix& block : blocks) jacobians.push_back(block.data());
    auto r = model.r.segment(first_row, factor.residual_dim());
    LinearisationPoint(graph, factor)
        .evaluate(variable_pointers(factor, values).data(), r.data(), jacobians.data());
    const double scale = std::sqrt(graph.robust(id).derivative(r.squaredNorm()));
    r *= scale;
    for (std::size_t k = 0; k < blocks.size(); ++k) {
      const auto column = model.first_column.find(factor.keys()[k]);
      if (column == model.first_column.end()) continue;
      for (Eigen::Index i = 0; i < blocks[k].rows(); ++i) {
        for (Eigen::Index j = 0; j < blocks[k].cols(); ++j) {
          triplets.emplace_back(first_row + i, column->second + j, scale * blocks[k](i, j));
        }
      }
    }
  }
  model.J.resize(rows, columns);
  model.J.setFromTriplets(triplets.begin(), triplets.end());
  return model;
}

}  // namespace covey::graph
