// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The noise of a residual as its square-root information U, U^T U = covariance^-1; a factor's cost is |U
// r|^2. Information may be semi-definite (directions without information). A covariance is inverted with its
// eigenvalues held above 1e-12 of the largest, so that a rank-deficient one means "very certain", not a
// division by zero.

#include <Eigen/Core>

namespace covey::graph {

namespace internal {
Eigen::MatrixXd root_of_information(const Eigen::MatrixXd& information);
Eigen::MatrixXd root_of_inverse(const Eigen::MatrixXd& covariance);
}  // namespace internal

template <int N>
class Noise {
 public:
  using Matrix = Eigen::Matrix<double, N, N>;
  using Column = Eigen::Matrix<double, N, 1>;

  Noise() = default;  // unit: the residual is white already

  static Noise sigma(double sigma) { return Noise(Matrix(Matrix::Identity() / sigma)); }
  static Noise sigmas(const Column& sigmas) { return Noise(Matrix(sigmas.cwiseInverse().asDiagonal())); }
  static Noise information(const Matrix& information) {
    return Noise(Matrix(internal::root_of_information(information)));
  }
  static Noise covariance(const Matrix& covariance) {
    return Noise(Matrix(internal::root_of_inverse(covariance)));
  }

  bool is_unit() const { return is_unit_; }
  const Matrix& sqrt_information() const { return sqrt_information_; }

 private:
  explicit Noise(const Matrix& sqrt_information) : is_unit_(false), sqrt_information_(sqrt_information) {}

  bool is_unit_ = true;
  Matrix sqrt_information_ = Matrix::Identity();
};

}  // namespace covey::graph
