// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/measured_noise.h"

#include <algorithm>

#include "core/base/error.h"
#include "core/graph/gnc.h"
#include "core/graph/gravity_factor.h"
#include "core/graph/pose_factors.h"

namespace covey::pgo {
namespace {

constexpr double kGaugeSigma = 1e-4;  // m, rad; nothing pulls against it

graph::Key pose_key(int flat) { return {'x', static_cast<std::uint64_t>(flat)}; }

class MeasuredGraph {
 public:
  MeasuredGraph(const PoseGraph& graph, const MeasuredNoise& noise, const Poses& start,
                const MeasuredOptions& options)
      : graph_(graph), noise_(noise), options_(options), offsets_(graph.offsets()), start_(start) {
    COVEY_CHECK(noise.covariances.size() == graph.edges.size());
    COVEY_CHECK(noise.gravity.size() == start.size());
    for (std::size_t k = 0; k < start.size(); ++k) values_.set(pose_key(static_cast<int>(k)), start[k]);
  }

  MeasuredResult run() {
    MeasuredResult result;
    const graph::Graph deciding = deciding_graph();
    decide(deciding, result.central);
    refine(result.central);
    for (std::size_t e = 0; e < graph_.edges.size(); ++e) {
      result.r2.push_back(graph::squared_residual(deciding.factor(e), values_));
      result.central.cost +=
          graph_.edges[e].known_inlier ? result.r2[e] : std::min(result.r2[e], options_.barc2);
    }
    for (std::size_t k = 0; k < start_.size(); ++k) {
      result.central.poses.push_back(values_.get<SE3>(pose_key(static_cast<int>(k))));
    }
    return result;
  }

 private:
  // One factor per edge, in the same order, so that a factor's id is the edge's index.
  graph::Graph deciding_graph() const {
    graph::Graph factors;
    for (std::size_t e = 0; e < graph_.edges.size(); ++e) {
      add_edge(graph_.edges[e], deciding_covariance(noise_.covariances[e], options_.noise), factors);
    }
    add_gravity_and_gauge(factors);
    return factors;
  }

  void decide(const graph::Graph& deciding, CentralResult& result) {
    graph::GncOptions gnc;
    gnc.barc_squared = options_.barc2;
    gnc.mu_step = options_.mu_step;
    gnc.annealing.each_step = gnc.last.each_step = options_.each_step;
    for (std::size_t e = 0; e < graph_.edges.size(); ++e) {
      if (!graph_.edges[e].known_inlier) gnc.candidates.push_back(e);
    }
    const graph::GncResult solved = graph::solve_gnc(deciding, values_, gnc);
    result.weights.assign(graph_.edges.size(), 1.0);
    for (std::size_t k = 0; k < gnc.candidates.size(); ++k)
      result.weights[gnc.candidates[k]] = solved.weights[k];
    result.iterations = solved.iterations;
  }

  void refine(CentralResult& result) {
    const NoiseOptions& noise = options_.noise;
    graph::Graph factors;
    for (std::size_t e = 0; e < graph_.edges.size(); ++e) {
      if (result.weights[e] == 0.0) continue;
      const Matrix6d& covariance = noise_.covariances[e];
      const bool odometry = graph_.edges[e].kind == EdgeKind::kOdometry;
      add_edge(graph_.edges[e],
               odometry ? with_floor(covariance, options_.odometry_floor * noise.floor_translation_sigma,
                                     options_.odometry_floor * noise.floor_rotation_sigma)
                        : deciding_covariance(covariance, noise),
               factors);
    }
    add_gravity_and_gauge(factors);
    const graph::SolveResult solved = graph::solve(factors, values_, {.each_step = options_.each_step});
    result.iterations += solved.iterations;
    result.converged = solved.converged;
    result.message = solved.message;
  }

  void add_edge(const Edge& edge, const Matrix6d& covariance, graph::Graph& factors) const {
    factors.add(graph::Between<SE3>{edge.measurement},
                {pose_key(offsets_[edge.from.robot] + edge.from.index),
                 pose_key(offsets_[edge.to.robot] + edge.to.index)},
                graph::Noise<6>::covariance(covariance));
  }

  void add_gravity_and_gauge(graph::Graph& factors) const {
    const SE3& T_W_gauge = start_[options_.gauge];
    const Gravity& at_gauge = noise_.gravity[options_.gauge];
    if (at_gauge.sigma <= 0.0) {
      factors.set_constant(pose_key(options_.gauge));
      return;
    }
    const Eigen::Vector3d down_W = T_W_gauge.rotation * at_gauge.down_K.normalized();
    for (std::size_t k = 0; k < noise_.gravity.size(); ++k) {
      const Gravity& gravity = noise_.gravity[k];
      if (gravity.sigma <= 0.0) continue;
      const double sigma = std::max(gravity.sigma, options_.noise.floor_rotation_sigma);
      factors.add(graph::GravityFactor{gravity.down_K.normalized(), down_W}, {pose_key(static_cast<int>(k))},
                  graph::Noise<2>::sigma(sigma));
    }
    Matrix6d information = Matrix6d::Identity() / (kGaugeSigma * kGaugeSigma);
    const Eigen::Vector3d down_K = at_gauge.down_K.normalized();
    information.bottomRightCorner<3, 3>() *= down_K * down_K.transpose();  // yaw
    factors.add(graph::Prior<SE3>{T_W_gauge}, {pose_key(options_.gauge)},
                graph::Noise<6>::information(information));
  }

  const PoseGraph& graph_;
  const MeasuredNoise& noise_;
  const MeasuredOptions& options_;
  const std::vector<int> offsets_;
  const Poses& start_;
  graph::Values values_;
};

}  // namespace

MeasuredResult solve_measured(const PoseGraph& graph, const MeasuredNoise& noise, const Poses& start,
                              const MeasuredOptions& options) {
  return MeasuredGraph(graph, noise, start, options).run();
}

double mahalanobis_sq(const SE3& T_A_B, const Matrix6d& covariance, const SE3& T_W_A, const SE3& T_W_B) {
  const graph::Between<SE3> between{T_A_B};
  const Vector6d r = between.evaluate(T_W_A, T_W_B, nullptr, nullptr);
  return (graph::Noise<6>::covariance(covariance).sqrt_information() * r).squaredNorm();
}

}  // namespace covey::pgo
