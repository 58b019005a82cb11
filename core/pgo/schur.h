// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The second-order step of a team: one step of Levenberg-Marquardt on everybody's poses together, of which each robot works on
// its own part. Two messages make a step:
//
//   reduced   Each robot linearises the factors that it holds, eliminates its own poses but for those that separate it from the
//             others (core/graph/separator.h), and says what is left: S_r d = b_r on the separating poses.
//   step      One robot adds the systems, solves sum S_r d = sum b_r, and says d. Each finds the steps of its other poses by
//             back-substitution, and moves.
//
// Separating poses. A loop between two robots needs only one of its ends among them: the other end's robot holds the loop and
// linearises it with the far end as one more separating pose of its own. So they are a vertex cover of the loops; for each pair
// of robots both know the loops and find the same smallest cover (vertex_cover.h).
//
// S is dense: with n poses 72 n^2 bytes in 3D. It is sent as the root L of S = L L^T in single precision, which is as good as
// double precision is for S and cannot make it indefinite. And it is sent again only when steps with the old one are no longer
// good: they are steps of a simplified Newton method, whose right-hand sides are exact, so it ends at the same optimum. In the
// tangent spaces of the poses an S changes with the residuals only, not with where the poses lie.
//
// Whether a step was good is seen from the costs in the messages that follow it; if not, all go back, and the next S has more
// damping. All decisions follow from the messages, so whoever has them all comes to the same step.
//
// Sources: Cunningham, Paluri, Dellaert, "DDF-SAM: Fully distributed SLAM using constrained factor graphs", IROS 2010 (separators
// between robots); Madsen, Nielsen, Tingleff, "Methods for Non-Linear Least Squares Problems", 2004 (damping); Kelley, "Iterative
// Methods for Linear and Nonlinear Equations", 1995, section 5.4 (steps with an old factor).

#include <covey/dpgo_move_t.hpp>
#include <covey/dpgo_reduced_t.hpp>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "core/graph/separator.h"

namespace covey::pgo {

// The variable of a robot's pose; `place` counts as that robot's messages do.
graph::Key schur_key(int robot, int place);
int robot_of(graph::Key key);

struct SchurOptions {
  double damping =
      1e-10;  // at first, as a part of the diagonal: little, since a robot moves as a whole against all of it
  // S is sent anew when what a step promises has not fallen to this part of what the step before promised.
  double fresh_ratio = 0.05;
  double weight_change = 0.1;  // of a factor since S, beyond which its robot sends it anew
};

// One robot's side.
class SchurBlock {
 public:
  // graph: the robot's factors, with all that it shares with others: each of these touches one pose of one other robot. poses: its
  // own, and those. All keys are schur_key()s.
  SchurBlock(int robot, const graph::Graph& graph, const graph::Values& poses,
             const SchurOptions& options = {});

  int robot() const { return robot_; }
  // Whether this robot holds a factor, by its id in the graph: all that it shares with nobody, and its part of the others.
  bool holds(graph::FactorId id) const { return graph_.has(id); }
  // Of factors that it holds, 1 at first. To be changed after step() and before reduce().
  void set_weight(graph::FactorId id, double weight) { weights_.at(id) = weight; }
  double weight(graph::FactorId id) const { return weights_.at(id); }
  // Unweighted, where the poses are.
  double squared_residual(graph::FactorId id) const;

  dpgo_reduced_t reduce();
  // False, and nothing is done, where the message is no answer to the last reduce().
  bool step(const dpgo_move_t& step);

  // Of all variables; other robots' poses that are not separating stay where they were.
  const graph::Values& poses() const { return poses_; }
  const std::vector<graph::Key>& separating() const { return separator_->kept(); }

 private:
  using Weights = std::map<graph::FactorId, double>;

  bool must_factorise() const;
  Eigen::MatrixXd factorise();
  std::optional<Eigen::VectorXd> separating_steps(const dpgo_move_t& step) const;

  int robot_;
  SchurOptions options_;
  graph::Graph graph_;  // of what it holds
  std::unique_ptr<graph::Separator> separator_;
  graph::Values poses_;
  Weights weights_;
  // As of the last reduce(), which is where the step began that is not judged yet.
  graph::Values poses_before_;
  Weights weights_before_;
  Weights factorised_weights_;
  double damping_;
  bool refresh_ = true;
};

// The side of the one who solves for the separating poses.
class SchurTeam {
 public:
  explicit SchurTeam(const SchurOptions& options = {}) : options_(options), damping_(options.damping) {}

  // Whether a message holds together: lengths, order of names, finite values.
  static bool fits(const dpgo_reduced_t& reduced);
  // The next step from all members' messages, in an order of the members that stays; each must fit, and name the same poses as
  // that member's first one (COVEY_CHECK).
  dpgo_move_t solve(const std::vector<dpgo_reduced_t>& reduced);

  double cost() const { return cost_; }          // where the last step began, with the weights there
  double promised() const { return promised_; }  // by which the model says that it lowers the cost
  bool stuck() const { return rejected_ > kMaxRejected; }  // no step does

 private:
  static constexpr int kMaxRejected = 12;

  void adapt_damping(double gain_ratio);
  void lay_out(const std::vector<dpgo_reduced_t>& reduced);
  bool take_systems(const std::vector<dpgo_reduced_t>& reduced);
  void factorise();
  Eigen::VectorXd sum_of_sides(const std::vector<dpgo_reduced_t>& reduced) const;

  SchurOptions options_;
  double damping_;
  double cost_ = 0.0;
  double promised_ = 0.0;
  bool judging_ = false;  // a step is under way
  bool fresh_ = true;     // made with systems of where it began
  int rejected_ = 0;      // in a row

  std::vector<graph::Key> keys_;             // of all separating poses
  int tangent_ = 0;                          // of each
  std::vector<std::vector<int>> variables_;  // of each member, places in keys_
  std::vector<Eigen::MatrixXd> S_;           // of each member that has any
  std::unique_ptr<graph::PartialCholesky> cholesky_;
};

}  // namespace covey::pgo
