// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/extrapolation.h"

#include <Eigen/Eigenvalues>
#include <cmath>

namespace covey::pgo {
namespace {

Eigen::Matrix3d symmetric_part(const Eigen::Matrix3d& S) { return 0.5 * (S + S.transpose()); }

void project_to_tangent_space(const Lifted& X, Lifted& V) {
  for (Eigen::Index k = 0; k < X.cols(); k += 4) {
    const auto Y = X.middleCols<3>(k);
    auto U = V.middleCols<3>(k);
    U -= Y.lazyProduct(symmetric_part(Y.transpose().lazyProduct(U))).eval();
  }
}

double inner_product(const Lifted& V, const Lifted& W) { return V.cwiseProduct(W).sum(); }

// W_k sym(Y_k^T E_k) of each pose.
Lifted curvature_times(const Lifted& X, const Lifted& euclidean, const Lifted& W) {
  Lifted result = Lifted::Zero(W.rows(), W.cols());
  for (Eigen::Index k = 0; k < X.cols(); k += 4) {
    const Eigen::Matrix3d S =
        symmetric_part(X.middleCols<3>(k).transpose().lazyProduct(euclidean.middleCols<3>(k)));
    result.middleCols<3>(k) = W.middleCols<3>(k).lazyProduct(S);
  }
  return result;
}

// Minimises c^T g + c^T H c / 2 over what H sees: directions of no length, and such as are combinations of others, add nothing.
Eigen::VectorXd minimise_model(const Eigen::MatrixXd& H, const Eigen::VectorXd& g) {
  constexpr double kSingular = 1e-10;  // relative eigenvalue
  const Eigen::VectorXd scale =
      H.diagonal().unaryExpr([](double h) { return h > 0.0 ? 1.0 / std::sqrt(h) : 0.0; });
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(scale.asDiagonal() * H * scale.asDiagonal());
  const double smallest = kSingular * static_cast<double>(g.size());
  const Eigen::VectorXd inverse =
      eigen.eigenvalues().unaryExpr([&](double value) { return value > smallest ? 1.0 / value : 0.0; });
  const auto& V = eigen.eigenvectors();
  return -(scale.asDiagonal() * (V * (inverse.asDiagonal() * (V.transpose() * scale.cwiseProduct(g)))));
}

}  // namespace

Extrapolation extrapolate(const std::vector<RobotBlock>& blocks, const std::vector<Lifted>& X,
                          const std::vector<Lifted>& public_poses,
                          std::vector<std::vector<Lifted>> directions) {
  std::vector<int> firsts;  // place of each block's coefficients
  int size = 0;
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    firsts.push_back(size);
    size += static_cast<int>(directions[b].size());
    for (Lifted& D : directions[b]) project_to_tangent_space(X[b], D);
  }
  Extrapolation result{{}, std::vector<std::int64_t>(blocks.size(), 0)};
  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(size, size);
  Eigen::VectorXd g(size);
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    const RobotBlock& block = blocks[b];
    const int first = firsts[b];
    const int n = static_cast<int>(directions[b].size());
    const Lifted euclidean = block.solver.euclidean_gradient(targets_of(block, public_poses), X[b]);
    const Lifted none = Lifted::Zero(X[b].rows(), 4 * static_cast<Eigen::Index>(block.ends.size()));
    for (int j = 0; j < n; ++j) {
      const Lifted& D = directions[b][j];
      const Lifted HD = block.solver.euclidean_gradient(none, D) - curvature_times(X[b], euclidean, D);
      g[first + j] = inner_product(D, euclidean);
      for (int i = 0; i <= j; ++i)
        H(first + i, first + j) = H(first + j, first + i) = inner_product(directions[b][i], HD);
    }
    result.numbers_sent[b] += n + n * (n + 1) / 2;
    for (std::size_t e = 0; e < block.ends.size(); ++e) {
      const SharedEnd& end = block.ends[e];
      const auto other = static_cast<std::size_t>(end.block);
      if (other < b) continue;  // the lower one's robot speaks for both
      const SharedEdge& edge = block.solver.shared()[e];
      const Eigen::Vector4d omega(edge.kappa, edge.kappa, edge.kappa, edge.tau);
      const int their_column = 4 * blocks[other].public_poses[end.place];
      for (int i = 0; i < n; ++i) {
        const Lifted mine = my_side(edge, directions[b][i].middleCols<4>(4 * edge.mine)) * omega.asDiagonal();
        for (int j = 0; j < static_cast<int>(directions[other].size()); ++j) {
          const Lifted theirs = other_side(edge, directions[other][j].middleCols<4>(their_column));
          H(first + i, firsts[other] + j) -= 2.0 * inner_product(mine, theirs);
        }
      }
    }
    for (const int other : block.neighbours) {
      if (other < static_cast<int>(b)) continue;
      const auto m = static_cast<int>(directions[other].size());
      result.numbers_sent[b] += n * m;
      H.block(firsts[other], first, m, n) = H.block(first, firsts[other], n, m).transpose();
    }
  }
  const Eigen::VectorXd c = minimise_model(H, g);
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    Lifted step = Lifted::Zero(X[b].rows(), X[b].cols());
    for (std::size_t i = 0; i < directions[b].size(); ++i)
      step += c[firsts[b] + static_cast<int>(i)] * directions[b][i];
    result.X.push_back(retract(X[b], step));
  }
  return result;
}

}  // namespace covey::pgo
