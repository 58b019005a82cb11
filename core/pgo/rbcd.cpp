// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/rbcd.h"

#include <algorithm>
#include <cmath>
#include <covey/dpgo_start_t.hpp>
#include <deque>
#include <random>
#include <utility>

#include "core/base/error.h"
#include "core/pgo/extrapolation.h"
#include "core/pgo/public_poses.h"
#include "core/pgo/robot_blocks.h"

namespace covey::pgo {
namespace {

// A message of n numbers that are not poses, as the other dpgo messages: fingerprint, utime, from, to, round, anchor, number, n.
std::int64_t encoded_numbers(std::int64_t n) { return 8 + 8 + 4 + 4 + 8 + 4 + 4 + 4 + 8 * n; }

// A block's public poses at the start with the figures that a message has; from then on its robot means these, too.
std::vector<SE3> send_start(const RobotBlock& block, const Poses& start, std::int64_t& bytes) {
  std::vector<double> values;
  for (const int k : block.public_poses) append_pose(start[block.first + k], values);
  dpgo_start_t message{};
  message.n = static_cast<std::int32_t>(block.public_poses.size());
  message.ids = block.public_poses;
  message.segments.resize(block.public_poses.size());
  message.T_S_K.assign(values.begin(), values.end());
  message.n_values = static_cast<std::int32_t>(values.size());
  bytes += message.getEncodedSize();
  std::vector<SE3> sent;
  for (int k = 0; k < message.n; ++k) sent.push_back(pose_at(message.T_S_K, k));
  return sent;
}

class Team {
 public:
  Team(const PoseGraph& graph, const Poses& start, const RbcdOptions& options);

  // Takes one block update, and what follows it. False when there is nothing more to do.
  bool advance();
  RbcdResult result() const;

 private:
  int size() const { return static_cast<int>(blocks_.size()); }
  bool asynchronous() const { return options_.schedule == Schedule::kAsynchronous; }
  int next_block();
  void update(int b);
  void accelerate();
  double cost_at(const std::vector<Lifted>& X, const std::vector<Lifted>& said) const;
  std::vector<Lifted> public_parts(const std::vector<Lifted>& X) const;
  const std::vector<Lifted>& known_to(int b);
  void tell_gradient(int b);
  int watched() const { return size() + (asynchronous() ? options_.max_delay : 0); }  // updates
  bool settled() const;
  Poses rounded() const;
  std::int64_t bytes_sent() const;
  int rounds() const;

  RbcdOptions options_;
  SE3 T_W_first_;
  std::vector<RobotBlock> blocks_;
  std::vector<int> order_;  // of coloured and round-robin updates
  std::vector<int> colours_;
  std::mt19937_64 random_;

  std::vector<Lifted> X_;                 // of each block
  std::vector<Lifted> said_;              // public poses of each block as all others have them
  std::deque<std::vector<Lifted>> past_;  // said_ before the last updates, newest first; asynchronous
  std::vector<Lifted> known_;             // what known_to() found
  std::vector<double> gradients_;         // norms as told; greedy

  std::vector<Lifted> round_start_;                // X_ when the round began
  std::deque<std::vector<Lifted>> displacements_;  // of earlier rounds, newest first
  std::deque<double> costs_;                       // after each of the last updates, newest first
  RbcdResult evidence_;
};

Team::Team(const PoseGraph& graph, const Poses& start, const RbcdOptions& options)
    : options_(options),
      blocks_(split_into_blocks(graph, options.rank, options.block)),
      random_(options.seed) {
  COVEY_CHECK(static_cast<int>(start.size()) == graph.poses() && !blocks_.empty());
  T_W_first_ = start.front();
  for (const RobotBlock& block : blocks_) {
    Lifted X(options.rank, 4 * block.solver.poses());
    for (int k = 0; k < block.solver.poses(); ++k)
      X.middleCols<4>(4 * k) = lift(start[block.first + k], options.rank);
    const std::vector<SE3> sent = send_start(block, start, evidence_.bytes["start"]);
    for (std::size_t k = 0; k < sent.size(); ++k)
      X.middleCols<4>(4 * block.public_poses[k]) = lift(sent[k], options.rank);
    X_.push_back(std::move(X));
  }
  said_ = public_parts(X_);
  round_start_ = X_;
  costs_.push_front(cost_at(X_, said_));

  colours_ = options.schedule == Schedule::kColoured ? colours_of(blocks_) : std::vector<int>(blocks_.size());
  for (int b = 0; b < size(); ++b) order_.push_back(b);
  std::stable_sort(order_.begin(), order_.end(), [&](int a, int b) { return colours_[a] < colours_[b]; });
  gradients_.resize(blocks_.size());
  if (options.schedule == Schedule::kGreedy) {
    for (int b = 0; b < size(); ++b) tell_gradient(b);
  }
}

std::vector<Lifted> Team::public_parts(const std::vector<Lifted>& X) const {
  std::vector<Lifted> parts;
  for (int b = 0; b < size(); ++b) parts.push_back(public_part(blocks_[b], X[b]));
  return parts;
}

// Each robot counts its own edges, and half of those that it shares.
double Team::cost_at(const std::vector<Lifted>& X, const std::vector<Lifted>& said) const {
  double cost = 0.0;
  for (int b = 0; b < size(); ++b) {
    const Lifted targets = targets_of(blocks_[b], said);
    const BlockSolver& solver = blocks_[b].solver;
    cost += solver.cost(targets, X[b]) - 0.5 * solver.shared_residuals(targets, X[b]).sum();
  }
  return cost;
}

void Team::tell_gradient(int b) {
  gradients_[b] = blocks_[b].solver.riemannian_gradient(targets_of(blocks_[b], said_), X_[b]).norm();
  evidence_.bytes["gradient"] += encoded_numbers(1);
}

int Team::next_block() {
  const int turn = evidence_.block_updates % size();
  switch (options_.schedule) {
    case Schedule::kGreedy:
      return static_cast<int>(std::max_element(gradients_.begin(), gradients_.end()) - gradients_.begin());
    case Schedule::kAsynchronous:
      return std::uniform_int_distribution<int>(0, size() - 1)(random_);
    case Schedule::kRoundRobin:
    case Schedule::kColoured:
      break;
  }
  return order_[turn];
}

// The others' public poses as robot b has them.
const std::vector<Lifted>& Team::known_to(int b) {
  if (!asynchronous()) return said_;
  known_ = said_;
  for (const int other : blocks_[b].neighbours) {
    const int age = std::uniform_int_distribution<int>(0, static_cast<int>(past_.size()))(random_);
    if (age > 0) known_[other] = past_[age - 1][other];
  }
  return known_;
}

void Team::update(int b) {
  const RobotBlock& block = blocks_[b];
  const Lifted targets = targets_of(block, known_to(b));
  Lifted X = X_[b];
  const BlockStep step = blocks_[b].solver.minimise(targets, X);
  dpgo_update_t message{};
  Lifted said = said_[b];
  if (!block.public_poses.empty()) {
    encode_differences(public_part(block, X) - said, message);
    add_differences(message, said);
    said = retract(said, Lifted::Zero(said.rows(), said.cols()));
    for (std::size_t k = 0; k < block.public_poses.size(); ++k)
      X.middleCols<4>(4 * block.public_poses[k]) = said.middleCols<4>(4 * static_cast<Eigen::Index>(k));
  }
  const double after = block.solver.cost(targets, X);

  RbcdUpdate evidence{block.robot, costs_.front(), costs_.front(), step.gradient_before,
                      after < step.cost_before};
  if (asynchronous()) {
    past_.push_front(said_);
    if (static_cast<int>(past_.size()) > options_.max_delay) past_.pop_back();
  }
  if (evidence.sent) {
    double change = after - step.cost_before;
    if (asynchronous()) {  // what nobody sees: against where the neighbours are by now
      const Lifted now = targets_of(block, said_);
      change = block.solver.cost(now, X) - block.solver.cost(now, X_[b]);
    }
    evidence.cost_after += change;
    X_[b] = std::move(X);
    said_[b] = std::move(said);
    if (!block.public_poses.empty()) evidence_.bytes["update"] += message.getEncodedSize();
  }
  costs_.push_front(evidence.cost_after);
  costs_.resize(std::min<std::size_t>(costs_.size(), watched() + 1));
  evidence_.updates.push_back(evidence);
  ++evidence_.block_updates;
  const int turn = evidence_.block_updates % size();
  const bool alongside = options_.schedule == Schedule::kColoured && turn != 0 &&
                         colours_[order_[turn]] == colours_[order_[turn - 1]];
  if (!alongside) ++evidence_.steps;
  if (options_.schedule == Schedule::kGreedy) {
    tell_gradient(b);
    for (const int other : block.neighbours) tell_gradient(other);
  }
}

void Team::accelerate() {
  std::vector<std::vector<Lifted>> directions(blocks_.size());
  for (int b = 0; b < size(); ++b) {
    directions[b].push_back(X_[b] - round_start_[b]);
    for (const auto& displacement : displacements_) directions[b].push_back(displacement[b]);
  }
  Extrapolation ahead = extrapolate(blocks_, X_, said_, std::move(directions));
  for (const std::int64_t numbers : ahead.numbers_sent)
    evidence_.bytes["acceleration"] += encoded_numbers(numbers) + encoded_numbers(1);  // and the cost there
  std::vector<Lifted> said = public_parts(ahead.X);
  const double cost = cost_at(ahead.X, said);
  ++evidence_.accelerations;
  if (!(cost <= costs_.front())) {
    ++evidence_.taken_back;
    displacements_.clear();
    round_start_ = X_;
    return;
  }
  X_ = std::move(ahead.X);
  said_ = std::move(said);
  costs_.front() = cost;
  std::vector<Lifted> displacement;
  for (int b = 0; b < size(); ++b) displacement.push_back(X_[b] - round_start_[b]);
  displacements_.push_front(std::move(displacement));
  if (static_cast<int>(displacements_.size()) > options_.memory) displacements_.pop_back();
  round_start_ = X_;
  if (options_.schedule == Schedule::kGreedy) {
    for (int b = 0; b < size(); ++b) tell_gradient(b);
  }
}

bool Team::settled() const {
  if (static_cast<int>(costs_.size()) <= watched()) return false;
  const auto [low, high] = std::minmax_element(costs_.begin(), costs_.end());
  return *high - *low <= options_.tolerance * *high;
}

bool Team::advance() {
  update(next_block());
  if (options_.stop && options_.stop({evidence_.block_updates, rounds(), costs_.front(), bytes_sent(),
                                      [this] { return rounded(); }}))
    return false;
  const bool round_ends = evidence_.block_updates % size() == 0;
  if (round_ends && options_.accelerated && !asynchronous() && size() > 1) accelerate();
  evidence_.converged = settled();
  return !evidence_.converged && evidence_.block_updates < options_.max_block_updates;
}

std::int64_t Team::bytes_sent() const {
  std::int64_t sum = 0;
  for (const auto& [kind, bytes] : evidence_.bytes) sum += bytes;
  return sum;
}

int Team::rounds() const { return (evidence_.block_updates + size() - 1) / size(); }

Poses Team::rounded() const {
  const Lifted first = X_.front().leftCols<4>();
  Poses poses;
  for (const Lifted& X : X_) {
    for (Eigen::Index k = 0; k < X.cols(); k += 4)
      poses.push_back(T_W_first_ * round_to_pose(first, X.middleCols<4>(k)));
  }
  return poses;
}

RbcdResult Team::result() const {
  RbcdResult result = evidence_;
  result.poses = rounded();
  result.cost = costs_.front();
  result.rounds = rounds();
  return result;
}

}  // namespace

const std::map<std::string, Schedule>& schedules() {
  static const std::map<std::string, Schedule> kSchedules = {{"greedy", Schedule::kGreedy},
                                                             {"round-robin", Schedule::kRoundRobin},
                                                             {"coloured", Schedule::kColoured},
                                                             {"asynchronous", Schedule::kAsynchronous}};
  return kSchedules;
}

RbcdResult solve_rbcd(const PoseGraph& graph, const Poses& start, const RbcdOptions& options) {
  Team team(graph, start, options);
  while (team.advance()) {
  }
  return team.result();
}

}  // namespace covey::pgo
