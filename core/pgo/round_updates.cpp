// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/round_updates.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "core/pgo/public_poses.h"
#include "core/pgo/tls.h"

namespace covey::pgo {
namespace {

Lifted lift_all(const std::vector<SE3>& poses, int rank) {
  Lifted X(rank, 4 * static_cast<Eigen::Index>(poses.size()));
  for (std::size_t k = 0; k < poses.size(); ++k)
    X.middleCols<4>(4 * static_cast<Eigen::Index>(k)) = lift(poses[k], rank);
  return X;
}

std::vector<SE3> round_all(const Lifted& X_root, const Lifted& X) {
  std::vector<SE3> poses;
  for (Eigen::Index k = 0; k < X.cols(); k += 4) poses.push_back(round_to_pose(X_root, X.middleCols<4>(k)));
  return poses;
}

double largest(const Eigen::VectorXd& r2) { return r2.size() == 0 ? 0.0 : r2.maxCoeff(); }

}  // namespace

RoundUpdates::RoundUpdates(const AgreedProblem& problem, const DgncOptions& options)
    : problem_(problem), options_(options), stages_(options) {
  std::vector<PrivateEdge> edges;
  for (std::size_t s = 0; s < problem.graph.segments.size(); ++s) {
    const auto& poses = problem.graph.segments[s].poses;
    for (std::size_t k = 1; k < poses.size(); ++k) {
      const int to = problem.offsets[s] + static_cast<int>(k);
      edges.push_back({to - 1, to, poses[k].T_P_K, poses[k].precision.kappa, poses[k].precision.tau});
    }
  }
  odometry_edges_ = static_cast<int>(edges.size());
  for (const GraphLoop& loop : problem.graph.private_loops) {
    edges.push_back({problem.pose_index(loop.a), problem.pose_index(loop.b), loop.T_A_B, loop.precision.kappa,
                     loop.precision.tau});
  }
  std::vector<SharedEdge> shared;
  for (const SharedLoop& end : problem.ends) {
    shared.push_back({problem.public_index[end.my_place], end.loop.a.robot == problem.robot(), end.loop.T_A_B,
                      end.loop.precision.kappa, end.loop.precision.tau});
  }
  X_ = lift_all(problem.own_start(), options.rank);
  X_before_ = X_;
  for (const int robot : problem.part) {
    Member& member = members_[robot];
    member.now = lift_all(problem.public_start(robot), options.rank);
    member.before = member.now;
  }
  private_weights_ = Eigen::VectorXd::Ones(static_cast<Eigen::Index>(problem.graph.private_loops.size()));
  shared_weights_ = Eigen::VectorXd::Ones(static_cast<Eigen::Index>(shared.size()));
  solver_ = std::make_unique<BlockSolver>(problem.graph.poses(), options.rank, std::move(edges),
                                          std::move(shared), options.block);
}

Eigen::VectorXd RoundUpdates::private_residuals() const {
  return solver_->edge_residuals(X_).tail(private_weights_.size());
}

// From the poses as sent, which both ends know.
Eigen::VectorXd RoundUpdates::shared_residuals() const {
  Eigen::VectorXd r2(shared_weights_.size());
  for (std::size_t e = 0; e < problem_.ends.size(); ++e) {
    const SharedLoop& end = problem_.ends[e];
    const SharedEdge& edge = solver_->shared()[e];
    const Lifted difference =
        my_side(edge, members_.at(problem_.robot()).now.middleCols<4>(4 * end.my_place)) -
        other_side(edge, members_.at(end.peer).now.middleCols<4>(4 * end.peer_place));
    r2[static_cast<Eigen::Index>(e)] = weighted_square(difference, edge.kappa, edge.tau);
  }
  return r2;
}

void RoundUpdates::send_first(RoundMail& mail) const {
  auto m = mail.compose<dpgo_update_t>();
  // One loop without any sense must not make this message one that the others refuse: nobody would go on.
  m.max_residual_sq =
      std::min(std::max(largest(private_residuals()), largest(shared_residuals())), 0.5 * kLargestResidualSq);
  mail.send(std::move(m));
}

bool RoundUpdates::fits(int robot, const RoundMessage& message) const {
  const auto* update = std::get_if<dpgo_update_t>(&message);
  return update != nullptr && pgo::fits(*update, members_.at(robot).now);
}

bool RoundUpdates::advance(RoundMail& mail) {
  for (const int robot : problem_.part) {
    const auto& m = mail.from<dpgo_update_t>(robot);
    Member& member = members_[robot];
    member.before = member.now;
    add_differences(m, member.now);
    member.cost = m.cost;
    member.decrease = m.decrease;
    member.overshoot = m.overshoot;
    member.max_r2 = m.max_residual_sq;
    member.undecided = m.undecided;
  }
  const TeamUpdate team = team_update();
  if (stages_.ended(team)) {
    if (!stages_.begin(team, first_mu())) return false;
    momentum_.restart();
    set_weights();
  }
  auto m = mail.compose<dpgo_update_t>();
  update(m);
  encode_public_poses(m);
  mail.send(std::move(m));
  return true;
}

TeamUpdate RoundUpdates::team_update() const {
  TeamUpdate team;
  for (const auto& [robot, member] : members_) {
    team.cost += member.cost;
    team.decrease += member.decrease;
    team.undecided += member.undecided;
  }
  return team;
}

// The team's largest residual says where the surrogate is convex. A start that all left unfinished at the same place goes
// on at the mu that it had (the lowest, as they may be one update apart).
double RoundUpdates::first_mu() const {
  double max_r2 = 0.0;
  double left_at = problem_.frames.unmoved() ? std::numeric_limits<double>::infinity() : 0.0;
  for (const int robot : problem_.part) {
    const dpgo_join_t& join = problem_.members.at(robot).join;
    max_r2 = std::max(max_r2, members_.at(robot).max_r2);
    left_at = std::min(left_at, join.mu);
  }
  return left_at > 0.0 ? left_at : tls_first_mu(max_r2, options_.barc2);
}

void RoundUpdates::set_weights() {
  undecided_ = 0;
  const auto weigh = [&](const GraphLoop& loop, bool owned, double r2, double& weight) {
    if (loop.known_inlier) return;
    const double next = stages_.weight(r2);
    if (owned && stages_.undecided(next, weight)) ++undecided_;
    weight = next;
  };
  if (options_.robust) {
    const Eigen::VectorXd private_r2 = private_residuals();
    for (Eigen::Index e = 0; e < private_r2.size(); ++e)
      weigh(problem_.graph.private_loops[e], true, private_r2[e], private_weights_[e]);
    const Eigen::VectorXd shared_r2 = shared_residuals();
    for (Eigen::Index e = 0; e < shared_r2.size(); ++e)
      weigh(problem_.ends[e].loop, problem_.owns(problem_.ends[e]), shared_r2[e], shared_weights_[e]);
  }
  Eigen::VectorXd edge_weights = Eigen::VectorXd::Ones(odometry_edges_ + private_weights_.size());
  edge_weights.tail(private_weights_.size()) = private_weights_;
  solver_->set_weights(edge_weights, 2.0 * shared_weights_);  // 2: of the majorisation
}

void RoundUpdates::update(dpgo_update_t& m) {
  double overshoot = 0.0;
  for (const auto& [robot, member] : members_) overshoot += member.overshoot;
  if (overshoot > 0.0) momentum_.restart();
  const double beta = options_.momentum ? momentum_.next() : 0.0;

  const auto ahead = [&](int robot, int place) -> Lifted {
    const Member& member = members_.at(robot);
    const auto now = member.now.middleCols<4>(4 * place);
    return now + beta * (now - member.before.middleCols<4>(4 * place));
  };
  Lifted targets(options_.rank, 4 * static_cast<int>(problem_.ends.size()));
  for (std::size_t e = 0; e < problem_.ends.size(); ++e) {
    const SharedLoop& end = problem_.ends[e];
    const SharedEdge& edge = solver_->shared()[e];
    targets.middleCols<4>(4 * static_cast<int>(e)) =
        0.5 * (my_side(edge, ahead(problem_.robot(), end.my_place)) +
               other_side(edge, ahead(end.peer, end.peer_place)));
  }
  const Lifted ahead_of_X = beta == 0.0 ? X_ : retract(X_, beta * (X_ - X_before_));
  const Lifted gradient = solver_->riemannian_gradient(targets, ahead_of_X);
  Lifted next = ahead_of_X;
  const BlockStep step = solver_->minimise(targets, next);
  const Lifted moved = next - X_;
  m.cost = static_cast<float>(step.cost_before);
  m.decrease = static_cast<float>(step.cost_before - step.cost_after);
  m.overshoot = beta == 0.0 ? 0.0F : static_cast<float>(gradient.cwiseProduct(moved).sum());
  m.undecided = undecided_;
  gradient_ = step.gradient_before;
  X_before_ = std::exchange(X_, std::move(next));
  ++updates_;
  stages_.count_update();
}

void RoundUpdates::encode_public_poses(dpgo_update_t& m) const {
  Lifted wanted(options_.rank, 4 * static_cast<int>(problem_.public_index.size()));
  for (int k = 0; k < static_cast<int>(problem_.public_index.size()); ++k) {
    wanted.middleCols<4>(4 * k) = X_.middleCols<4>(4 * problem_.public_index[k]);
  }
  encode_differences(wanted - members_.at(problem_.robot()).now, m);
}

RoundSolution RoundUpdates::solution() const {
  const Lifted X_root = members_.at(problem_.anchor()).now.middleCols<4>(4 * problem_.root_place());
  RoundSolution solution;
  solution.T_root_K = round_all(X_root, X_);
  for (const auto& [robot, member] : members_)
    solution.T_root_K_public[robot] = round_all(X_root, member.now);
  solution.private_weights = private_weights_;
  solution.shared_weights = shared_weights_;
  return solution;
}

}  // namespace covey::pgo
