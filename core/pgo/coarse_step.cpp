// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/coarse_step.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "core/pgo/coarse_graph.h"

namespace covey::pgo {
namespace {

constexpr int kMostNodes = 300;           // of the team: a dense system
constexpr double kLeastStiffness = 1e-9;  // of the diagonal: nodes that nothing ties
constexpr int kNodeSize = 3;

Eigen::Vector2d planar(const Eigen::Vector3d& v) { return v.head<2>(); }
// phi x v for phi about z.
Eigen::Vector2d turned(const Eigen::Vector2d& v) { return {-v.y(), v.x()}; }

Eigen::Vector2d position_of(const Lifted& X, int pose) { return X.block<2, 1>(0, 4 * pose + 3); }

SE3 moved_by(const Eigen::Vector3d& step, const SE3& pose) {
  const Eigen::Quaterniond q(1.0, 0.0, 0.0, 0.5 * step.z());
  return {SO3::from_quaternion(q) * pose.rotation,
          pose.translation + Eigen::Vector3d(step.x(), step.y(), 0.0)};
}

}  // namespace

CoarseStep::CoarseStep(const AgreedProblem& problem) : problem_(problem) {
  for (const int robot : problem.part) {
    const OpenedMember& member = problem.members.at(robot);
    const int first = static_cast<int>(nodes_.size());
    for (int s = 0; s < member.join.n_segments; ++s) {
      const std::vector<int> ids = coarse_nodes(member, s);
      if (ids.empty()) {
        nodes_.clear();
        return;
      }
      for (const int id : ids) {
        by_id_[{robot, s}][id] = static_cast<int>(nodes_.size());
        nodes_.push_back({robot, member.places.at({s, id})});
      }
    }
    of_robot_[robot] = {first, static_cast<int>(nodes_.size()) - first};
    std::vector<Share>& shares = public_[robot];
    shares.resize(member.T_S_K.size());
    for (const auto& [name, place] : member.places) {
      if (by_id_.contains({robot, name.first})) shares[place] = share(robot, name.first, name.second);
    }
  }
  for (int s = 0; s < static_cast<int>(problem.graph.segments.size()); ++s) {
    for (int id = 0; id < static_cast<int>(problem.graph.segments[s].poses.size()); ++id)
      own_.push_back(share(problem.robot(), s, id));
  }
  step_ = Eigen::VectorXd::Zero(kNodeSize * static_cast<Eigen::Index>(nodes_.size()));
}

bool CoarseStep::useful() const {
  return nodes_.size() > of_robot_.size() && static_cast<int>(nodes_.size()) <= kMostNodes;
}

CoarseStep::Share CoarseStep::share(int robot, int segment, int id) const {
  const std::map<int, int>& nodes = by_id_.at({robot, segment});
  const auto after = nodes.lower_bound(id);
  if (after == nodes.end()) return {nodes.rbegin()->second, nodes.rbegin()->second, 0.0};
  if (after == nodes.begin() || after->first == id) return {after->second, after->second, 0.0};
  const auto before = std::prev(after);
  return {before->second, after->second,
          static_cast<double>(id - before->first) / (after->first - before->first)};
}

// What a keyframe's (v, phi) is of a node's.
Eigen::Matrix3d CoarseStep::with(int node, double part, const Eigen::Vector2d& position,
                                 const Poses& known) const {
  const SE3& T = known.at(nodes_[node].robot)[nodes_[node].place];
  Eigen::Matrix3d P = Eigen::Matrix3d::Identity();
  P.block<2, 1>(0, 2) = turned(position - planar(T.translation));
  return part * P;
}

Eigen::Vector3d CoarseStep::step_at(const Share& share, const Eigen::Vector2d& position,
                                    const Poses& known) const {
  return with(share.before, 1.0 - share.part, position, known) *
             step_.segment<kNodeSize>(kNodeSize * share.before) +
         with(share.after, share.part, position, known) * step_.segment<kNodeSize>(kNodeSize * share.after);
}

void CoarseStep::write_gradient(const Lifted& X, const Lifted& gradient, const Poses& known,
                                dpgo_coarse_t& message) const {
  const auto [first, count] = of_robot_.at(problem_.robot());
  Eigen::VectorXd sums = Eigen::VectorXd::Zero(kNodeSize * count);
  for (int k = 0; k < static_cast<int>(own_.size()); ++k) {
    const auto R = X.middleCols<3>(4 * k);
    const auto G = gradient.middleCols<4>(4 * k);
    Eigen::Vector3d g;
    g << G(0, 3), G(1, 3), G.row(1).head<3>().dot(R.row(0)) - G.row(0).head<3>().dot(R.row(1));
    const Share& share = own_[k];
    const Eigen::Vector2d p = position_of(X, k);
    sums.segment<kNodeSize>(kNodeSize * (share.before - first)) +=
        with(share.before, 1.0 - share.part, p, known).transpose() * g;
    sums.segment<kNodeSize>(kNodeSize * (share.after - first)) +=
        with(share.after, share.part, p, known).transpose() * g;
  }
  message.n_gradient = kNodeSize * count;
  message.gradient.resize(message.n_gradient);
  Eigen::Map<Eigen::VectorXf>(message.gradient.data(), sums.size()) = sums.cast<float>();
}

void CoarseStep::write_hessian(const BlockSolver& solver, const Eigen::VectorXd& edge_weights,
                               const Eigen::VectorXd& shared_weights, const Lifted& X, const Poses& known,
                               dpgo_coarse_t& message) const {
  std::map<std::pair<int, int>, Eigen::Matrix3d> H;
  struct End {
    Share share;
    Eigen::Vector2d position;
  };
  // lever: R_from t, in the plane.
  const auto add = [&](const End& from, const End& to, const Eigen::Vector2d& lever, double kappa,
                       double tau) {
    Eigen::Matrix3d of_from = -Eigen::Matrix3d::Identity();
    of_from.block<2, 1>(0, 2) = -turned(lever);
    const Eigen::Vector3d precision(2.0 * tau, 2.0 * tau, 4.0 * kappa);
    std::map<int, Eigen::Matrix3d> J;
    const auto put = [&](const End& end, const Eigen::Matrix3d& of_end) {
      for (const auto& [node, part] :
           {std::pair(end.share.before, 1.0 - end.share.part), std::pair(end.share.after, end.share.part)}) {
        if (part == 0.0) continue;
        const auto [place, fresh] = J.try_emplace(node, Eigen::Matrix3d::Zero());
        place->second += of_end * with(node, part, end.position, known);
      }
    };
    put(from, of_from);
    put(to, Eigen::Matrix3d::Identity());
    for (const auto& [row, J_row] : J) {
      for (const auto& [column, J_column] : J) {
        if (column > row) continue;
        const auto [block, fresh] = H.try_emplace({row, column}, Eigen::Matrix3d::Zero());
        block->second += J_row.transpose() * precision.asDiagonal() * J_column;
      }
    }
  };
  const auto own_end = [&](int pose) { return End{own_[pose], position_of(X, pose)}; };
  for (std::size_t e = 0; e < solver.edges().size(); ++e) {
    const PrivateEdge& edge = solver.edges()[e];
    const double weight = edge_weights[static_cast<Eigen::Index>(e)];
    if (weight == 0.0) continue;
    const Eigen::Vector3d lever = X.block<3, 3>(0, 4 * edge.from) * edge.measurement.translation;
    add(own_end(edge.from), own_end(edge.to), planar(lever), weight * edge.kappa, weight * edge.tau);
  }
  for (std::size_t e = 0; e < solver.shared().size(); ++e) {
    const SharedEdge& edge = solver.shared()[e];
    const SharedLoop& loop = problem_.ends[e];
    const double weight = shared_weights[static_cast<Eigen::Index>(e)];
    if (weight == 0.0 || !problem_.owns(loop)) continue;
    const SE3& theirs = known.at(loop.peer)[loop.peer_place];
    const End mine = own_end(edge.mine);
    const End other{public_.at(loop.peer)[loop.peer_place], planar(theirs.translation)};
    const Eigen::Vector3d lever =
        edge.mine_is_from ? Eigen::Vector3d(X.block<3, 3>(0, 4 * edge.mine) * edge.measurement.translation)
                          : theirs.rotation * edge.measurement.translation;
    add(edge.mine_is_from ? mine : other, edge.mine_is_from ? other : mine, planar(lever),
        weight * edge.kappa, weight * edge.tau);
  }
  for (const auto& [place, block] : H) {
    message.rows.push_back(static_cast<std::int16_t>(place.first));
    message.columns.push_back(static_cast<std::int16_t>(place.second));
    for (int k = 0; k < 9; ++k) message.values.push_back(static_cast<float>(block(k / 3, k % 3)));
  }
  message.n_blocks = static_cast<std::int32_t>(message.rows.size());
  message.n_values = static_cast<std::int32_t>(message.values.size());
}

bool CoarseStep::fits(int robot, const dpgo_coarse_t& message) const {
  const auto n = static_cast<std::size_t>(message.n_blocks);
  const auto n_gradient = static_cast<std::size_t>(kNodeSize * of_robot_.at(robot).second);
  if (message.gradient.size() != n_gradient || message.rows.size() != n || message.columns.size() != n ||
      message.values.size() != 9 * n)
    return false;
  for (std::size_t k = 0; k < n; ++k) {
    if (message.columns[k] < 0 || message.columns[k] > message.rows[k] ||
        message.rows[k] >= static_cast<int>(nodes_.size()))
      return false;
  }
  return n > 0 || hessians_.contains(robot);
}

// Rounded, so that all take the same step though their machines may differ in the last bits.
bool CoarseStep::solve(const std::map<int, const dpgo_coarse_t*>& messages) {
  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(step_.size(), step_.size());
  Eigen::VectorXd g = Eigen::VectorXd::Zero(step_.size());
  for (const auto& [robot, message] : messages) {
    auto& hessian = hessians_[robot];
    if (message->n_blocks > 0) hessian.clear();
    for (int k = 0; k < message->n_blocks; ++k) {
      hessian[{message->rows[k], message->columns[k]}] =
          Eigen::Map<const Eigen::Matrix<float, 3, 3, Eigen::RowMajor>>(message->values.data() + 9 * k)
              .cast<double>();
    }
    for (const auto& [place, block] : hessian)
      H.block<3, 3>(kNodeSize * place.first, kNodeSize * place.second) += block;
    g.segment(kNodeSize * of_robot_.at(robot).first, message->n_gradient) =
        Eigen::Map<const Eigen::VectorXf>(message->gradient.data(), message->n_gradient).cast<double>();
  }
  H.diagonal() *= 1.0 + kLeastStiffness;
  const Eigen::Index left = step_.size() - kNodeSize;  // the first node stays
  const Eigen::LLT<Eigen::MatrixXd> factor(H.bottomRightCorner(left, left));
  step_.setZero();
  if (factor.info() != Eigen::Success) return false;
  step_.tail(left) = -factor.solve(g.tail(left)).cast<float>().cast<double>();
  return step_.allFinite();
}

void CoarseStep::move(const Poses& known, Lifted& own) const {
  for (int k = 0; k < static_cast<int>(own_.size()); ++k) {
    const Eigen::Vector3d step = step_at(own_[k], position_of(own, k), known);
    const SE3 pose{SO3::from_matrix(own.middleCols<3>(4 * k)), own.col(4 * k + 3)};
    own.middleCols<4>(4 * k) = lift(moved_by(step, pose), static_cast<int>(own.rows()));
  }
}

void CoarseStep::move(const Poses& known, int robot, std::vector<SE3>& poses) const {
  const std::vector<Share>& shares = public_.at(robot);
  for (std::size_t k = 0; k < poses.size(); ++k)
    poses[k] = moved_by(step_at(shares[k], planar(poses[k].translation), known), poses[k]);
}

}  // namespace covey::pgo
