// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/anderson.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <utility>

namespace covey::pgo {
namespace {

constexpr double kRidge = 1e-10;  // of the squared differences
constexpr double kLargestSum =
    1e3;  // of |a_k|: beyond, rounding errors of what is combined are all that is left

}  // namespace

void Anderson::add(const std::vector<double>& products) {
  const Eigen::Index kept =
      std::min<Eigen::Index>({gram_.rows(), window_, static_cast<Eigen::Index>(products.size()) - 1});
  Eigen::MatrixXd gram(kept + 1, kept + 1);
  gram.bottomRightCorner(kept, kept) = gram_.topLeftCorner(kept, kept);
  for (Eigen::Index k = 0; k <= kept; ++k) gram(0, k) = gram(k, 0) = products[k];
  gram_ = std::move(gram);
}

// With differences to the newest step, a_0 = 1 - sum g, a_k = g_k: a small positive definite system. Older steps are left out
// until it is well enough conditioned.
std::vector<double> Anderson::coefficients() const {
  for (Eigen::Index m = gram_.rows() - 1; m > 0; --m) {
    Eigen::MatrixXd D(m, m);
    Eigen::VectorXd d(m);
    for (Eigen::Index a = 0; a < m; ++a) {
      d[a] = gram_(0, 0) - gram_(0, a + 1);
      for (Eigen::Index b = 0; b < m; ++b)
        D(a, b) = gram_(a + 1, b + 1) - gram_(a + 1, 0) - gram_(0, b + 1) + gram_(0, 0);
    }
    D.diagonal() *= 1.0 + kRidge;
    const Eigen::LLT<Eigen::MatrixXd> factor(D);
    if (factor.info() != Eigen::Success) continue;
    const Eigen::VectorXd g = factor.solve(d);
    const double a0 = 1.0 - g.sum();
    if (!(std::abs(a0) + g.cwiseAbs().sum() < kLargestSum)) continue;
    std::vector<double> a{a0};
    a.insert(a.end(), g.begin(), g.end());
    return a;
  }
  return {1.0};
}

}  // namespace covey::pgo
