// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/certificate.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <random>
#include <utility>

#include "core/base/error.h"
#include "core/graph/key.h"
#include "core/graph/partial_cholesky.h"
#include "core/pgo/cost.h"
#include "core/pgo/vertex_cover.h"

namespace covey::pgo {
namespace {

using Block = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, 4, 4>;

constexpr std::int64_t kBytesPerNumber = 8;
constexpr std::int64_t kBytesPerName = 4;   // of a pose or a part
constexpr std::int64_t kBytesPerPlace = 2;  // of a pose among those that a robot has named
constexpr double kLeastCostPerEdge = 1e-6;

PoseGraph weighted(const PoseGraph& graph, const std::vector<double>& weights) {
  PoseGraph result{graph.dimension, graph.poses_per_robot, {}};
  for (std::size_t e = 0; e < graph.edges.size(); ++e) {
    const double weight = weights.empty() ? 1.0 : weights[e];
    if (!(weight > 0.0)) continue;
    result.edges.push_back(graph.edges[e]);
    result.edges.back().kappa *= weight;
    result.edges.back().tau *= weight;
  }
  return result;
}

// A robot: the poses whose columns it has, its own interior first, then the separator poses that it touches.
struct Member {
  int robot = 0;
  std::vector<int> poses;  // flat
  int interior = 0;
  std::vector<const Edge*> edges;  // with an end at this robot
  std::map<int, int> place;        // in `poses`

  int boundary() const { return static_cast<int>(poses.size()) - interior; }
};

// The graph as its robots have it.
class Team {
 public:
  explicit Team(const PoseGraph& graph)
      : graph_(graph), offsets_(graph.offsets()), parts_(connected_parts(graph)) {
    find_separator();
    for (int robot = 0; robot < graph.robots(); ++robot) {
      if (graph.poses_per_robot[robot] > 0) members_.push_back(member(robot));
    }
  }

  const std::vector<Member>& members() const { return members_; }
  const std::vector<int>& separator() const { return separator_; }
  const PoseGraph& graph() const { return graph_; }
  bool owns(const Member& member, int pose) const {
    return offsets_[member.robot] <= pose && pose < offsets_[member.robot + 1];
  }
  int flat(const PoseId& pose) const { return offsets_[pose.robot] + pose.index; }
  bool is_separator(int flat) const { return std::binary_search(separator_.begin(), separator_.end(), flat); }

  // Which of the robots that know an edge has the block between its two poses: the one whose pose is eliminated, of two
  // separator poses the lower robot.
  bool couples(const Member& member, const Edge& edge) const {
    if (!edge.between_robots()) return true;
    const bool is_from = edge.from.robot == member.robot;
    const bool mine = is_separator(flat(is_from ? edge.from : edge.to));
    const bool others = is_separator(flat(is_from ? edge.to : edge.from));
    if (mine != others) return others;
    return member.robot == std::min(edge.from.robot, edge.to.robot);
  }

  // The poses of a list whose translations are held: the first of each connected part that no pose of `elsewhere` belongs to. A
  // robot sees from its own edges whether a part of its interior touches the separator, the first robot from the names of the
  // parts that come with the complements.
  std::vector<int> held_poses(const std::vector<int>& poses, const std::vector<int>& elsewhere) const {
    std::vector<bool> seen(parts_.size() + 1, false);
    for (const int pose : elsewhere) seen[parts_[pose]] = true;
    std::vector<int> held;
    for (const int pose : poses) {
      if (!seen[parts_[pose]]) held.push_back(pose);
      seen[parts_[pose]] = true;
    }
    return held;
  }

  // Poses that the others have to know, the robot's own ends of shared edges.
  std::vector<int> public_poses() const {
    std::vector<int> poses;
    for (const Edge& edge : graph_.edges) {
      if (edge.between_robots()) poses.insert(poses.end(), {flat(edge.from), flat(edge.to)});
    }
    return sorted_set(std::move(poses));
  }

 private:
  static std::vector<int> sorted_set(std::vector<int> values) {
    std::sort(values.begin(), values.end());
    values.erase(std::unique(values.begin(), values.end()), values.end());
    return values;
  }

  void find_separator() {
    std::map<std::pair<int, int>, std::vector<std::pair<graph::Key, graph::Key>>> shared;
    const auto key = [this](const PoseId& pose) {
      return graph::Key{'x', static_cast<std::uint64_t>(flat(pose))};
    };
    for (const Edge& edge : graph_.edges) {
      if (!edge.between_robots()) continue;
      const auto [a, b] = std::minmax(edge.from, edge.to);
      shared[{a.robot, b.robot}].emplace_back(key(a), key(b));
    }
    for (const auto& [pair, edges] : shared) {
      for (const graph::Key pose : vertex_cover(edges)) separator_.push_back(static_cast<int>(pose.id));
    }
    separator_ = sorted_set(std::move(separator_));
  }

  Member member(int robot) const {
    Member result;
    result.robot = robot;
    std::vector<int> boundary;
    for (int pose = offsets_[robot]; pose < offsets_[robot + 1]; ++pose) {
      (is_separator(pose) ? boundary : result.poses).push_back(pose);
    }
    result.interior = static_cast<int>(result.poses.size());
    for (const Edge& edge : graph_.edges) {
      if (edge.from.robot != robot && edge.to.robot != robot) continue;
      result.edges.push_back(&edge);
      if (!edge.between_robots() || !couples(result, edge)) continue;
      boundary.push_back(flat(edge.from.robot == robot ? edge.to : edge.from));
    }
    boundary = sorted_set(std::move(boundary));
    result.poses.insert(result.poses.end(), boundary.begin(), boundary.end());
    for (std::size_t k = 0; k < result.poses.size(); ++k) result.place[result.poses[k]] = static_cast<int>(k);
    return result;
  }

  const PoseGraph& graph_;
  std::vector<int> offsets_;
  std::vector<int> parts_;
  std::vector<int> separator_;
  std::vector<Member> members_;
};

// The three blocks of an edge in a matrix over the poses, size x size each.
struct EdgeBlocks {
  Block from_from;
  Block from_to;
  Block to_to;
};

// In Q: |X_to - X_from M|^2_Omega.
EdgeBlocks connection_blocks(const Edge& edge, int d) {
  Block M = Block::Identity(d + 1, d + 1);
  M.topLeftCorner(d, d) = rotation_of(edge.measurement, d);
  M.topRightCorner(d, 1) = translation_of(edge.measurement, d);
  Block omega = Block::Zero(d + 1, d + 1);
  omega.diagonal().setConstant(edge.kappa);
  omega(d, d) = edge.tau;
  const Block MW = M * omega;
  return {MW * M.transpose(), -MW, omega};
}

// In the normal equations of the translations.
EdgeBlocks laplacian_blocks(const Edge& edge, int) {
  const Block tau = Block::Constant(1, 1, edge.tau);
  return {tau, -tau, tau};
}

// A sum of dense blocks on some poses each, by places in a list of poses.
struct BlockSum {
  int size = 1;  // rows of a pose
  std::vector<std::vector<int>> cliques;
  std::vector<Eigen::MatrixXd> blocks;

  void add(const std::vector<int>& clique, Eigen::MatrixXd block) {
    cliques.push_back(clique);
    blocks.push_back(std::move(block));
  }

  // Takes a null vector away that has the pose's last row in it, by an entry as large as any.
  void hold(int place) {
    double largest = 1.0;
    for (const Eigen::MatrixXd& block : blocks) largest = std::max(largest, block.cwiseAbs().maxCoeff());
    Eigen::MatrixXd block = Eigen::MatrixXd::Zero(size, size);
    block(size - 1, size - 1) = largest;
    add({place}, std::move(block));
  }
};

// A symmetric positive semidefinite matrix with a block for each pose, of which each robot has the blocks of its own edges.
class TeamMatrix {
 public:
  // The blocks of all edges, less what `less` has for the poses, by flat index; empty for nothing.
  template <typename BlocksOf>
  TeamMatrix(const Team& team, int size, BlocksOf blocks_of, const std::vector<Block>& less = {})
      : team_(team), size_(size) {
    for (const Member& member : team.members()) {
      shares_.push_back(share_of(member, blocks_of, less));
      std::vector<bool> kept(member.poses.size(), true);
      std::fill_n(kept.begin(), member.interior, false);
      factors_.emplace_back(std::vector<int>(kept.size(), size), shares_.back().cliques, kept);
      if (!is_first(member)) bytes_ += 2 * kBytesPerName * member.boundary();  // the pose's and its part's
    }
  }

  // Of the matrix with `shift` added to the diagonal of each block; false where it is not positive definite. Each robot says
  // whether its interior is, and sends its complement when all are.
  bool factorise(const Eigen::VectorXd& shift) {
    bool definite = true;
    for (std::size_t m = 0; m < factors_.size(); ++m) {
      const Member& member = team_.members()[m];
      definite = factors_[m].factorise(shares_[m].blocks, shifts(member, shift)) && definite;
      if (!is_first(member)) ++bytes_;
    }
    if (!definite) return false;
    BlockSum sum{size_, {}, {}};
    for (std::size_t m = 0; m < factors_.size(); ++m)
      add_complement(team_.members()[m], factors_[m].schur(), sum);
    const std::vector<int>& separator = team_.separator();
    for (const int pose : team_.held_poses(separator, {})) sum.hold(place_in_separator(pose));
    const std::vector<int> sizes(separator.size(), size_);
    sum_.emplace(sizes, sum.cliques, std::vector<bool>(separator.size(), false));
    return sum_->factorise(sum.blocks, Eigen::VectorXd::Zero(sum_->size()));
  }

  // After factorise(): the solution for a right-hand side with size_ rows for each pose, by flat index.
  Eigen::VectorXd solve(const Eigen::VectorXd& b) {
    Eigen::VectorXd of_separator = Eigen::VectorXd::Zero(sum_->size());
    std::vector<Eigen::VectorXd> forward;
    for (std::size_t m = 0; m < factors_.size(); ++m) {
      const Member& member = team_.members()[m];
      forward.push_back(factors_[m].forward(own_rows(member, b)));
      for (int k = 0; k < member.boundary(); ++k)
        of_separator.segment(size_ * place_in_separator(boundary_pose(member, k)), size_) +=
            forward[m].segment(size_ * (member.interior + k), size_);
      if (!is_first(member)) bytes_ += kBytesPerNumber * size_ * member.boundary();
    }
    of_separator = sum_->backward(sum_->forward(of_separator));
    bytes_ += kBytesPerNumber * of_separator.size();
    Eigen::VectorXd x(b.size());
    for (std::size_t m = 0; m < factors_.size(); ++m) {
      const Member& member = team_.members()[m];
      for (int k = 0; k < member.boundary(); ++k)
        forward[m].segment(size_ * (member.interior + k), size_) =
            of_separator.segment(size_ * place_in_separator(boundary_pose(member, k)), size_);
      const Eigen::VectorXd mine = factors_[m].backward(std::move(forward[m]));
      for (const auto& [pose, place] : member.place)
        x.segment(size_ * pose, size_) = mine.segment(size_ * place, size_);
    }
    return x;
  }

  std::int64_t bytes() const { return bytes_; }

 private:
  // Who gathers the complements, and sends nothing of its own.
  bool is_first(const Member& member) const { return &member == &team_.members().front(); }
  static int boundary_pose(const Member& member, int k) { return member.poses[member.interior + k]; }

  int place_in_separator(int pose) const {
    const std::vector<int>& separator = team_.separator();
    return static_cast<int>(std::lower_bound(separator.begin(), separator.end(), pose) - separator.begin());
  }

  template <typename BlocksOf>
  BlockSum share_of(const Member& member, BlocksOf blocks_of, const std::vector<Block>& less) const {
    BlockSum share{size_, {}, {}};
    for (const Edge* edge : member.edges) {
      const EdgeBlocks blocks = blocks_of(*edge, team_.graph().dimension);
      const int from = team_.flat(edge->from);
      const int to = team_.flat(edge->to);
      if (team_.owns(member, from)) share.add({member.place.at(from)}, blocks.from_from);
      if (team_.owns(member, to)) share.add({member.place.at(to)}, blocks.to_to);
      if (!team_.couples(member, *edge)) continue;
      Eigen::MatrixXd coupling = Eigen::MatrixXd::Zero(2 * size_, 2 * size_);
      coupling.bottomLeftCorner(size_, size_) = blocks.from_to.transpose();
      coupling.topRightCorner(size_, size_) = blocks.from_to;
      share.add({member.place.at(from), member.place.at(to)}, std::move(coupling));
    }
    for (const auto& [pose, place] : member.place) {
      if (!less.empty() && team_.owns(member, pose)) share.add({place}, -less[pose]);
    }
    const std::vector<int> interior(member.poses.begin(), member.poses.begin() + member.interior);
    const std::vector<int> boundary(member.poses.begin() + member.interior, member.poses.end());
    for (const int pose : team_.held_poses(interior, boundary)) share.hold(member.place.at(pose));
    return share;
  }

  Eigen::VectorXd shifts(const Member& member, const Eigen::VectorXd& shift) const {
    return own_rows(member, shift.replicate(team_.graph().poses(), 1));
  }

  // Of a vector with size_ rows for each pose by flat index; zero for other robots' poses.
  Eigen::VectorXd own_rows(const Member& member, const Eigen::VectorXd& all) const {
    Eigen::VectorXd rows = Eigen::VectorXd::Zero(size_ * static_cast<Eigen::Index>(member.poses.size()));
    for (const auto& [pose, place] : member.place) {
      if (team_.owns(member, pose)) rows.segment(size_ * place, size_) = all.segment(size_ * pose, size_);
    }
    return rows;
  }

  // Blocks between poses that nothing eliminated joins are zero, and are not sent.
  void add_complement(const Member& member, const Eigen::MatrixXd& complement, BlockSum& sum) {
    for (int p = 0; p < member.boundary(); ++p) {
      for (int q = 0; q <= p; ++q) {
        const Block block = complement.block(size_ * p, size_ * q, size_, size_);
        if (block.isZero(0.0)) continue;
        const int place = place_in_separator(boundary_pose(member, p));
        if (p == q) {
          sum.add({place}, block);
        } else {
          Eigen::MatrixXd coupling = Eigen::MatrixXd::Zero(2 * size_, 2 * size_);
          coupling.bottomLeftCorner(size_, size_) = block;
          sum.add({place_in_separator(boundary_pose(member, q)), place}, std::move(coupling));
        }
        if (is_first(member)) continue;
        bytes_ += 2 * kBytesPerPlace + kBytesPerNumber * (p == q ? size_ * (size_ + 1) / 2 : size_ * size_);
      }
    }
  }

  const Team& team_;
  int size_;
  std::vector<BlockSum> shares_;                 // of each member
  std::vector<graph::PartialCholesky> factors_;  // of each member's share
  std::optional<graph::PartialCholesky> sum_;    // of their complements
  std::int64_t bytes_ = 0;
};

// Lambda_i, with a last row and column of zeros for the translation. A pose's needs its own edges only.
std::vector<Block> multipliers(const Team& team, const Poses& poses) {
  const int d = team.graph().dimension;
  std::vector<Block> lambda(poses.size(), Block::Zero(d + 1, d + 1));
  const auto add = [&](int pose, const Block& gradient) {
    lambda[pose].topLeftCorner(d, d) += 0.5 * (gradient + gradient.transpose());
  };
  for (const Edge& edge : team.graph().edges) {
    const int from = team.flat(edge.from);
    const int to = team.flat(edge.to);
    const Block R = rotation_of(edge.measurement, d);
    const Block R_from_to = rotation_of(poses[from].inverse() * poses[to], d);
    const Eigen::VectorXd t = translation_of(edge.measurement, d);
    const Eigen::VectorXd residual = translation_of(poses[from].inverse() * poses[to], d) - t;
    add(to, edge.kappa * (Block::Identity(d, d) - R_from_to.transpose() * R));
    add(from, edge.kappa * (Block::Identity(d, d) - R_from_to * R.transpose()) -
                  edge.tau * residual * t.transpose());
  }
  return lambda;
}

// The poses with the translations that are best for their rotations; solved for as a correction, which keeps precise what is nearly right.
Poses with_best_translations(const Team& team, Poses poses, std::int64_t& bytes) {
  const int d = team.graph().dimension;
  Eigen::MatrixXd descent = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(poses.size()), d);
  for (const Edge& edge : team.graph().edges) {
    const SE3& T_from = poses[team.flat(edge.from)];
    const SE3& T_to = poses[team.flat(edge.to)];
    const Eigen::Vector3d pull = edge.tau * (T_to.translation - T_from * edge.measurement.translation);
    descent.row(team.flat(edge.to)) -= pull.head(d);
    descent.row(team.flat(edge.from)) += pull.head(d);
  }
  TeamMatrix laplacian(team, 1, laplacian_blocks);
  if (!laplacian.factorise(Eigen::VectorXd::Zero(1)))
    return poses;  // too near to singular: they stay as they are
  for (int axis = 0; axis < d; ++axis) {
    const Eigen::VectorXd step = laplacian.solve(descent.col(axis));
    for (std::size_t k = 0; k < poses.size(); ++k)
      poses[k].translation[axis] += step[static_cast<Eigen::Index>(k)];
  }
  bytes += laplacian.bytes();
  return poses;
}

// What the robots tell each other beside complements: public poses before and translations after they are made best (those of
// the separator came with the solution), three sums each (cost, cost after that, largest eigenvalue of Lambda), each eta.
std::int64_t bytes_of_values(const Team& team, int trials) {
  if (team.members().size() < 2) return 0;
  const int d = team.graph().dimension;
  const auto poses = static_cast<std::int64_t>(team.public_poses().size());
  const auto separator = static_cast<std::int64_t>(team.separator().size());
  const auto others = static_cast<std::int64_t>(team.members().size()) - 1;
  return kBytesPerNumber * ((d == 2 ? 3 : 7) * poses + d * (poses - separator) + 3 * others + trials);
}

double largest_eigenvalue(const std::vector<Block>& blocks) {
  double largest = 0.0;
  for (const Block& block : blocks) {
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(block, Eigen::EigenvaluesOnly);
    largest = std::max(largest, eigen.eigenvalues().maxCoeff());
  }
  return largest;
}

// Finds the smallest shift eta of S, between two bounds that are both proven: a factorisation that goes through says that it is enough,
// a vector of negative curvature that less is not.
class ShiftSearch {
 public:
  ShiftSearch(const Team& team, TeamMatrix& S) : team_(team), S_(S), d_(team.graph().dimension) {
    std::mt19937_64 random(1);
    std::normal_distribution<double> normal;
    x_ = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(d_ + 1) * team.graph().poses());
    for (double& value : x_) value = normal(random);
  }

  // In [low, high] to a relative accuracy; `high` is enough without a trial.
  double find(double low, double high, double accuracy) {
    if (high <= low || is_enough(low)) return low;
    double eta = std::sqrt(low * high);
    while (high > (1.0 + accuracy) * low) {
      if (is_enough(eta)) {
        high = eta;
        if (high <= (1.0 + accuracy) * low) break;
        const Needed needed = lanczos(eta, 0.25 * accuracy);
        low = std::max(low, needed.eta);
        eta = needed.sharp ? low * (1.0 + accuracy) : std::sqrt(low * high);
      } else {
        low = eta;
        eta = std::sqrt(low * high);
      }
    }
    return high;
  }

  int trials() const { return trials_; }
  std::int64_t bytes() const { return bytes_; }

 private:
  static constexpr int kMaxIterations = 30;
  struct Needed {
    double eta = 0.0;
    bool sharp = false;  // some eigenvalue is that near, most likely the lowest
  };

  bool is_enough(double eta) {
    ++trials_;
    Eigen::VectorXd shift = Eigen::VectorXd::Constant(d_ + 1, eta);
    shift[d_] = 0.0;
    return S_.factorise(shift);
  }

  // With D the identity on the rotations and x of unit length there, x^T (S + eta D)^-1 x >= 1 / (eta - needed). Lanczos' method finds
  // the x with the largest left-hand side (full orthogonalisation; Golub, van Loan, "Matrix Computations", section 10.3).
  Needed lanczos(double eta, double accuracy) {
    Eigen::MatrixXd V(x_.size(), kMaxIterations);
    Eigen::MatrixXd T = Eigen::MatrixXd::Zero(kMaxIterations, kMaxIterations);
    Eigen::VectorXd next = rotations_of(x_);
    Needed needed;
    for (int k = 0; k < kMaxIterations && next.norm() > 0.0 && !needed.sharp; ++k) {
      V.col(k) = next.normalized();
      const auto basis = V.leftCols(k + 1);
      next = rotations_of(S_.solve(V.col(k)));
      T.col(k).head(k + 1) = basis.transpose() * next;
      T.row(k).head(k + 1) = T.col(k).head(k + 1).transpose();
      for (int twice = 0; twice < 2; ++twice) next -= basis * (basis.transpose() * next);
      const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(T.topLeftCorner(k + 1, k + 1));
      const double largest = eigen.eigenvalues()[k];
      const auto vector = eigen.eigenvectors().col(k);
      needed.eta = eta - 1.0 / largest;
      needed.sharp = next.norm() * std::abs(vector[k]) < accuracy * needed.eta * largest * largest;
      x_ = basis * vector;
      // For the inner products, to which each robot has its part.
      bytes_ += kBytesPerNumber * 2 * (k + 2) * (static_cast<std::int64_t>(team_.members().size()) - 1);
    }
    return needed;
  }

  Eigen::VectorXd rotations_of(Eigen::VectorXd x) const {
    for (Eigen::Index k = d_; k < x.size(); k += d_ + 1) x[k] = 0.0;
    return x;
  }

  const Team& team_;
  TeamMatrix& S_;
  int d_;
  Eigen::VectorXd x_;  // where Lanczos' method begins
  int trials_ = 0;
  std::int64_t bytes_ = 0;
};

}  // namespace

Certificate certify(const PoseGraph& graph, const Poses& poses, const std::vector<double>& weights,
                    const CertificateOptions& options) {
  COVEY_CHECK(static_cast<int>(poses.size()) == graph.poses());
  COVEY_CHECK(weights.empty() || weights.size() == graph.edges.size());
  const PoseGraph problem = weighted(graph, weights);
  const Team team(problem);
  const int d = graph.dimension;
  const double rotation_unknowns = static_cast<double>(d) * graph.poses();

  Certificate result;
  result.cost = cost(problem, poses);
  result.separator = static_cast<int>(team.separator().size());
  const Poses candidate = with_best_translations(team, poses, result.bytes);
  const std::vector<Block> lambda = multipliers(team, candidate);
  TeamMatrix S(team, d + 1, connection_blocks, lambda);

  const double scale =
      std::max(result.cost, kLeastCostPerEdge * static_cast<double>(problem.edges.size() + 1));
  ShiftSearch search(team, S);
  result.eta = search.find(options.resolution * scale / rotation_unknowns, largest_eigenvalue(lambda),
                           options.accuracy);
  result.trials = search.trials();
  result.lower_bound = cost(problem, candidate) - result.eta * rotation_unknowns;
  result.gap = (result.cost - result.lower_bound) / scale;
  result.bytes += S.bytes() + search.bytes() + bytes_of_values(team, result.trials);
  return result;
}

}  // namespace covey::pgo
