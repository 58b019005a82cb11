// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// A symmetric positive semidefinite matrix with a block for each pose of a graph, of which each robot has the blocks of its own
// edges (separated_graph.h), and its factorisation by the team: each robot eliminates its interior and sends its Schur complement
// on the separator poses that it touches to the first robot, who factorises the sum. The whole is positive definite exactly where
// all of these are. What robots send to each other is counted.
//
// The gauge needs no slack: moving all poses of a connected piece by one translation is an exact null vector, so one translation of
// each piece is held, which leaves definiteness as it was.

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/graph/partial_cholesky.h"
#include "core/pgo/separated_graph.h"

namespace covey::pgo {

constexpr std::int64_t kBytesPerNumber = 8;  // between robots

// Of a pose: d + 1 rows at most, on the stack.
using PoseBlock = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, 4, 4>;

// The three blocks of an edge in a matrix over the poses.
struct EdgeBlocks {
  PoseBlock from_from;
  PoseBlock from_to;
  PoseBlock to_to;
};
using EdgeBlocksOf = EdgeBlocks (*)(const Edge& edge, int dimension);

// In Q, d + 1 rows each: |X_to - X_from M|^2_Omega with X = [R t] (certificate.h).
EdgeBlocks connection_blocks(const Edge& edge, int dimension);
// In the normal equations of the translations, one row each.
EdgeBlocks laplacian_blocks(const Edge& edge, int dimension);

// A sum of dense blocks on some poses each, by places in a list of poses.
struct BlockSum {
  int size = 1;  // rows of a pose
  std::vector<std::vector<int>> cliques;
  std::vector<Eigen::MatrixXd> blocks;

  void add(const std::vector<int>& clique, Eigen::MatrixXd block);
  // Takes a null vector away that has the pose's last row in it, by an entry as large as any.
  void hold(int place);
};

class TeamMatrix {
 public:
  // The blocks of all edges, with `size` rows for each pose, less what `less` has for the poses, by flat index; empty for nothing.
  TeamMatrix(const SeparatedGraph& team, int size, EdgeBlocksOf blocks_of,
             const std::vector<PoseBlock>& less = {});

  // Of the matrix with `shift` added to the diagonal of each block; false where it is not positive definite. Each robot says
  // whether its interior is, and sends its complement when all are.
  bool factorise(const Eigen::VectorXd& shift);

  // After factorise(): the solution for a right-hand side with `size` rows for each pose, by flat index.
  Eigen::VectorXd solve(const Eigen::VectorXd& b);

  std::int64_t bytes() const { return bytes_; }  // sent between robots so far

 private:
  // Who gathers the complements, and sends nothing of its own.
  bool is_first(const RobotPart& part) const { return &part == &team_.parts().front(); }
  BlockSum share_of(const RobotPart& part, EdgeBlocksOf blocks_of, const std::vector<PoseBlock>& less) const;
  Eigen::VectorXd own_rows(const RobotPart& part, const Eigen::VectorXd& all) const;
  void add_complement(const RobotPart& part, const Eigen::MatrixXd& complement, BlockSum& sum);

  const SeparatedGraph& team_;
  int size_;
  std::vector<BlockSum> shares_;                 // of each part
  std::vector<graph::PartialCholesky> factors_;  // of each part's share
  std::optional<graph::PartialCholesky> sum_;    // of their complements
  std::int64_t bytes_ = 0;
};

}  // namespace covey::pgo
