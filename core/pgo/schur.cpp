// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/schur.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "core/graph/dense.h"
#include "core/pgo/vertex_cover.h"

namespace covey::pgo {
namespace {

constexpr char kPose = 'x';
constexpr double kDampingStep = 10.0;
constexpr double kLeastDamping = 1e-13;
constexpr double kMostDamping = 1e6;
constexpr double kGoodStep = 0.75;  // of what was promised: less damping; below the other, more
constexpr double kPoorStep = 0.25;
constexpr double kCostRounding = 1e-12;  // of the cost

// Column by column.
std::vector<float> packed_lower(const Eigen::MatrixXd& L) {
  std::vector<float> values;
  values.reserve(static_cast<std::size_t>(L.rows() * (L.rows() + 1) / 2));
  for (Eigen::Index c = 0; c < L.cols(); ++c) {
    for (Eigen::Index r = c; r < L.rows(); ++r) values.push_back(static_cast<float>(L(r, c)));
  }
  return values;
}

Eigen::MatrixXd unpacked_lower(const std::vector<float>& values, int n) {
  Eigen::MatrixXd L = Eigen::MatrixXd::Zero(n, n);
  const float* value = values.data();
  for (int c = 0; c < n; ++c) {
    for (int r = c; r < n; ++r) L(r, c) = *value++;
  }
  return L;
}

template <typename T>
bool all_finite(const std::vector<T>& values) {
  return std::all_of(values.begin(), values.end(), [](T value) { return std::isfinite(value); });
}

template <typename Message>
void append_name(graph::Key key, Message& message) {
  message.robots.push_back(static_cast<std::int16_t>(robot_of(key)));
  message.places.push_back(static_cast<std::int32_t>(key.id & 0xffffffffU));
  message.n = static_cast<std::int32_t>(message.robots.size());
}

template <typename Message>
std::vector<graph::Key> names_in(const Message& message) {
  std::vector<graph::Key> keys;
  for (int k = 0; k < message.n; ++k) keys.push_back(schur_key(message.robots[k], message.places[k]));
  return keys;
}

template <typename Message>
bool names_fit(const Message& message) {
  const auto n = static_cast<std::size_t>(message.n);
  if (message.n < 0 || message.robots.size() != n || message.places.size() != n) return false;
  const auto negative = [](auto value) { return value < 0; };
  if (std::any_of(message.robots.begin(), message.robots.end(), negative)) return false;
  if (std::any_of(message.places.begin(), message.places.end(), negative)) return false;
  const std::vector<graph::Key> keys = names_in(message);
  return std::adjacent_find(keys.begin(), keys.end(), std::greater_equal<>()) == keys.end();
}

struct SharedFactor {
  graph::FactorId id = 0;
  graph::Key mine;
  graph::Key theirs;
};

// By the other robot.
std::map<int, std::vector<SharedFactor>> shared_factors(int robot, const graph::Graph& graph) {
  std::map<int, std::vector<SharedFactor>> shared;
  for (const graph::FactorId id : graph.ids()) {
    const auto& keys = graph.factor(id).keys();
    const auto foreign =
        std::find_if(keys.begin(), keys.end(), [&](graph::Key key) { return robot_of(key) != robot; });
    if (foreign == keys.end()) continue;
    COVEY_CHECK(keys.size() == 2);
    const graph::Key mine = foreign == keys.begin() ? keys[1] : keys[0];
    COVEY_CHECK(robot_of(mine) == robot);
    shared[robot_of(*foreign)].push_back({id, mine, *foreign});
  }
  return shared;
}

}  // namespace

graph::Key schur_key(int robot, int place) {
  return {kPose, static_cast<std::uint64_t>(robot) << 32U | static_cast<std::uint64_t>(place)};
}
int robot_of(graph::Key key) { return static_cast<int>(key.id >> 32U); }

SchurBlock::SchurBlock(int robot, const graph::Graph& graph, const graph::Values& poses,
                       const SchurOptions& options)
    : robot_(robot), options_(options), graph_(graph), poses_(poses), damping_(options.damping) {
  std::vector<graph::Key> separating;
  for (const auto& [peer, factors] : shared_factors(robot, graph)) {
    std::vector<std::pair<graph::Key, graph::Key>> loops;  // the lower robot's end first
    for (const SharedFactor& factor : factors) loops.emplace_back(std::minmax(factor.mine, factor.theirs));
    const std::set<graph::Key> cover = vertex_cover(loops);
    for (const SharedFactor& factor : factors) {
      const bool by_mine = cover.contains(factor.mine);
      const bool by_theirs = cover.contains(factor.theirs);
      if (by_mine) separating.push_back(factor.mine);
      if (by_theirs && (!by_mine || robot < peer)) {
        separating.push_back(factor.theirs);
      } else {
        graph_.remove(factor.id);
      }
    }
  }
  separator_ = std::make_unique<graph::Separator>(graph_, poses_, separating);
  for (const graph::FactorId id : graph_.ids()) weights_[id] = 1.0;
  COVEY_CHECK(std::isfinite(separator_->cost(poses_)));
  poses_before_ = poses_;
  weights_before_ = weights_;
}

double SchurBlock::squared_residual(graph::FactorId id) const {
  return graph::squared_residual(graph_.factor(id), poses_);
}

// Factorises with as much damping as it takes, and returns the root of S.
Eigen::MatrixXd SchurBlock::factorise() {
  for (double damping = damping_; damping <= kMostDamping; damping *= kDampingStep) {
    if (!separator_->factorise(poses_, damping)) continue;
    Eigen::MatrixXd L = separator_->schur();
    if (graph::cholesky_in_place(L)) return L;
  }
  COVEY_CHECK(false);
}

dpgo_reduced_t SchurBlock::reduce() {
  dpgo_reduced_t message{};
  message.from = robot_;
  message.to = -1;
  for (const graph::Key key : separating()) append_name(key, message);
  message.trial_cost = separator_->cost(poses_);
  for (const auto& [id, weight] : weights_) separator_->set_weight(id, weight);
  if (!std::isfinite(message.trial_cost)) {  // a step into nowhere, which will be taken back
    message.cost = message.trial_cost;
    message.b.resize(separator_->schur().rows());
  } else {
    if (must_factorise()) {
      message.root = packed_lower(factorise());
      factorised_weights_ = weights_;
      refresh_ = false;
    }
    const graph::Separator::Reduction reduction = separator_->reduce(poses_);
    message.cost = reduction.cost;
    message.gain = reduction.gain;
    message.b.assign(reduction.b.data(), reduction.b.data() + reduction.b.size());
  }
  message.n_b = static_cast<std::int32_t>(message.b.size());
  message.n_root = static_cast<std::int32_t>(message.root.size());
  return message;
}

bool SchurBlock::must_factorise() const {
  return refresh_ || std::any_of(weights_.begin(), weights_.end(), [&](const auto& weight) {
           return std::abs(weight.second - factorised_weights_.at(weight.first)) > options_.weight_change;
         });
}

bool SchurBlock::step(const dpgo_move_t& step) {
  if (!step.taken) {
    poses_ = poses_before_;
    weights_ = weights_before_;
  } else {
    const auto d = separating_steps(step);
    if (!d) return false;
    poses_before_ = poses_;
    weights_before_ = weights_;
    separator_->move(*d, poses_);
  }
  refresh_ = step.refresh;
  damping_ = step.damping;
  return true;
}

std::optional<Eigen::VectorXd> SchurBlock::separating_steps(const dpgo_move_t& step) const {
  if (!names_fit(step) || !all_finite(step.values) || step.n_values != static_cast<int>(step.values.size()))
    return std::nullopt;
  const std::vector<graph::Key> keys = names_in(step);
  Eigen::VectorXd d(separator_->schur().rows());
  if (d.size() == 0) return d;
  const auto tangent = static_cast<int>(d.size() / static_cast<Eigen::Index>(separating().size()));
  if (step.n_values != tangent * step.n) return std::nullopt;
  for (std::size_t k = 0; k < separating().size(); ++k) {
    const auto found = std::lower_bound(keys.begin(), keys.end(), separating()[k]);
    if (found == keys.end() || *found != separating()[k]) return std::nullopt;
    for (int i = 0; i < tangent; ++i) {
      d[static_cast<int>(k) * tangent + i] = step.values[(found - keys.begin()) * tangent + i];
    }
  }
  return d;
}

bool SchurTeam::fits(const dpgo_reduced_t& m) {
  const auto n_b = static_cast<std::size_t>(m.n_b);
  if (!names_fit(m) || m.n_b < 0 || m.b.size() != n_b || (m.n == 0 ? m.n_b != 0 : m.n_b % m.n != 0))
    return false;
  if (!m.root.empty() && m.root.size() != n_b * (n_b + 1) / 2) return false;
  return !std::isnan(m.trial_cost) && !std::isnan(m.cost) && std::isfinite(m.gain) && all_finite(m.b) &&
         all_finite(m.root);
}

dpgo_move_t SchurTeam::solve(const std::vector<dpgo_reduced_t>& reduced) {
  double trial = 0.0;
  double cost = 0.0;
  double gain = 0.0;
  for (const dpgo_reduced_t& m : reduced) {
    COVEY_CHECK(fits(m));
    trial += m.trial_cost;
    cost += m.cost;
    gain += m.gain;
  }
  const bool judged = std::exchange(judging_, true);
  dpgo_move_t message{};
  message.to = -1;
  message.taken = !judged || trial <= (1.0 + kCostRounding) * cost_;
  if (!message.taken) {
    judging_ = false;
    ++rejected_;
    if (fresh_) damping_ = std::min(damping_ * kDampingStep, kMostDamping);
    message.refresh = true;
    message.damping = damping_;
    return message;
  }
  rejected_ = 0;
  if (judged && fresh_) adapt_damping((cost_ - trial) / promised_);
  if (variables_.empty()) lay_out(reduced);
  fresh_ = take_systems(reduced);
  const Eigen::VectorXd b = sum_of_sides(reduced);
  const Eigen::VectorXd d = cholesky_->backward(cholesky_->forward(b));
  const double promised = gain + b.dot(d);
  message.refresh = !judged || promised > options_.fresh_ratio * promised_;
  message.damping = damping_;
  for (const graph::Key key : keys_) append_name(key, message);
  message.values.assign(d.data(), d.data() + d.size());
  message.n_values = static_cast<std::int32_t>(message.values.size());
  cost_ = cost;
  promised_ = promised;
  return message;
}

void SchurTeam::adapt_damping(double gain_ratio) {
  if (gain_ratio > kGoodStep) damping_ = std::max(damping_ / kDampingStep, kLeastDamping);
  if (gain_ratio < kPoorStep) damping_ = std::min(damping_ * kDampingStep, kMostDamping);
}

void SchurTeam::lay_out(const std::vector<dpgo_reduced_t>& reduced) {
  for (const dpgo_reduced_t& m : reduced) {
    if (m.n > 0) tangent_ = m.n_b / m.n;
    for (const graph::Key key : names_in(m)) keys_.push_back(key);
  }
  std::sort(keys_.begin(), keys_.end());
  keys_.erase(std::unique(keys_.begin(), keys_.end()), keys_.end());
  std::vector<std::vector<int>> cliques;
  for (const dpgo_reduced_t& m : reduced) {
    auto& places = variables_.emplace_back();
    for (const graph::Key key : names_in(m)) {
      places.push_back(static_cast<int>(std::lower_bound(keys_.begin(), keys_.end(), key) - keys_.begin()));
    }
    if (!places.empty()) cliques.push_back(places);
  }
  cholesky_ = std::make_unique<graph::PartialCholesky>(std::vector<int>(keys_.size(), tangent_), cliques,
                                                       std::vector<bool>(keys_.size(), false));
  S_.resize(cliques.size());
}

// Whether all of them are new.
bool SchurTeam::take_systems(const std::vector<dpgo_reduced_t>& reduced) {
  COVEY_CHECK(reduced.size() == variables_.size());
  int taken = 0;
  std::size_t clique = 0;
  for (std::size_t k = 0; k < reduced.size(); ++k) {
    COVEY_CHECK(reduced[k].n == static_cast<int>(variables_[k].size()));
    if (reduced[k].n == 0) continue;
    COVEY_CHECK(reduced[k].n_b == tangent_ * reduced[k].n);
    Eigen::MatrixXd& S = S_[clique++];
    if (reduced[k].root.empty()) continue;
    S = graph::square_of_lower(unpacked_lower(reduced[k].root, reduced[k].n_b));
    ++taken;
  }
  COVEY_CHECK(std::none_of(S_.begin(), S_.end(), [](const Eigen::MatrixXd& S) { return S.size() == 0; }));
  if (taken > 0) factorise();
  return taken == static_cast<int>(S_.size());
}

// The sum is positive definite, since all parts are; but for rounding, where a part hardly determines it.
void SchurTeam::factorise() {
  Eigen::VectorXd diagonal = Eigen::VectorXd::Zero(cholesky_->size());
  std::size_t clique = 0;
  for (const auto& places : variables_) {
    if (places.empty()) continue;
    const Eigen::MatrixXd& S = S_[clique++];
    for (std::size_t k = 0; k < places.size(); ++k) {
      diagonal.segment(tangent_ * places[k], tangent_) +=
          S.diagonal().segment(tangent_ * static_cast<int>(k), tangent_);
    }
  }
  for (double damping = 0.0; damping <= kMostDamping;
       damping = std::max(kCostRounding, kDampingStep * damping)) {
    if (cholesky_->factorise(S_, damping * diagonal)) return;
  }
  COVEY_CHECK(false);
}

Eigen::VectorXd SchurTeam::sum_of_sides(const std::vector<dpgo_reduced_t>& reduced) const {
  Eigen::VectorXd b = Eigen::VectorXd::Zero(cholesky_->size());
  for (std::size_t m = 0; m < reduced.size(); ++m) {
    for (std::size_t k = 0; k < variables_[m].size(); ++k) {
      b.segment(tangent_ * variables_[m][k], tangent_) +=
          Eigen::Map<const Eigen::VectorXd>(reduced[m].b.data() + tangent_ * k, tangent_);
    }
  }
  return b;
}

}  // namespace covey::pgo
