// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/team_matrix.h"

#include <algorithm>
#include <utility>

namespace covey::pgo {
namespace {

constexpr std::int64_t kBytesPerName = 4;   // of a pose or a piece
constexpr std::int64_t kBytesPerPlace = 2;  // of a pose among those that a robot has named

}  // namespace

EdgeBlocks connection_blocks(const Edge& edge, int d) {
  PoseBlock M = PoseBlock::Identity(d + 1, d + 1);
  M.topLeftCorner(d, d) = rotation_of(edge.measurement, d);
  M.topRightCorner(d, 1) = translation_of(edge.measurement, d);
  PoseBlock omega = PoseBlock::Zero(d + 1, d + 1);
  omega.diagonal().setConstant(edge.kappa);
  omega(d, d) = edge.tau;
  const PoseBlock MW = M * omega;
  return {MW * M.transpose(), -MW, omega};
}

EdgeBlocks laplacian_blocks(const Edge& edge, int) {
  const PoseBlock tau = PoseBlock::Constant(1, 1, edge.tau);
  return {tau, -tau, tau};
}

void BlockSum::add(const std::vector<int>& clique, Eigen::MatrixXd block) {
  cliques.push_back(clique);
  blocks.push_back(std::move(block));
}

void BlockSum::hold(int place) {
  double largest = 1.0;
  for (const Eigen::MatrixXd& block : blocks) largest = std::max(largest, block.cwiseAbs().maxCoeff());
  Eigen::MatrixXd block = Eigen::MatrixXd::Zero(size, size);
  block(size - 1, size - 1) = largest;
  add({place}, std::move(block));
}

TeamMatrix::TeamMatrix(const SeparatedGraph& team, int size, EdgeBlocksOf blocks_of,
                       const std::vector<PoseBlock>& less)
    : team_(team), size_(size) {
  for (const RobotPart& part : team.parts()) {
    shares_.push_back(share_of(part, blocks_of, less));
    std::vector<bool> kept(part.poses.size(), true);
    std::fill_n(kept.begin(), part.interior, false);
    factors_.emplace_back(std::vector<int>(kept.size(), size), shares_.back().cliques, kept);
    if (!is_first(part)) bytes_ += 2 * kBytesPerName * part.boundary();  // the pose's and its part's
  }
}

bool TeamMatrix::factorise(const Eigen::VectorXd& shift) {
  const Eigen::VectorXd all_shifts = shift.replicate(team_.graph().poses(), 1);
  bool definite = true;
  for (std::size_t m = 0; m < factors_.size(); ++m) {
    const RobotPart& part = team_.parts()[m];
    definite = factors_[m].factorise(shares_[m].blocks, own_rows(part, all_shifts)) && definite;
    if (!is_first(part)) ++bytes_;
  }
  if (!definite) return false;
  BlockSum sum{size_, {}, {}};
  for (std::size_t m = 0; m < factors_.size(); ++m)
    add_complement(team_.parts()[m], factors_[m].schur(), sum);
  const std::vector<int>& separator = team_.separator();
  for (const int pose : team_.held_poses(separator, {})) sum.hold(team_.place_in_separator(pose));
  const std::vector<int> sizes(separator.size(), size_);
  sum_.emplace(sizes, sum.cliques, std::vector<bool>(separator.size(), false));
  return sum_->factorise(sum.blocks, Eigen::VectorXd::Zero(sum_->size()));
}

Eigen::VectorXd TeamMatrix::solve(const Eigen::VectorXd& b) {
  Eigen::VectorXd of_separator = Eigen::VectorXd::Zero(sum_->size());
  std::vector<Eigen::VectorXd> forward;
  for (std::size_t m = 0; m < factors_.size(); ++m) {
    const RobotPart& part = team_.parts()[m];
    forward.push_back(factors_[m].forward(own_rows(part, b)));
    for (int k = 0; k < part.boundary(); ++k)
      of_separator.segment(size_ * team_.place_in_separator(part.boundary_pose(k)), size_) +=
          forward[m].segment(size_ * (part.interior + k), size_);
    if (!is_first(part)) bytes_ += kBytesPerNumber * size_ * part.boundary();
  }
  of_separator = sum_->backward(sum_->forward(of_separator));
  bytes_ += kBytesPerNumber * of_separator.size();
  Eigen::VectorXd x(b.size());
  for (std::size_t m = 0; m < factors_.size(); ++m) {
    const RobotPart& part = team_.parts()[m];
    for (int k = 0; k < part.boundary(); ++k)
      forward[m].segment(size_ * (part.interior + k), size_) =
          of_separator.segment(size_ * team_.place_in_separator(part.boundary_pose(k)), size_);
    const Eigen::VectorXd mine = factors_[m].backward(std::move(forward[m]));
    for (const auto& [pose, place] : part.place)
      x.segment(size_ * pose, size_) = mine.segment(size_ * place, size_);
  }
  return x;
}

BlockSum TeamMatrix::share_of(const RobotPart& part, EdgeBlocksOf blocks_of,
                              const std::vector<PoseBlock>& less) const {
  BlockSum share{size_, {}, {}};
  for (const Edge* edge : part.edges) {
    const EdgeBlocks blocks = blocks_of(*edge, team_.graph().dimension);
    const int from = team_.flat(edge->from);
    const int to = team_.flat(edge->to);
    if (team_.owns(part, from)) share.add({part.place.at(from)}, blocks.from_from);
    if (team_.owns(part, to)) share.add({part.place.at(to)}, blocks.to_to);
    if (!team_.couples(part, *edge)) continue;
    Eigen::MatrixXd coupling = Eigen::MatrixXd::Zero(2 * size_, 2 * size_);
    coupling.bottomLeftCorner(size_, size_) = blocks.from_to.transpose();
    coupling.topRightCorner(size_, size_) = blocks.from_to;
    share.add({part.place.at(from), part.place.at(to)}, std::move(coupling));
  }
  for (const auto& [pose, place] : part.place) {
    if (!less.empty() && team_.owns(part, pose)) share.add({place}, -less[pose]);
  }
  const std::vector<int> interior(part.poses.begin(), part.poses.begin() + part.interior);
  const std::vector<int> boundary(part.poses.begin() + part.interior, part.poses.end());
  for (const int pose : team_.held_poses(interior, boundary)) share.hold(part.place.at(pose));
  return share;
}

// Of a vector with size_ rows for each pose by flat index; zero for other robots' poses.
Eigen::VectorXd TeamMatrix::own_rows(const RobotPart& part, const Eigen::VectorXd& all) const {
  Eigen::VectorXd rows = Eigen::VectorXd::Zero(size_ * static_cast<Eigen::Index>(part.poses.size()));
  for (const auto& [pose, place] : part.place) {
    if (team_.owns(part, pose)) rows.segment(size_ * place, size_) = all.segment(size_ * pose, size_);
  }
  return rows;
}

// Blocks between poses that nothing eliminated joins are zero, and are not sent.
void TeamMatrix::add_complement(const RobotPart& part, const Eigen::MatrixXd& complement, BlockSum& sum) {
  for (int p = 0; p < part.boundary(); ++p) {
    for (int q = 0; q <= p; ++q) {
      const PoseBlock block = complement.block(size_ * p, size_ * q, size_, size_);
      if (block.isZero(0.0)) continue;
      const int place = team_.place_in_separator(part.boundary_pose(p));
      if (p == q) {
        sum.add({place}, block);
      } else {
        Eigen::MatrixXd coupling = Eigen::MatrixXd::Zero(2 * size_, 2 * size_);
        coupling.bottomLeftCorner(size_, size_) = block;
        sum.add({team_.place_in_separator(part.boundary_pose(q)), place}, std::move(coupling));
      }
      if (is_first(part)) continue;
      bytes_ += 2 * kBytesPerPlace + kBytesPerNumber * (p == q ? size_ * (size_ + 1) / 2 : size_ * size_);
    }
  }
}

}  // namespace covey::pgo
