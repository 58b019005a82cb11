// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Local mesh optimisation: a robot's mesh follows its trajectory into the team's frame W (Tian et al., "Kimera-Multi", T-RO
// 2022, section VI). The mesh is simplified to nodes k at g_k (simplify.h), each with a pose M_k = (R_k, t_k); with the
// keyframes' poses X_i, odometry's x_i and the team's X^_i, what is minimised is
//
//     sum_i |Log(X^_i^-1 X_i)|^2                              keyframes go to where the team has them
//   + sum_k sum_l |R_k (g_l - g_k) + t_k - t_l|^2             the mesh stays rigid, over the simplified mesh's edges, both ways
//   + sum_l sum_i w_il |R(X_i) x_i^-1 g_l + t(X_i) - t_l|^2   and with it what a keyframe saw; w_il = its share of l's vertices
//   + sum_k |Log(S_k^T R_k)|^2                                weakly: a node without neighbours would turn freely
//
// each over its sigma, by Levenberg-Marquardt. The start has already been moved rigidly into W, node by node: by S_k, t_k of
// the keyframe that saw most of it, T_W_O = X^_i x_i^-1. The paper starts from the poses in O, which are another frame for all
// but the first robot; from there a robot that is placed 90 degrees turned needs many steps, from here three or four suffice.
//
// Every vertex v then moves with its k = 4 nearest nodes among those of its own pass (simplify.h):
//
//   v' = sum_j s_j (R_j (v - g_j) + t_j),   s_j ~ (1 - |v - g_j| / d_max)^2,   d_max = distance of the (k+1)-th
//
// A motion of all keyframes by one rigid T moves every vertex by exactly T.

#include <memory>
#include <span>
#include <vector>

#include "core/graph/solve.h"
#include "core/mesh/simplify.h"

namespace covey::mesh {

struct DeformationOptions {
  SimplifyOptions simplify;
  int neighbours = 4;  // k
  double keyframe_sigma_m =
      0.003;  // of the first term: tight, for a keyframe holds hundreds of nodes against it
  double keyframe_sigma_rad = 0.0006;
  double edge_sigma_m = 0.3;        // second
  double sighting_sigma_m = 0.03;   // third
  double rotation_sigma_rad = 1.0;  // fourth
  int max_iterations = 10;
  double relative_cost_tolerance = 1e-3;
};

class Deformation {
 public:
  // The keyframes must be those that the mesh names, each with a place in W. Simplifies the mesh and builds the graph.
  Deformation(const MeasuredMesh& mesh, std::vector<PlacedKeyframe> keyframes,
              const DeformationOptions& options = {});
  ~Deformation();
  Deformation(Deformation&&) noexcept;
  Deformation& operator=(Deformation&&) noexcept;

  // One step of Levenberg-Marquardt; false when it is over. A long optimisation can so be cut into pieces.
  bool step();
  void solve();  // all steps

  // Where vertices of the mesh, or others seen by these keyframes, come to lie: p_W[i] of p_O[i] seen by seen_by[i].
  void move(std::span<const Eigen::Vector3f> p_O, std::span<const std::int32_t> seen_by,
            std::span<Eigen::Vector3f> p_W) const;
  std::vector<Eigen::Vector3f> move(const MeasuredMesh& mesh) const;

  const SimplifiedMesh& simplified() const;
  const graph::SolveResult& result() const;  // costs of the start and of now, steps so far

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace covey::mesh
