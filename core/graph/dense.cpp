// SPDX-License-Identifier: BSD-3-Clause
#include "core/graph/dense.h"

#include <algorithm>

#include "core/base/error.h"

// The Fortran interfaces of LAPACK and BLAS, whose names they are. NOLINTBEGIN(readability-identifier-naming)
extern "C" {
void dpotrf_(const char* uplo, const int* n, double* a, const int* lda, int* info);
void dtrsm_(const char* side, const char* uplo, const char* trans, const char* diag, const int* m,
            const int* n, const double* alpha, const double* a, const int* lda, double* b, const int* ldb);
void dsyrk_(const char* uplo, const char* trans, const int* n, const int* k, const double* alpha,
            const double* a, const int* lda, const double* beta, double* c, const int* ldc);
void dgemm_(const char* transa, const char* transb, const int* m, const int* n, const int* k,
            const double* alpha, const double* a, const int* lda, const double* b, const int* ldb,
            const double* beta, double* c, const int* ldc);
}
// NOLINTEND(readability-identifier-naming)

namespace covey::graph {
namespace {

constexpr int kSquareColumns = 96;  // of L L^T at a time

int size(Eigen::Index n) { return static_cast<int>(n); }

}  // namespace

bool cholesky_in_place(MatrixRef A) {
  COVEY_CHECK(A.rows() == A.cols());
  if (A.rows() == 0) return true;
  const int n = size(A.rows());
  const int stride = size(A.outerStride());
  int info = 0;
  dpotrf_("L", &n, A.data(), &stride, &info);
  return info == 0;
}

void divide_by_transposed(const ConstMatrixRef& L, MatrixRef B) {
  COVEY_CHECK(L.rows() == L.cols() && B.cols() == L.rows());
  if (B.size() == 0) return;
  const int m = size(B.rows());
  const int n = size(B.cols());
  const int stride_L = size(L.outerStride());
  const int stride_B = size(B.outerStride());
  const double one = 1.0;
  dtrsm_("R", "L", "T", "N", &m, &n, &one, L.data(), &stride_L, B.data(), &stride_B);
}

void subtract_square(const ConstMatrixRef& A, MatrixRef C) {
  COVEY_CHECK(C.rows() == C.cols() && A.rows() == C.rows());
  if (A.size() == 0) return;
  const int n = size(A.rows());
  const int k = size(A.cols());
  const int stride_A = size(A.outerStride());
  const int stride_C = size(C.outerStride());
  const double minus_one = -1.0;
  const double one = 1.0;
  dsyrk_("L", "N", &n, &k, &minus_one, A.data(), &stride_A, &one, C.data(), &stride_C);
}

Eigen::MatrixXd square_of_lower(const ConstMatrixRef& L) {
  COVEY_CHECK(L.rows() == L.cols());
  const int n = size(L.rows());
  Eigen::MatrixXd square(n, n);
  const int stride_L = size(L.outerStride());
  const double one = 1.0;
  const double zero = 0.0;
  for (int j = 0; j < n; j += kSquareColumns) {
    const int rows = n - j;
    const int columns = std::min(kSquareColumns, rows);
    const int inner = j + columns;  // beyond these L's rows of the block column are zero
    dgemm_("N", "T", &rows, &columns, &inner, &one, L.data() + j, &stride_L, L.data() + j, &stride_L, &zero,
           square.data() + j + static_cast<std::ptrdiff_t>(j) * n, &n);
  }
  return square;
}

}  // namespace covey::graph
