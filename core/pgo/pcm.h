// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Pairwise consistent measurement set maximisation: of all loops between two robots, the largest set any two of which agree.
//
// With P_i the pose i of robot a in the frame of a's odometry, Q_k that of robot b, and Z a loop from i to k, the loop says
// that b's frame lies at X = P_i Z Q_k^-1 in a's. Two loops agree where X_1 X_2^-1 is identity up to its covariance (the cycle
// of Mangelson's equation 5, seen from a's first pose, which does not change its Mahalanobis distance):
//
//   xi = Log(X_1 X_2^-1),   xi^T Sigma^-1 xi <= barc2,
//   Sigma = M_1 + M_2 + (A_i1 - A_i2) + Ad_X1 (B_k2 - B_k1) Ad_X1^T
//
// where M = Ad S Ad^T is the loop's own covariance S, moved from the frame of the loop's second pose to a's first pose by the
// adjoint, and A, B are running sums along a's and b's odometry,
//
//   A_i = sum over m <= i of Ad_(P_m) S_m Ad_(P_m)^T,
//
// S_m of the step that ends at pose m: a stretch of odometry costs one difference, however long. The differences are signed
// so as to be positive semidefinite. Where both stretches lie on one robot and overlap, the steps of the overlap count once,
// with I +- Ad_X1, since their noise is the same noise. S = diag(I / tau, I / (2 kappa)), in 2D 1 / kappa for the heading.
// Loops of a robot with itself also have to agree with the odometry between their ends.
//
// Loops are judged in groups, each by one graph with an edge for every two that agree: a group for every pair of robots and
// one for each robot's own loops (where a robot's odometry is broken: for every two whole pieces). The largest clique is kept
// (max_clique.h). At least one loop of a group between robots stays, so that what was connected stays connected.
//
// A pair of robots could do this by itself: for every shared loop the lower robot has to be told the other end's Q_k and B_k
// (7 + 21 numbers of 8 bytes) and answers whether the loop is kept (1 byte); exchange_bytes() is the sum.
//
// Source: Mangelson, Dominic, Eustice, Vasudevan, "Pairwise consistent measurement set maximization for robust multi-robot map
// merging", ICRA 2018.

#include <cstdint>
#include <vector>

#include "core/pgo/max_clique.h"
#include "core/pgo/pose_graph.h"

namespace covey::pgo {

struct PcmOptions {
  double barc2 = 16.812;  // largest squared Mahalanobis distance of two loops that agree
  CliqueOptions clique{};
};

struct PcmGroup {  // evidence
  int a = 0;       // robots, a <= b
  int b = 0;
  int loops = 0;
  int agreeing_pairs = 0;
  int kept = 0;          // size of the clique
  bool exact = true;     // no larger one exists
  double seconds = 0.0;  // of the clique, where the caller lends a clock (CliqueOptions)
};

struct PcmResult {
  std::vector<bool> kept;  // per edge; odometry and known inliers always are
  std::vector<PcmGroup> groups;
  bool exact = true;  // in all groups
};

// What a cycle of edges does not close by, and how much of that noise explains.
struct CycleError {
  Vector6d xi = Vector6d::Zero();
  Matrix6d covariance = Matrix6d::Zero();
  int dimension = 3;

  double squared_mahalanobis() const;  // infinite where the covariance says nothing
};

class PairwiseConsistency {
 public:
  explicit PairwiseConsistency(const PcmOptions& options = {}) : options_(options) {}

  // The graph as it has grown since the last call: with more poses and, after those it had, more edges. A new loop is compared
  // with the loops of its group, and nothing else is done again.
  void update(const PoseGraph& graph);

  // Cliques of the groups that have changed, and the decisions so far.
  PcmResult solve();

  // The cycle of two loops of one group, and of a robot's own loop and its odometry; by number of edge.
  CycleError cycle_of(int edge_1, int edge_2) const;
  CycleError cycle_of(int edge) const;

 private:
  struct Chain {  // odometry without a gap
    int robot = 0;
    Poses poses;                       // in the frame of the first one
    std::vector<Matrix6d> covariance;  // A
  };
  struct Place {
    int chain = 0;
    int index = 0;
  };
  struct Loop {
    int edge = 0;
    int group = 0;
    int i = 0;  // on the group's first chain
    int k = 0;  // on the second
    SE3 X;
    Matrix6d M;
  };
  struct Group {
    int chain_a = 0;
    int chain_b = 0;
    std::vector<int> loops;  // all
    std::vector<int>
        vertices;  // those that are vertices of `agreeing`: own loops that fit the odometry, loops between robots
    BitGraph agreeing;
    bool changed = false;
    Clique clique;
    double seconds = 0.0;
  };

  void extend_chains(const PoseGraph& graph);
  void add_loop(const Edge& edge, int number);
  int group_of(int chain_a, int chain_b);
  Matrix6d stretch(int chain, int from, int to) const;
  const Loop& loop_of(int edge) const;
  CycleError cycle(const Loop& first, const Loop& second) const;
  CycleError cycle(const Loop& loop) const;
  void find_clique(Group& group) const;

  PcmOptions options_;
  int dimension_ = 3;
  std::vector<Chain> chains_;
  std::vector<std::vector<Place>> places_;  // per robot and pose
  std::vector<Group> groups_;
  std::vector<Loop> loops_;
  std::vector<int> loop_numbers_;  // per edge: of loops_, or -1
};

// All at once.
PcmResult consistent_loops(const PoseGraph& graph, const PcmOptions& options = {});

// The graph without the edges that were not kept.
PoseGraph keep_edges(const PoseGraph& graph, const std::vector<bool>& kept);

// What all pairs of robots of the team would say to each other in order to decide.
std::int64_t exchange_bytes(const PcmResult& result);

}  // namespace covey::pgo
