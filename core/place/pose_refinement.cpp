// SPDX-License-Identifier: BSD-3-Clause
#include "core/place/pose_refinement.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <utility>

#include "core/graph/graph.h"
#include "core/graph/marginal.h"
#include "core/graph/solve.h"

namespace covey::place {
namespace {

constexpr double kNearestSeen = 1e-3;  // m in front of a camera
constexpr graph::Key kPose{'t', 0};
// Of a point's squared residuals in both views: 99 % for the degrees of freedom that a measured depth or two leave (2, 3).
constexpr double kFits = 11.3;
constexpr int kFewest = 3;

graph::Key point_key(std::size_t k) { return {'p', k}; }

template <int kDim>
graph::Vector<kDim> view(const Eigen::Vector3d& p, Eigen::Matrix<double, kDim, 3>* J) {
  if (!(p.z() > kNearestSeen)) {
    if (J) J->setZero();
    return graph::Vector<kDim>::Zero();
  }
  const double inverse = 1.0 / p.z();
  const Eigen::Vector3d all(p.x() * inverse, p.y() * inverse, inverse);
  if (J) {
    Eigen::Matrix3d full;
    full << inverse, 0.0, -all.x() * inverse,  //
        0.0, inverse, -all.y() * inverse,      //
        0.0, 0.0, -inverse * inverse;
    *J = full.template topRows<kDim>();
  }
  return all.head<kDim>();
}

template <int kDim>
graph::Vector<kDim> measured_view(const FrameFeatures& features, std::size_t k) {
  const Eigen::Vector2d direction = features.direction(k);
  const Eigen::Vector3d all(direction.x(), direction.y(), 1.0 / static_cast<double>(features.depths_m[k]));
  return all.head<kDim>();
}

template <int kDim>
graph::Noise<kDim> noise_of(const ViewNoise& noise) {
  const Eigen::Vector3d all(noise.direction, noise.direction, noise.inverse_depth);
  return graph::Noise<kDim>::sigmas(all.head<kDim>());
}

graph::Robust kernel() { return graph::Robust::huber(2.0); }

struct Problem {
  graph::Graph graph;
  graph::Values values;
  std::vector<std::array<graph::FactorId, 2>> factors;  // of each pair
};

Problem make_problem(const FrameFeatures& c, const FrameFeatures& d,
                     const std::vector<std::pair<int, int>>& pairs, const SE3& T_C_D) {
  Problem problem;
  problem.values.set(kPose, T_C_D);
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const auto i = static_cast<std::size_t>(pairs[k].first);
    const auto j = static_cast<std::size_t>(pairs[k].second);
    const graph::Key point = point_key(k);
    const Eigen::Vector3d p_C = c.has_depth(i) ? c.point(i) : Eigen::Vector3d(T_C_D * d.point(j));
    problem.values.set(point, graph::Vector<3>(p_C));
    graph::Graph& graph = problem.graph;
    const graph::FactorId own =
        c.has_depth(i)
            ? graph.add(OwnView<3>{measured_view<3>(c, i)}, {point}, noise_of<3>(c.noise), kernel())
            : graph.add(OwnView<2>{measured_view<2>(c, i)}, {point}, noise_of<2>(c.noise), kernel());
    const graph::FactorId other =
        d.has_depth(j)
            ? graph.add(OtherView<3>{measured_view<3>(d, j)}, {kPose, point}, noise_of<3>(d.noise), kernel())
            : graph.add(OtherView<2>{measured_view<2>(d, j)}, {kPose, point}, noise_of<2>(d.noise), kernel());
    problem.factors.push_back({own, other});
  }
  return problem;
}

// Of pair k in both views.
double squared_residual_of(const Problem& problem, std::size_t k) {
  double squared = 0.0;
  for (const graph::FactorId id : problem.factors[k])
    squared += squared_residual(problem.graph.factor(id), problem.values);
  return squared;
}

bool fits(const Problem& problem, std::size_t k) {
  const auto p_C = problem.values.get<graph::Vector<3>>(point_key(k));
  const auto T_C_D = problem.values.get<SE3>(kPose);
  if (!(p_C.z() > kNearestSeen) || !((T_C_D.inverse() * p_C).z() > kNearestSeen)) return false;
  return squared_residual_of(problem, k) < kFits;
}

// Of the pairs that fit. Each view has two numbers, three with a depth; the points take three each, the pose six.
double variance_factor(const FrameFeatures& c, const FrameFeatures& d, const Problem& problem,
                       const std::vector<std::pair<int, int>>& pairs) {
  double squared = 0.0;
  double freedom = -6.0;
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    if (!fits(problem, k)) continue;
    squared += squared_residual_of(problem, k);
    freedom += 1.0 + (c.has_depth(static_cast<std::size_t>(pairs[k].first)) ? 1.0 : 0.0) +
               (d.has_depth(static_cast<std::size_t>(pairs[k].second)) ? 1.0 : 0.0);
  }
  return squared / std::max(1.0, freedom);
}

// How far off a view of p is, on the plane z = 1; a lot where it is not in front.
double off(const Eigen::Vector3d& p, const FrameFeatures& features, std::size_t k) {
  constexpr double kFar = 1e3;
  return p.z() > kNearestSeen ? (p.hnormalized() - features.direction(k)).norm() : kFar;
}

// Some depth must be known, or the pair says nothing of the distance.
std::vector<std::pair<int, int>> pairs_near(const FrameFeatures& c, const FrameFeatures& d,
                                            const std::vector<std::pair<int, int>>& pairs, const SE3& T_C_D,
                                            double gather) {
  std::vector<std::pair<int, int>> kept;
  const SE3 T_D_C = T_C_D.inverse();
  for (const auto& pair : pairs) {
    const auto i = static_cast<std::size_t>(pair.first);
    const auto j = static_cast<std::size_t>(pair.second);
    const bool forth = c.has_depth(i) && off(T_D_C * c.point(i), d, j) < gather;
    const bool back = d.has_depth(j) && off(T_C_D * d.point(j), c, i) < gather;
    if (forth || back) kept.push_back(pair);
  }
  return kept;
}

}  // namespace

template <int kDimension>
auto OwnView<kDimension>::evaluate(const Eigen::Vector3d& p_C, Eigen::Matrix<double, kDim, 3>* J) const
    -> graph::Vector<kDim> {
  if (!(p_C.z() > kNearestSeen)) {
    if (J) J->setZero();
    return graph::Vector<kDim>::Zero();
  }
  return view<kDim>(p_C, J) - measured;
}

template <int kDimension>
auto OtherView<kDimension>::evaluate(const SE3& T_C_D, const Eigen::Vector3d& p_C,
                                     Eigen::Matrix<double, kDim, 6>* J_T,
                                     Eigen::Matrix<double, kDim, 3>* J_p) const -> graph::Vector<kDim> {
  const Eigen::Vector3d p_D = T_C_D.inverse() * p_C;
  if (!(p_D.z() > kNearestSeen)) {
    if (J_T) {
      J_T->setZero();
      J_p->setZero();
    }
    return graph::Vector<kDim>::Zero();
  }
  Eigen::Matrix<double, kDim, 3> J;
  const graph::Vector<kDim> seen = view<kDim>(p_D, J_T ? &J : nullptr);
  if (J_T) {
    // (T Exp([rho; phi]))^-1 p = p_D - rho + p_D x phi to first order.
    J_T->template leftCols<3>() = -J;
    J_T->template rightCols<3>() = J * hat(p_D);
    *J_p = J * T_C_D.rotation.inverse().matrix();
  }
  return seen - measured;
}

template struct OwnView<2>;
template struct OwnView<3>;
template struct OtherView<2>;
template struct OtherView<3>;

std::optional<RefinedPose> refine_pose(const FrameFeatures& c, const FrameFeatures& d,
                                       const std::vector<std::pair<int, int>>& pairs, const SE3& T_C_D,
                                       double gather) {
  RefinedPose refined{.T_C_D = T_C_D, .agreeing = pairs_near(c, d, pairs, T_C_D, gather)};
  constexpr int kRounds = 4;
  for (int round = 0; round < kRounds; ++round) {
    if (refined.agreeing.size() < kFewest) return std::nullopt;
    Problem problem = make_problem(c, d, refined.agreeing, refined.T_C_D);
    solve(problem.graph, problem.values, {.max_iterations = 10, .relative_cost_tolerance = 1e-6});
    refined.T_C_D = problem.values.get<SE3>(kPose);
    std::vector<std::pair<int, int>> fitting;
    for (std::size_t k = 0; k < refined.agreeing.size(); ++k) {
      if (fits(problem, k)) fitting.push_back(refined.agreeing[k]);
    }
    const double factor = variance_factor(c, d, problem, refined.agreeing);
    const bool settled = fitting.size() == refined.agreeing.size();
    refined.agreeing = std::move(fitting);
    if (!settled && round + 1 < kRounds) continue;
    const auto covariance = marginal_covariance(problem.graph, problem.values, {kPose});
    if (!covariance || !refined.T_C_D.translation.allFinite()) return std::nullopt;
    refined.covariance = *covariance;
    refined.variance_factor = factor;
    break;
  }
  return refined;
}

}  // namespace covey::place
