// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Dense kernels on column-major matrices by BLAS and LAPACK, which choose theirs by the processor they find at run time; Eigen's
// are compiled for the oldest. Of symmetric and triangular matrices only the lower triangle is read and written.

#include <Eigen/Core>

namespace covey::graph {

using MatrixRef = Eigen::Ref<Eigen::MatrixXd>;
using ConstMatrixRef = Eigen::Ref<const Eigen::MatrixXd, 0, Eigen::OuterStride<>>;

// A = L L^T, L in the place of A. False, and A spoilt, where A is not positive definite.
bool cholesky_in_place(MatrixRef A);

// B <- B L^-T
void divide_by_transposed(const ConstMatrixRef& L, MatrixRef B);

// C <- C - A A^T
void subtract_square(const ConstMatrixRef& A, MatrixRef C);

// L L^T, of an L with zeros above the diagonal.
Eigen::MatrixXd square_of_lower(const ConstMatrixRef& L);

}  // namespace covey::graph
