// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/shift_search.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <random>

namespace covey::pgo {
namespace {

constexpr int kMaxIterations = 30;

}  // namespace

ShiftSearch::ShiftSearch(const SeparatedGraph& team, TeamMatrix& S)
    : team_(team), S_(S), d_(team.graph().dimension) {
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal;
  x_ = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(d_ + 1) * team.graph().poses());
  for (double& value : x_) value = normal(random);
}

double ShiftSearch::find(double low, double high, double accuracy) {
  if (high <= low || is_enough(low)) return low;
  double eta = std::sqrt(low * high);
  while (high > (1.0 + accuracy) * low) {
    if (is_enough(eta)) {
      high = eta;
      if (high <= (1.0 + accuracy) * low) break;
      const Needed needed = lanczos(eta, 0.25 * accuracy);
      low = std::max(low, needed.eta);
      eta = needed.sharp ? low * (1.0 + accuracy) : std::sqrt(low * high);
    } else {
      low = eta;
      eta = std::sqrt(low * high);
    }
  }
  return high;
}

bool ShiftSearch::is_enough(double eta) {
  ++trials_;
  Eigen::VectorXd shift = Eigen::VectorXd::Constant(d_ + 1, eta);
  shift[d_] = 0.0;
  return S_.factorise(shift);
}

// With D the identity on the rotations and x of unit length there, x^T (S + eta D)^-1 x >= 1 / (eta - needed). Lanczos' method finds
// the x with the largest left-hand side (full orthogonalisation; Golub, van Loan, "Matrix Computations", section 10.3).
ShiftSearch::Needed ShiftSearch::lanczos(double eta, double accuracy) {
  Eigen::MatrixXd V(x_.size(), kMaxIterations);
  Eigen::MatrixXd T = Eigen::MatrixXd::Zero(kMaxIterations, kMaxIterations);
  Eigen::VectorXd next = rotations_of(x_);
  Needed needed;
  for (int k = 0; k < kMaxIterations && next.norm() > 0.0 && !needed.sharp; ++k) {
    V.col(k) = next.normalized();
    const auto basis = V.leftCols(k + 1);
    next = rotations_of(S_.solve(V.col(k)));
    T.col(k).head(k + 1) = basis.transpose() * next;
    T.row(k).head(k + 1) = T.col(k).head(k + 1).transpose();
    for (int twice = 0; twice < 2; ++twice) next -= basis * (basis.transpose() * next);
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(T.topLeftCorner(k + 1, k + 1));
    const double largest = eigen.eigenvalues()[k];
    const auto vector = eigen.eigenvectors().col(k);
    needed.eta = eta - 1.0 / largest;
    needed.sharp = next.norm() * std::abs(vector[k]) < accuracy * needed.eta * largest * largest;
    x_ = basis * vector;
    // For the inner products, to which each robot has its part.
    bytes_ += kBytesPerNumber * 2 * (k + 2) * (static_cast<std::int64_t>(team_.parts().size()) - 1);
  }
  return needed;
}

Eigen::VectorXd ShiftSearch::rotations_of(Eigen::VectorXd x) const {
  for (Eigen::Index k = d_; k < x.size(); k += d_ + 1) x[k] = 0.0;
  return x;
}

}  // namespace covey::pgo
