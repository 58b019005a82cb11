// SPDX-License-Identifier: BSD-3-Clause
#include "core/graph/damped_system.h"

namespace covey::graph {
namespace {

// CHOLMOD factorises at several times the speed at which it solves, where each number of the factor is used once.
constexpr double kSpeedOfFactorisation = 8.0;
constexpr double kTolerance = 1e-2;  // of the residual, in the norm of the preconditioner's inverse

}  // namespace

bool DampedSystem::is_worn() const {
  const double average = (price_of_factor() + total_iterations_) / solves_;
  return last_iterations_ > average;
}

std::optional<Eigen::VectorXd> DampedSystem::solve(const Eigen::VectorXd& b, const Eigen::VectorXd& damping) {
  if (has_factor_ && !is_worn()) {
    if (auto x = iterate(b, damping)) return x;
  }
  has_factor_ = H.factorise(damping);
  solves_ = 1;
  last_iterations_ = total_iterations_ = 0;
  if (!has_factor_) return std::nullopt;
  return H.solve(b);
}

double DampedSystem::price_of_factor() const { return H.solves_per_factorisation() / kSpeedOfFactorisation; }

std::optional<Eigen::VectorXd> DampedSystem::iterate(const Eigen::VectorXd& b,
                                                     const Eigen::VectorXd& damping) {
  Eigen::VectorXd x = Eigen::VectorXd::Zero(b.size());
  Eigen::VectorXd r = b;
  Eigen::VectorXd z = H.solve(r);
  Eigen::VectorXd p = z;
  double rz = r.dot(z);
  const double enough = kTolerance * kTolerance * rz;
  for (int k = 1; k <= price_of_factor(); ++k) {
    const Eigen::VectorXd q = H.times(p) + damping.cwiseProduct(p);
    const double curvature = p.dot(q);
    if (!(curvature > 0.0 && rz > 0.0)) return std::nullopt;
    const double alpha = rz / curvature;
    x += alpha * p;
    r -= alpha * q;
    z = H.solve(r);
    const double last = rz;
    rz = r.dot(z);
    if (rz <= enough) {
      ++solves_;
      last_iterations_ = k;
      total_iterations_ += k;
      return x;
    }
    p = z + (rz / last) * p;
  }
  return std::nullopt;
}

}  // namespace covey::graph
