// SPDX-License-Identifier: BSD-3-Clause
#include "core/graph/elimination.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <catch2/catch.hpp>
#include <random>

using namespace covey::graph;
using Sparse = Eigen::SparseMatrix<double>;

namespace {

// Symmetric, a third of it filled, of any definiteness.
Eigen::MatrixXd random_symmetric(int size, std::mt19937& random) {
  std::normal_distribution<double> normal;
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(size, size);
  for (int i = 0; i < size; ++i) {
    for (int j = 0; j < i; ++j) A(i, j) = A(j, i) = random() % 3 == 0 ? normal(random) : 0.0;
  }
  return A;
}

Sparse lower_of(const Eigen::MatrixXd& A) {
  return Sparse(Eigen::MatrixXd(A.triangularView<Eigen::Lower>()).sparseView());
}

}  // namespace

TEST_CASE(
    "the complement is that of the dense matrix, for every cut and after every change of the diagonal") {
  std::mt19937 random(1);
  const Eigen::MatrixXd A = random_symmetric(12, random);
  for (const int interior : {0, 1, 7, 12}) {
    Elimination elimination(interior, lower_of(A));
    for (const double shift : {6.0, 9.0}) {
      Eigen::VectorXd D = Eigen::VectorXd::Constant(12, shift);
      D[3] += 1.0;
      REQUIRE(elimination.factorise(D));
      const Eigen::MatrixXd T = A + Eigen::MatrixXd(D.asDiagonal());
      const int boundary = 12 - interior;
      const Eigen::MatrixXd T_ii = T.topLeftCorner(interior, interior);
      const Eigen::MatrixXd T_ib = T.topRightCorner(interior, boundary);
      Eigen::MatrixXd expected = T.bottomRightCorner(boundary, boundary);
      if (interior > 0) expected -= T_ib.transpose() * T_ii.llt().solve(T_ib);
      CHECK((elimination.complement() - expected).norm() < 1e-12);
      const Eigen::MatrixXd B = Eigen::MatrixXd::Random(interior, 2);
      CHECK((T_ii * elimination.solve(B) - B).norm() < 1e-12);
      CHECK((Eigen::MatrixXd(elimination.coupling()) - T_ib.transpose()).norm() == 0.0);
    }
  }
}

TEST_CASE("the interior is found to be positive definite exactly where its eigenvalues say so") {
  std::mt19937 random(2);
  for (int trial = 0; trial < 20; ++trial) {
    const Eigen::MatrixXd A = random_symmetric(10, random);
    Elimination elimination(6, lower_of(A));
    const double lowest =
        Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(A.topLeftCorner(6, 6)).eigenvalues().minCoeff();
    CHECK(elimination.factorise(Eigen::VectorXd::Constant(10, -lowest + 1e-9)));
    CHECK(!elimination.factorise(Eigen::VectorXd::Constant(10, -lowest - 1e-9)));
    CHECK(elimination.factorise(
        Eigen::VectorXd::Constant(10, -lowest + 1e-9)));  // a failure leaves nothing behind
  }
}
