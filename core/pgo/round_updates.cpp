// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/round_updates.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/base/error.h"
#include "core/pgo/tls.h"

namespace covey::pgo {
namespace {

// Nothing leaves the rotations that rounds start from for a higher rank: their gradient has no part there.
constexpr int kRank = 3;
constexpr double kBeyondSense = 1e12;     // of a squared residual: kilometres in millimetres
constexpr double kRounding = 1e-6;        // of costs as they are said
constexpr double kShortestSum = 0.1;      // of quaternions, to be one
constexpr double kBetweenSegments = 1e6;  // keyframes
constexpr double kLastPart = 0.1;         // of what rounding may cost, when weights are binary
constexpr int kUpdatesPerCoarseStep = 5;
constexpr double kMostUnits = 256.0;  // to a root mean square of what is to be said

Lifted lift_all(const std::vector<SE3>& poses) {
  Lifted X(kRank, 4 * static_cast<Eigen::Index>(poses.size()));
  for (std::size_t k = 0; k < poses.size(); ++k)
    X.middleCols<4>(4 * static_cast<Eigen::Index>(k)) = lift(poses[k], kRank);
  return X;
}

std::vector<SE3> poses_of(const Lifted& X) {
  std::vector<SE3> poses;
  for (Eigen::Index k = 0; k < X.cols(); k += 4)
    poses.push_back({SO3::from_matrix(X.middleCols<3>(k)), X.col(k + 3)});
  return poses;
}

Lifted combination(const std::deque<Lifted>& results, const std::vector<double>& coefficients) {
  Lifted sum = coefficients[0] * results[0];
  for (std::size_t k = 1; k < coefficients.size(); ++k) sum += coefficients[k] * results[k];
  return sum;
}

// Of poses that all robots have to combine alike: in single precision, so that what machines compute differently in the last
// bits does not add up.
std::vector<SE3> combination(const std::deque<std::vector<SE3>>& results,
                             const std::vector<double>& coefficients) {
  std::vector<SE3> poses = results.front();
  if (coefficients.size() == 1) return poses;
  for (std::size_t p = 0; p < poses.size(); ++p) {
    const Eigen::Vector4d newest = poses[p].rotation.quaternion().coeffs();
    Eigen::Vector4d q = Eigen::Vector4d::Zero();
    Eigen::Vector3d t = Eigen::Vector3d::Zero();
    for (std::size_t k = 0; k < coefficients.size(); ++k) {
      const Eigen::Vector4d other = results[k][p].rotation.quaternion().coeffs();
      q += (other.dot(newest) < 0.0 ? -coefficients[k] : coefficients[k]) * other;
      t += coefficients[k] * results[k][p].translation;
    }
    if (q.norm() < kShortestSum) continue;
    poses[p].rotation = SO3::from_quaternion(Eigen::Quaterniond(q.cast<float>().cast<double>()));
    poses[p].translation = t.cast<float>().cast<double>();
  }
  return poses;
}

// Finer ones would say in many digits what the next update may say in few.
PoseUnits finest_units(const std::vector<SE3>& expected, const std::vector<SE3>& wanted,
                       const std::vector<bool>& chosen) {
  PoseUnits sum;
  double n = 1e-9;
  for (std::size_t k = 0; k < chosen.size(); ++k) {
    if (!chosen[k]) continue;
    const Lifted left = lift(wanted[k], kRank) - lift(expected[k], kRank);
    sum.rotation += 0.5 * left.leftCols<3>().squaredNorm();  // |R Exp(phi) - R|_F^2 = 2 |phi|^2
    sum.translation += left.col(3).squaredNorm();
    n += 1.0;
  }
  return {std::sqrt(sum.rotation / n) / kMostUnits, std::sqrt(sum.translation / n) / kMostUnits};
}

// Where a robot's public keyframes are on its trajectory; segments are far from each other.
std::vector<double> places_along(const OpenedMember& member) {
  std::vector<double> along(member.T_S_K.size(), 0.0);
  for (const auto& [name, place] : member.places) along[place] = kBetweenSegments * name.first + name.second;
  return along;
}

template <typename T>
void push(T value, std::size_t most, std::deque<T>& newest_first) {
  newest_first.push_front(std::move(value));
  if (newest_first.size() > most) newest_first.pop_back();
}

double largest(const Eigen::VectorXd& r2) { return r2.size() == 0 ? 0.0 : r2.maxCoeff(); }

}  // namespace

RoundUpdates::RoundUpdates(const AgreedProblem& problem, const DgncOptions& options)
    : problem_(problem), options_(options), stages_(options), anderson_(options.look_back) {
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
  results_ = {lift_all(problem.own_start())};
  for (const int robot : problem.part) {
    const std::vector<SE3> start = problem.public_start(robot);
    Keyframes sent{start, StepCode(places_along(problem.members.at(robot)))};
    members_.emplace(robot, Member{std::move(sent), {}, {start}, start, {}});
  }
  private_weights_ = Eigen::VectorXd::Ones(static_cast<Eigen::Index>(problem.graph.private_loops.size()));
  shared_weights_ = Eigen::VectorXd::Ones(static_cast<Eigen::Index>(shared.size()));
  if (options.robust && options.alignment.dimension == 2 && options.look_back > 1) {
    coarse_.emplace(problem);
    if (!coarse_->useful()) coarse_.reset();
  }
  solver_ = std::make_unique<BlockSolver>(problem.graph.poses(), kRank, std::move(edges), std::move(shared),
                                          options.block);
}

Eigen::VectorXd RoundUpdates::private_residuals(const Lifted& X) const {
  return solver_->edge_residuals(X).tail(private_weights_.size());
}

// Where the update begins, from poses as sent, which both ends know.
Eigen::VectorXd RoundUpdates::shared_residuals() const {
  Eigen::VectorXd r2(shared_weights_.size());
  for (std::size_t e = 0; e < problem_.ends.size(); ++e) {
    const SharedLoop& end = problem_.ends[e];
    const SharedEdge& edge = solver_->shared()[e];
    const Lifted difference = my_side(edge, lift(members_.at(problem_.robot()).ahead[end.my_place], kRank)) -
                              other_side(edge, lift(members_.at(end.peer).ahead[end.peer_place], kRank));
    r2[static_cast<Eigen::Index>(e)] = weighted_square(difference, edge.kappa, edge.tau);
  }
  return r2;
}

void RoundUpdates::send_first(RoundMail& mail) const {
  auto m = mail.compose<dpgo_advance_t>();
  // One loop without any sense must not make this message one that the others refuse, nor mu so small that no loop weighs
  // anything and robots float.
  m.max_residual_sq = static_cast<float>(std::min(largest_open_residual(), kBeyondSense));
  mail.send(std::move(m));
}

// Loops by which a robot has just solved their segment, unbent since, are decided: they need no surrogate that is convex where
// they are.
double RoundUpdates::largest_open_residual() const {
  double largest_r2 = largest(shared_residuals());
  const Eigen::VectorXd r2 = private_residuals(results_.front());
  for (Eigen::Index e = 0; e < r2.size(); ++e) {
    const GraphLoop& loop = problem_.graph.private_loops[e];
    const bool decided = options_.robust && options_.local_start && !problem_.bent &&
                         loop.a.segment == loop.b.segment &&
                         problem_.starts[problem_.segment_place(loop.a.segment)].solution == 0;
    if (!decided) largest_r2 = std::max(largest_r2, r2[e]);
  }
  return largest_r2;
}

bool RoundUpdates::fits(int robot, const RoundMessage& message) {
  if (coarse_phase_ == Coarse::kAsked) {
    const auto* coarse = std::get_if<dpgo_coarse_t>(&message);
    return coarse != nullptr && coarse_->fits(robot, *coarse);
  }
  const auto* step = std::get_if<dpgo_advance_t>(&message);
  if (step == nullptr || step->products.size() + 1 != std::max<std::size_t>(1, steps_.size())) return false;
  Member& member = members_.at(robot);
  member.next = member.sent;
  if (!member.next->code.add(*step, member.ahead, member.next->poses)) member.next.reset();
  return member.next.has_value();
}

bool RoundUpdates::advance(RoundMail& mail) {
  if (coarse_phase_ == Coarse::kAsked) {
    take_coarse_step(mail);
    send_update(mail);
    return true;
  }
  TeamUpdate team;
  for (const int robot : problem_.part) {
    const auto& m = mail.from<dpgo_advance_t>(robot);
    Member& member = members_.at(robot);
    COVEY_CHECK(member.next.has_value());
    member.sent = *std::exchange(member.next, std::nullopt);
    push(member.sent.poses, options_.look_back + 1, member.results);
    member.said = m;
    team.cost += m.cost;
    team.decrease += m.decrease;
    team.gradient_sq += m.gradient_sq;
    team.penalty += m.penalty;
    team.undecided += m.undecided;
  }
  const bool worse = team.cost > (1.0 + kRounding) * cost_;
  if (worse) {
    take_back();
    team.decrease = team.cost;  // so nothing has converged
  }
  if (stages_.ended(team)) {
    if (updates_ > 0) note_stage(team, mail.bytes());
    if (!stages_.begin(team, first_mu())) return false;
    begin_anew();
    coarse_phase_ = Coarse::kNone;
    hessian_due_ = true;
  } else if (!worse) {
    accelerate(team);
    coarse_phase_ = coarse_phase_ == Coarse::kTaken ? Coarse::kNone : coarse_phase_;
  }
  if (wants_coarse_step()) {
    ask_coarse_step(mail);
  } else {
    send_update(mail);
  }
  return true;
}

void RoundUpdates::send_update(RoundMail& mail) {
  auto m = mail.compose<dpgo_advance_t>();
  update(m);
  encode_public_poses(m);
  mail.send(std::move(m));
}

bool RoundUpdates::wants_coarse_step() const {
  const bool few = options_.total_updates > 0;
  return coarse_ && stages_.binary() && coarse_phase_ == Coarse::kNone &&
         stages_.stage_updates() >= (few ? 1 : options_.coarse_after) &&
         stages_.stage_updates() % (few ? 1 : kUpdatesPerCoarseStep) == 0;
}

CoarseStep::Poses RoundUpdates::newest_public() const {
  CoarseStep::Poses poses;
  for (const auto& [robot, member] : members_) poses[robot] = member.results.front();
  return poses;
}

void RoundUpdates::ask_coarse_step(RoundMail& mail) {
  coarse_phase_ = Coarse::kAsked;
  auto m = mail.compose<dpgo_coarse_t>();
  for (auto& [robot, member] : members_) member.ahead = member.results.front();
  const Lifted& X = results_.front();
  const CoarseStep::Poses known = newest_public();
  coarse_->write_gradient(X, solver_->riemannian_gradient(targets(), X), known, m);
  if (hessian_due_) coarse_->write_hessian(*solver_, edge_weights(), shared_weights_, X, known, m);
  hessian_due_ = false;
  mail.send(std::move(m));
}

void RoundUpdates::take_coarse_step(const RoundMail& mail) {
  coarse_phase_ = Coarse::kUseless;
  std::map<int, const dpgo_coarse_t*> messages;
  for (const int robot : problem_.part) messages[robot] = &mail.from<dpgo_coarse_t>(robot);
  if (!coarse_->solve(messages)) return;
  coarse_phase_ = Coarse::kTaken;
  const CoarseStep::Poses known = newest_public();
  Lifted X = results_.front();
  coarse_->move(known, X);
  push(std::move(X), options_.look_back + 1, results_);
  for (auto& [robot, member] : members_) {
    coarse_->move(known, robot, member.sent.poses);
    push(member.sent.poses, options_.look_back + 1, member.results);
  }
  anderson_.restart();
  steps_.clear();
}

// The team's largest residual says where the surrogate is convex. A start that all left unfinished at the same place goes
// on at the mu that it had (the lowest, as they may be one update apart).
double RoundUpdates::first_mu() const {
  double max_r2 = 0.0;
  double left_at = problem_.frames.unmoved() ? std::numeric_limits<double>::infinity() : 0.0;
  for (const int robot : problem_.part) {
    const dpgo_join_t& join = problem_.members.at(robot).join;
    max_r2 = std::max(max_r2, static_cast<double>(members_.at(robot).said.max_residual_sq));
    left_at = std::min(left_at, join.mu);
  }
  return left_at > 0.0 ? left_at : tls_first_mu(max_r2, options_.barc2);
}

void RoundUpdates::set_weights(const Lifted& X) {
  undecided_ = 0;
  penalty_ = 0.0;
  const auto weigh = [&](const GraphLoop& loop, bool owned, double r2, double& weight) {
    if (loop.known_inlier) return;
    const double next = stages_.weight(r2);
    if (owned && stages_.undecided(next, weight)) ++undecided_;
    if (owned) penalty_ += stages_.penalty(next);
    weight = next;
  };
  if (options_.robust) {
    const Eigen::VectorXd private_r2 = private_residuals(X);
    for (Eigen::Index e = 0; e < private_r2.size(); ++e)
      weigh(problem_.graph.private_loops[e], true, private_r2[e], private_weights_[e]);
    const Eigen::VectorXd shared_r2 = shared_residuals();
    for (Eigen::Index e = 0; e < shared_r2.size(); ++e)
      weigh(problem_.ends[e].loop, problem_.owns(problem_.ends[e]), shared_r2[e], shared_weights_[e]);
  }
  solver_->set_weights(edge_weights(), 2.0 * shared_weights_);  // 2: of the majorisation
}

Eigen::VectorXd RoundUpdates::edge_weights() const {
  Eigen::VectorXd weights = Eigen::VectorXd::Ones(odometry_edges_ + private_weights_.size());
  weights.tail(private_weights_.size()) = private_weights_;
  return weights;
}

// Everybody combines the last updates by the same numbers, from products that all have summed.
void RoundUpdates::accelerate(const TeamUpdate& team) {
  cost_ = stages_.mu_rose() ? std::numeric_limits<double>::infinity() : team.cost;
  std::vector<double> products(anderson_.steps() + 1, 0.0);
  for (const auto& [robot, member] : members_) {
    const std::vector<float>& below = member.said.products;
    for (std::size_t k = 0; k < products.size() && k <= below.size(); ++k)
      products[k] += member.said.step_sq - (k == 0 ? 0.0 : static_cast<double>(below[k - 1]));
  }
  anderson_.add(products);
}

// Steps under other weights, or that have been taken back, say nothing of those to come.
void RoundUpdates::begin_anew() {
  anderson_.restart();
  steps_.clear();
  cost_ = std::numeric_limits<double>::infinity();
}

void RoundUpdates::take_back() {
  begin_anew();
  const bool coarse = coarse_phase_ == Coarse::kTaken;
  if (coarse) coarse_phase_ = Coarse::kUseless;
  for (int updates = coarse ? 2 : 1; updates > 0; --updates) {
    results_.pop_front();
    for (auto& [robot, member] : members_) member.results.pop_front();
  }
}

void RoundUpdates::note_stage(const TeamUpdate& team, std::int64_t bytes_sent) {
  StageResult stage;
  stage.mu = stages_.binary() ? std::numeric_limits<double>::infinity() : stages_.mu();
  stage.updates = updates_;
  stage.bytes = bytes_sent;
  for (const StageResult& before : stage_results_) {
    stage.updates -= before.updates;
    stage.bytes -= before.bytes;
  }
  stage.cost = team.cost;
  stage.gradient = std::sqrt(team.gradient_sq);
  const auto count = [&stage](double weight) {
    ++(weight == 1.0 ? stage.weights_one : weight == 0.0 ? stage.weights_zero : stage.weights_between);
  };
  for (const double weight : private_weights_) count(weight);
  for (std::size_t e = 0; e < problem_.ends.size(); ++e) {
    if (problem_.owns(problem_.ends[e])) count(shared_weights_[static_cast<Eigen::Index>(e)]);
  }
  stage_results_.push_back(stage);
}

void RoundUpdates::update(dpgo_advance_t& m) {
  const std::vector<double> blend = anderson_.coefficients();
  for (auto& [robot, member] : members_) member.ahead = combination(member.results, blend);
  Lifted X = results_.front();
  if (blend.size() > 1) X = retract(X, combination(results_, blend) - X);
  if (stages_.weighs()) set_weights(X);
  const Lifted fixed = targets();
  Step step{X, solver_->riemannian_gradient(fixed, X)};
  const BlockStep solved = solver_->minimise(fixed, X);
  step.moved = X - step.moved;
  m.cost = static_cast<float>(solved.cost_before + penalty_);
  m.penalty = static_cast<float>(penalty_);
  m.decrease = static_cast<float>(solved.cost_before - solved.cost_after);
  m.gradient_sq = static_cast<float>(solved.gradient_before * solved.gradient_before);
  m.undecided = undecided_;
  push(std::move(X), options_.look_back + 1, results_);
  remember(std::move(step), m);
  ++updates_;
  stages_.count_update();
}

// The sides of shared loops, halfway between those of the two robots.
Lifted RoundUpdates::targets() const {
  const std::vector<SE3>& mine = members_.at(problem_.robot()).ahead;
  Lifted targets(kRank, 4 * static_cast<Eigen::Index>(problem_.ends.size()));
  for (std::size_t e = 0; e < problem_.ends.size(); ++e) {
    const SharedLoop& end = problem_.ends[e];
    const SharedEdge& edge = solver_->shared()[e];
    targets.middleCols<4>(4 * static_cast<Eigen::Index>(e)) =
        0.5 * (my_side(edge, lift(mine[end.my_place], kRank)) +
               other_side(edge, lift(members_.at(end.peer).ahead[end.peer_place], kRank)));
  }
  return targets;
}

// Steps are much alike, and what counts is by how much they differ: that is said in single precision.
void RoundUpdates::remember(Step step, dpgo_advance_t& m) {
  push(std::move(step), options_.look_back + 1, steps_);
  const auto product = [this](std::size_t k) {
    return -0.5 * (steps_[0].moved.cwiseProduct(steps_[k].gradient).sum() +
                   steps_[k].moved.cwiseProduct(steps_[0].gradient).sum());
  };
  m.step_sq = product(0);
  for (std::size_t k = 1; k < steps_.size(); ++k)
    m.products.push_back(static_cast<float>(m.step_sq - product(k)));
  m.n_products = static_cast<std::int8_t>(m.products.size());
}

void RoundUpdates::encode_public_poses(dpgo_advance_t& m) const {
  Lifted own(kRank, 4 * static_cast<Eigen::Index>(problem_.public_index.size()));
  for (std::size_t k = 0; k < problem_.public_index.size(); ++k)
    own.middleCols<4>(4 * static_cast<Eigen::Index>(k)) =
        results_.front().middleCols<4>(4 * problem_.public_index[k]);
  const std::vector<SE3> wanted = poses_of(own);
  const std::vector<bool> chosen = poses_to_send(wanted);
  const Member& self = members_.at(problem_.robot());
  self.sent.code.encode(self.ahead, wanted, chosen, units_for(m.decrease, wanted, chosen), m);
}

// Rounding to units u_t and u_R has a variance of u^2 / 12 in each axis. It moves the sides of the shared loops and so costs
// sum w (tau u_t^2 / 4 + (kappa / 2 + tau |t|^2 / 6) u_R^2), of which either part may be half of what there is to spend.
PoseUnits RoundUpdates::units_for(double gain, const std::vector<SE3>& wanted,
                                  const std::vector<bool>& chosen) const {
  double per_translation = 1e-12;
  double per_rotation = 1e-12;
  for (std::size_t e = 0; e < problem_.ends.size(); ++e) {
    const SharedEdge& edge = solver_->shared()[e];
    const double lever_sq = edge.mine_is_from ? edge.measurement.translation.squaredNorm() : 0.0;
    per_translation += shared_weights_[e] * edge.tau / 4.0;
    per_rotation += shared_weights_[e] * (edge.kappa / 2.0 + edge.tau * lever_sq / 6.0);
  }
  const double part = stages_.binary() ? kLastPart * options_.rounding : options_.rounding;
  const double spent = 0.5 * part * std::max(0.0, gain);
  const PoseUnits finest = finest_units(members_.at(problem_.robot()).ahead, wanted, chosen);
  return {std::max(std::sqrt(spent / per_rotation), finest.rotation),
          std::max(std::sqrt(spent / per_translation), finest.translation)};
}

// A loop of weight 0 stays so while its residual, as both ends know it, is beyond the limit: a pose may keep back what moves
// that residual by less than a quarter of the way there, as may the pose at the other end.
std::vector<bool> RoundUpdates::poses_to_send(const std::vector<SE3>& wanted) const {
  const std::vector<SE3>& sent = members_.at(problem_.robot()).sent.poses;
  std::vector<bool> send(sent.size(), false);
  if (problem_.robot() == problem_.anchor()) send[problem_.root_place()] = true;
  const Eigen::VectorXd r2 = shared_residuals();
  const double limit = stages_.rejection();
  for (std::size_t e = 0; e < problem_.ends.size(); ++e) {
    const int k = problem_.ends[e].my_place;
    if (send[k]) continue;
    if (shared_weights_[e] > 0.0) {
      send[k] = true;
      continue;
    }
    const SharedEdge& edge = solver_->shared()[e];
    const double moved = std::sqrt(weighted_square(
        my_side(edge, lift(wanted[k], kRank)) - my_side(edge, lift(sent[k], kRank)), edge.kappa, edge.tau));
    send[k] = moved > 0.25 * (std::sqrt(r2[e]) - std::sqrt(limit));
  }
  return send;
}

// Everything as seen from the root.
RoundSolution RoundUpdates::solution() const {
  const SE3 T_root = members_.at(problem_.anchor()).results.front()[problem_.root_place()].inverse();
  const auto from_root = [&](std::vector<SE3> poses) {
    for (SE3& T : poses) T = T_root * T;
    return poses;
  };
  RoundSolution solution;
  solution.T_root_K = from_root(poses_of(results_.front()));
  for (const auto& [robot, member] : members_)
    solution.T_root_K_public[robot] = from_root(member.results.front());
  solution.private_weights = private_weights_;
  solution.shared_weights = shared_weights_;
  return solution;
}

}  // namespace covey::pgo
