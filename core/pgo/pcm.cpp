// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/pcm.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <limits>
#include <utility>

#include "core/base/error.h"

namespace covey::pgo {
namespace {

Matrix6d moved(const Matrix6d& covariance, const SE3& T) {
  const Matrix6d adjoint = T.adjoint();
  return adjoint * covariance * adjoint.transpose();
}

Matrix6d covariance_of(const Edge& edge, int dimension) {
  Vector6d variances;
  if (dimension == 2) {
    variances << 1.0 / edge.tau, 1.0 / edge.tau, 0.0, 0.0, 0.0, 1.0 / edge.kappa;
  } else {
    variances << Eigen::Vector3d::Constant(1.0 / edge.tau), Eigen::Vector3d::Constant(0.5 / edge.kappa);
  }
  return variances.asDiagonal();
}

template <int N>
double squared_mahalanobis(const Eigen::Matrix<double, N, 1>& xi,
                           const Eigen::Matrix<double, N, N>& covariance) {
  const Eigen::LLT<Eigen::Matrix<double, N, N>> factor(covariance);
  if (factor.info() != Eigen::Success) return std::numeric_limits<double>::infinity();
  return factor.matrixL().solve(xi).squaredNorm();
}

}  // namespace

double CycleError::squared_mahalanobis() const {
  if (dimension == 3) return pgo::squared_mahalanobis<6>(xi, covariance);
  const std::array<int, 3> planar = {0, 1, 5};  // x, y, heading
  return pgo::squared_mahalanobis<3>(xi(planar), covariance(planar, planar));
}

void PairwiseConsistency::update(const PoseGraph& graph) {
  const std::size_t known = loop_numbers_.size();
  COVEY_CHECK(graph.edges.size() >= known && graph.poses_per_robot.size() >= places_.size());
  dimension_ = graph.dimension;
  extend_chains(graph);
  loop_numbers_.resize(graph.edges.size(), -1);
  for (std::size_t e = known; e < graph.edges.size(); ++e) {
    const Edge& edge = graph.edges[e];
    if (edge.kind == EdgeKind::kLoop && !edge.known_inlier) add_loop(edge, static_cast<int>(e));
  }
}

// A pose that no odometry leads to begins a chain of its own. Of doubled odometry the first edge is taken.
void PairwiseConsistency::extend_chains(const PoseGraph& graph) {
  places_.resize(graph.poses_per_robot.size());
  std::vector<std::vector<const Edge*>> into(places_.size());
  for (int robot = 0; robot < graph.robots(); ++robot)
    into[robot].resize(graph.poses_per_robot[robot], nullptr);
  for (std::size_t e = loop_numbers_.size(); e < graph.edges.size(); ++e) {
    const Edge& edge = graph.edges[e];
    if (edge.kind != EdgeKind::kOdometry || edge.between_robots() || edge.to.index != edge.from.index + 1)
      continue;
    const Edge*& slot = into[edge.to.robot][edge.to.index];
    if (slot == nullptr) slot = &edge;
  }
  for (int robot = 0; robot < graph.robots(); ++robot) {
    for (int index = static_cast<int>(places_[robot].size()); index < graph.poses_per_robot[robot]; ++index) {
      const Edge* step = into[robot][index];
      if (step == nullptr) {
        places_[robot].push_back({static_cast<int>(chains_.size()), 0});
        chains_.push_back({robot, {SE3{}}, {Matrix6d::Zero()}});
        continue;
      }
      const Place before = places_[robot].back();
      Chain& chain = chains_[before.chain];
      chain.poses.push_back(chain.poses.back() * step->measurement);
      chain.covariance.push_back(chain.covariance.back() +
                                 moved(covariance_of(*step, graph.dimension), chain.poses.back()));
      places_[robot].push_back({before.chain, before.index + 1});
    }
  }
}

int PairwiseConsistency::group_of(int chain_a, int chain_b) {
  const auto found = std::find_if(groups_.begin(), groups_.end(), [&](const Group& group) {
    return group.chain_a == chain_a && group.chain_b == chain_b;
  });
  if (found != groups_.end()) return static_cast<int>(found - groups_.begin());
  Group group;
  group.chain_a = chain_a;
  group.chain_b = chain_b;
  groups_.push_back(std::move(group));
  return static_cast<int>(groups_.size()) - 1;
}

void PairwiseConsistency::add_loop(const Edge& edge, int number) {
  const Place from = places_[edge.from.robot][edge.from.index];
  const Place to = places_[edge.to.robot][edge.to.index];
  const bool forward = std::pair(from.chain, from.index) <= std::pair(to.chain, to.index);
  const Place& first = forward ? from : to;
  const Place& second = forward ? to : from;
  const SE3& P = chains_[first.chain].poses[first.index];
  const SE3& Q = chains_[second.chain].poses[second.index];
  const Matrix6d S = covariance_of(edge, dimension_);
  Loop loop;
  loop.edge = number;
  loop.i = first.index;
  loop.k = second.index;
  if (forward) {
    loop.X = P * edge.measurement * Q.inverse();
    loop.M = moved(S, P * edge.measurement);
  } else {  // the inverse has the covariance Ad_Z S Ad_Z^T, and P Z^-1 Z = P
    loop.X = P * edge.measurement.inverse() * Q.inverse();
    loop.M = moved(S, P);
  }
  loop.group = group_of(first.chain, second.chain);
  loop_numbers_[number] = static_cast<int>(loops_.size());
  loops_.push_back(loop);

  Group& group = groups_[loop.group];
  group.loops.push_back(loop_numbers_[number]);
  const bool own = group.chain_a == group.chain_b;
  if (own && !(cycle(loop).squared_mahalanobis() <= options_.barc2)) return;
  group.changed = true;
  const int vertex = group.agreeing.add_vertex();
  for (int other = 0; other < vertex; ++other) {
    if (cycle(loops_[group.vertices[other]], loop).squared_mahalanobis() <= options_.barc2)
      group.agreeing.join(other, vertex);
  }
  group.vertices.push_back(loop_numbers_[number]);
}

// A_to - A_from or its negative, whichever is positive semidefinite.
Matrix6d PairwiseConsistency::stretch(int chain, int from, int to) const {
  const std::vector<Matrix6d>& sums = chains_[chain].covariance;
  return sums[std::max(from, to)] - sums[std::min(from, to)];
}

CycleError PairwiseConsistency::cycle(const Loop& first, const Loop& second) const {
  const Group& group = groups_[first.group];
  CycleError error{(first.X * second.X.inverse()).log(), first.M + second.M, dimension_};
  const Matrix6d adjoint = first.X.adjoint();
  Matrix6d of_a = stretch(group.chain_a, first.i, second.i);
  Matrix6d of_b = stretch(group.chain_b, first.k, second.k);
  if (group.chain_a == group.chain_b) {
    const int begin = std::max(std::min(first.i, second.i), std::min(first.k, second.k));
    const int end = std::min(std::max(first.i, second.i), std::max(first.k, second.k));
    if (begin < end) {
      const Matrix6d common = stretch(group.chain_a, begin, end);
      of_a -= common;
      of_b -= common;
      const double sign = (first.i > second.i) == (second.k > first.k) ? 1.0 : -1.0;
      const Matrix6d both = Matrix6d::Identity() + sign * adjoint;
      error.covariance += both * common * both.transpose();
    }
  }
  error.covariance += of_a + adjoint * of_b * adjoint.transpose();
  return error;
}

CycleError PairwiseConsistency::cycle(const Loop& loop) const {
  return {loop.X.log(), loop.M + stretch(groups_[loop.group].chain_a, loop.i, loop.k), dimension_};
}

const PairwiseConsistency::Loop& PairwiseConsistency::loop_of(int edge) const {
  COVEY_CHECK(loop_numbers_[edge] >= 0);
  return loops_[loop_numbers_[edge]];
}

CycleError PairwiseConsistency::cycle_of(int edge_1, int edge_2) const {
  COVEY_CHECK(loop_of(edge_1).group == loop_of(edge_2).group);
  return cycle(loop_of(edge_1), loop_of(edge_2));
}

CycleError PairwiseConsistency::cycle_of(int edge) const {
  const Group& group = groups_[loop_of(edge).group];
  COVEY_CHECK(group.chain_a == group.chain_b);
  return cycle(loop_of(edge));
}

void PairwiseConsistency::find_clique(Group& group) const {
  const auto& clock = options_.clique.clock;
  const double begin = clock ? clock() : 0.0;
  group.clique = maximum_clique(group.agreeing, options_.clique);
  group.seconds = clock ? clock() - begin : 0.0;
  group.changed = false;
}

PcmResult PairwiseConsistency::solve() {
  PcmResult result;
  result.kept.assign(loop_numbers_.size(), true);
  for (Group& group : groups_) {
    if (group.changed) find_clique(group);
    for (const int loop : group.loops) result.kept[loops_[loop].edge] = false;
    for (const int vertex : group.clique.vertices) result.kept[loops_[group.vertices[vertex]].edge] = true;
    const auto [a, b] = std::minmax(chains_[group.chain_a].robot, chains_[group.chain_b].robot);
    PcmGroup evidence{a, b, static_cast<int>(group.loops.size())};
    for (int v = 0; v < group.agreeing.size(); ++v) evidence.agreeing_pairs += group.agreeing.degree(v);
    evidence.agreeing_pairs /= 2;
    evidence.kept = static_cast<int>(group.clique.vertices.size());
    evidence.exact = group.vertices.empty() || group.clique.exact;
    evidence.seconds = group.seconds;
    result.exact = result.exact && evidence.exact;
    result.groups.push_back(evidence);
  }
  return result;
}

PcmResult consistent_loops(const PoseGraph& graph, const PcmOptions& options) {
  PairwiseConsistency consistency(options);
  consistency.update(graph);
  return consistency.solve();
}

PoseGraph keep_edges(const PoseGraph& graph, const std::vector<bool>& kept) {
  COVEY_CHECK(kept.size() == graph.edges.size());
  PoseGraph part{graph.dimension, graph.poses_per_robot, {}};
  for (std::size_t e = 0; e < kept.size(); ++e) {
    if (kept[e]) part.edges.push_back(graph.edges[e]);
  }
  return part;
}

std::int64_t exchange_bytes(const PcmResult& result) {
  constexpr std::int64_t kBytesPerLoop = (7 + 21) * 8 + 1;
  std::int64_t bytes = 0;
  for (const PcmGroup& group : result.groups) bytes += group.a == group.b ? 0 : group.loops * kBytesPerLoop;
  return bytes;
}

}  // namespace covey::pgo
