// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Sparse Cholesky factorisation of a symmetric block matrix that stops before some of its variables. With e the eliminated
// variables and k the kept ones,
//
//   H = [H_ee H_ek; H_ke H_kk],   H_ee = L L^T,   S = H_kk - H_ke H_ee^-1 H_ek   (the Schur complement)
//
// The matrix is given as a sum of dense symmetric blocks, each on a clique of variables: factors of a graph, or Schur
// complements of its parts. The order of elimination keeps fill small (approximate minimum degree, the kept ones last); the
// elimination is multifrontal: a front gathers the blocks and the updates that belong to a few pivots, is factorised as a dense
// matrix, and hands its own Schur complement on to the next front; what arrives at the last one, which has no pivots, is S. The
// pattern is analysed once.
//
// Source: Duff, Reid, "The multifrontal solution of indefinite sparse symmetric linear equations", ACM TOMS 1983; order: Amestoy,
// Davis, Duff, "Algorithm 837: AMD", ACM TOMS 2004, with constraints as in CAMD.

#include <Eigen/Core>
#include <vector>

namespace covey::graph {

class PartialCholesky {
 public:
  // sizes: of the variables. cliques: the different variables of each block, in any order.
  PartialCholesky(const std::vector<int>& sizes, const std::vector<std::vector<int>>& cliques,
                  const std::vector<bool>& kept);

  // blocks: of the cliques, symmetric, each with its variables in the order of the clique. damping: added to H's diagonal, in the
  // order of the variables. False where H_ee is not positive definite; nothing may be solved then.
  bool factorise(const std::vector<Eigen::MatrixXd>& blocks, const Eigen::VectorXd& damping);

  // S in the order of the variables; its lower triangle.
  const Eigen::MatrixXd& schur() const { return fronts_.back().update; }

  // [L^-1 b_e; b_k - H_ke H_ee^-1 b_e] with the eliminated variables in an order of their own, the kept ones last and in theirs.
  Eigen::VectorXd forward(const Eigen::VectorXd& b) const;
  // The solution of H x = b, from what forward() made of b with the x_k in place of its tail.
  Eigen::VectorXd backward(Eigen::VectorXd x) const;

  int size() const { return size_; }  // scalars
  int kept_size() const { return kept_size_; }

 private:
  struct Front {
    std::vector<int>
        variables;  // places in the order of elimination: pivots, then those that their elimination touches
    std::vector<int> rows;  // first row of each variable in the front, and the number of rows
    int pivots = 0;         // variables
    int pivot_rows = 0;
    int parent = -1;                  // where the update goes
    std::vector<int> rows_in_parent;  // of the variables that are no pivots
    std::vector<int> children;
    std::vector<int> cliques;
    Eigen::MatrixXd L;       // rows x pivot_rows
    Eigen::MatrixXd update;  // what is left for the others; empty once it was handed on
  };

  std::vector<int> order_variables(const std::vector<std::vector<int>>& adjacent,
                                   const std::vector<bool>& kept) const;
  void make_fronts(const std::vector<std::vector<int>>& structure, int eliminated);
  void add_front(std::vector<int> variables, int pivots);
  void assemble(Front& front, const std::vector<Eigen::MatrixXd>& blocks, const Eigen::VectorXd& damping);

  std::vector<int> sizes_;
  std::vector<int> offsets_;                   // of each variable
  std::vector<int> order_;                     // variables in the order of elimination
  std::vector<int> ordered_offsets_;           // by place in that order
  std::vector<std::vector<int>> clique_rows_;  // of each clique's variables in its front
  std::vector<std::vector<int>> clique_sizes_;
  std::vector<Front> fronts_;  // children before parents; the last one has no pivots
  int size_ = 0;
  int kept_size_ = 0;
};

}  // namespace covey::graph
