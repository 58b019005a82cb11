// SPDX-License-Identifier: BSD-3-Clause
#include "core/geometry/stiefel.h"

#include <Eigen/LU>
#include <Eigen/QR>
#include <Eigen/SVD>

#include "core/base/error.h"

namespace covey {

Eigen::MatrixXd project_to_stiefel(const Eigen::MatrixXd& Y) {
  COVEY_CHECK(Y.rows() >= Y.cols());
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(Y, Eigen::ComputeThinU | Eigen::ComputeThinV);
  return svd.matrixU() * svd.matrixV().transpose();
}

Eigen::MatrixXd project_to_tangent(const Eigen::MatrixXd& Y, const Eigen::MatrixXd& V) {
  const Eigen::MatrixXd inner = Y.transpose() * V;
  return V - 0.5 * Y * (inner + inner.transpose());
}

Eigen::MatrixXd retract_polar(const Eigen::MatrixXd& Y, const Eigen::MatrixXd& V) {
  return project_to_stiefel(Y + V);
}

Eigen::MatrixXd retract_qr(const Eigen::MatrixXd& Y, const Eigen::MatrixXd& V) {
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(Y + V);
  Eigen::MatrixXd Q = qr.householderQ() * Eigen::MatrixXd::Identity(Y.rows(), Y.cols());
  for (Eigen::Index c = 0; c < Y.cols(); ++c) {
    if (qr.matrixQR()(c, c) < 0.0) Q.col(c) = -Q.col(c);
  }
  return Q;
}

Eigen::MatrixXd random_stiefel(int r, int d, std::mt19937_64& random) {
  COVEY_CHECK(r >= d && d > 0);
  std::normal_distribution<double> normal;
  const Eigen::MatrixXd gaussian = Eigen::MatrixXd::NullaryExpr(r, d, [&] { return normal(random); });
  return retract_qr(gaussian, Eigen::MatrixXd::Zero(r, d));
}

Eigen::MatrixXd project_to_rotation(const Eigen::MatrixXd& m) {
  COVEY_CHECK(m.rows() == m.cols());
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(m, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::MatrixXd U = svd.matrixU();
  if ((U * svd.matrixV().transpose()).determinant() < 0.0) U.rightCols<1>() *= -1.0;
  return U * svd.matrixV().transpose();
}

Eigen::MatrixXd round_lifted(const Eigen::MatrixXd& Y, const Eigen::MatrixXd& anchor) {
  return project_to_rotation(anchor.transpose() * Y);
}

}  // namespace covey
