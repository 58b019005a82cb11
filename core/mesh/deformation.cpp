// SPDX-License-Identifier: BSD-3-Clause
#include "core/mesh/deformation.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "core/geometry/kd_tree.h"
#include "core/graph/pose_factors.h"
#include "core/mesh/deformation_factors.h"

namespace covey::mesh {
namespace {

graph::Key node_key(int node) { return {'m', static_cast<std::uint64_t>(node)}; }
graph::Key keyframe_key(int keyframe) { return {'x', static_cast<std::uint64_t>(keyframe)}; }

// Nodes in W as the keyframe that saw most of each has it.
std::vector<SE3> start_poses(const SimplifiedMesh& simple, const std::vector<PlacedKeyframe>& keyframes) {
  std::vector<SE3> poses;
  poses.reserve(simple.nodes.size());
  for (const Node& node : simple.nodes) {
    const SE3 T_W_O = keyframes[node.seen_by.front().keyframe].correction();
    poses.push_back({T_W_O.rotation, T_W_O * node.g_O});
  }
  return poses;
}

// w_il: the shares of the keyframes that are kept sum up to 1.
double share(const Node& node, const Sighting& sighting) {
  int all = 0;
  for (const Sighting& each : node.seen_by) all += each.vertices;
  return static_cast<double>(sighting.vertices) / all;
}

}  // namespace

struct Deformation::Impl {
  DeformationOptions options;
  std::vector<PlacedKeyframe> keyframes;
  SimplifiedMesh simple;
  std::vector<SE3> poses;
  graph::Graph graph;
  graph::Values values;
  graph::SolveResult result;
  bool over = false;
  std::unique_ptr<KdTree> tree;  // of the nodes in O

  void add_keyframes() {
    Vector6d sigmas;
    sigmas << Eigen::Vector3d::Constant(options.keyframe_sigma_m),
        Eigen::Vector3d::Constant(options.keyframe_sigma_rad);
    const auto noise = graph::Noise<6>::sigmas(sigmas);
    std::set<int> used;
    for (const Node& node : simple.nodes) {
      for (const Sighting& sighting : node.seen_by) used.insert(sighting.keyframe);
    }
    for (const int i : used) {
      values.set(keyframe_key(i), keyframes[i].T_W_K);
      graph.add(graph::Prior<SE3>{keyframes[i].T_W_K}, {keyframe_key(i)}, noise);
    }
  }

  void add_nodes() {
    const auto rotation_noise = graph::Noise<3>::sigma(options.rotation_sigma_rad);
    for (std::size_t k = 0; k < simple.nodes.size(); ++k) {
      const Node& node = simple.nodes[k];
      const graph::Key key = node_key(static_cast<int>(k));
      values.set(key, poses[k]);
      graph.add(RotationPrior{poses[k].rotation}, {key}, rotation_noise);
      for (const Sighting& sighting : node.seen_by) {
        const auto noise =
            graph::Noise<3>::sigma(options.sighting_sigma_m / std::sqrt(share(node, sighting)));
        const Eigen::Vector3d g_K = keyframes[sighting.keyframe].T_O_K.inverse() * node.g_O;
        graph.add(RigidTie{g_K}, {keyframe_key(sighting.keyframe), key}, noise);
      }
    }
  }

  void add_edges() {
    const auto noise = graph::Noise<3>::sigma(options.edge_sigma_m);
    for (const NodeEdge& edge : simple.edges) {
      const Eigen::Vector3d g_ab = simple.nodes[edge.b].g_O - simple.nodes[edge.a].g_O;
      graph.add(RigidTie{g_ab}, {node_key(edge.a), node_key(edge.b)}, noise);
      graph.add(RigidTie{-g_ab}, {node_key(edge.b), node_key(edge.a)}, noise);
    }
  }

  void take_poses() {
    for (std::size_t k = 0; k < poses.size(); ++k) poses[k] = values.get<SE3>(node_key(static_cast<int>(k)));
  }

  Eigen::Vector3d blend(const Eigen::Vector3d& p_O, const std::vector<KdTree::Neighbour>& near) const {
    const auto k = std::min<std::size_t>(near.size(), options.neighbours);
    // Without a (k+1)-th node the furthest keeps a quarter of the weight that it would have at distance 0.
    const double d_max = near.size() > k ? near.back().distance : 2.0 * near.back().distance;
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    double weights = 0.0;
    for (std::size_t j = 0; j < k; ++j) {
      const double weight = d_max > 0.0 ? std::pow(1.0 - near[j].distance / d_max, 2) : 1.0;
      const int node = near[j].index;
      sum += weight * (poses[node] * Eigen::Vector3d(p_O - simple.nodes[node].g_O));
      weights += weight;
    }
    if (weights > 0.0) return sum / weights;
    return poses[near.front().index] * Eigen::Vector3d(p_O - simple.nodes[near.front().index].g_O);
  }
};

Deformation::Deformation(const MeasuredMesh& mesh, std::vector<PlacedKeyframe> keyframes,
                         const DeformationOptions& options)
    : impl_(std::make_unique<Impl>()) {
  impl_->options = options;
  impl_->keyframes = std::move(keyframes);
  impl_->simple = simplify(mesh, impl_->keyframes, options.simplify);
  impl_->poses = start_poses(impl_->simple, impl_->keyframes);
  impl_->add_keyframes();
  impl_->add_nodes();
  impl_->add_edges();
  impl_->over = impl_->simple.nodes.empty();
  std::vector<Eigen::Vector3f> places;
  for (const Node& node : impl_->simple.nodes) places.push_back(node.g_O.cast<float>());
  impl_->tree = std::make_unique<KdTree>(std::move(places));
}

Deformation::~Deformation() = default;
Deformation::Deformation(Deformation&&) noexcept = default;
Deformation& Deformation::operator=(Deformation&&) noexcept = default;

bool Deformation::step() {
  if (impl_->over) return false;
  const graph::SolveResult step =
      graph::solve(impl_->graph, impl_->values,
                   {.max_iterations = 1, .relative_cost_tolerance = impl_->options.relative_cost_tolerance});
  graph::SolveResult& result = impl_->result;
  if (result.iterations == 0) result.initial_cost = step.initial_cost;
  result.final_cost = step.final_cost;
  result.iterations += step.iterations;
  result.converged = step.converged || step.initial_cost - step.final_cost <=
                                           impl_->options.relative_cost_tolerance * step.initial_cost;
  result.message = step.message;
  impl_->take_poses();
  impl_->over =
      result.converged || step.iterations == 0 || result.iterations >= impl_->options.max_iterations;
  return !impl_->over;
}

void Deformation::solve() {
  while (step()) continue;
}

void Deformation::move(std::span<const Eigen::Vector3f> p_O, std::span<const std::int32_t> seen_by,
                       std::span<Eigen::Vector3f> p_W) const {
  std::vector<KdTree::Neighbour> near;
  for (std::size_t i = 0; i < p_O.size(); ++i) {
    const PlacedKeyframe& keyframe = impl_->keyframes[seen_by[i]];
    impl_->tree->nearest(p_O[i], impl_->options.neighbours + 1, near, [&](int node) {
      return same_pass(impl_->simple.nodes[node], keyframe, impl_->options.simplify.pass_us);
    });
    const Eigen::Vector3d p = p_O[i].cast<double>();
    p_W[i] = (near.empty() ? keyframe.correction() * p : impl_->blend(p, near)).cast<float>();
  }
}

std::vector<Eigen::Vector3f> Deformation::move(const MeasuredMesh& mesh) const {
  std::vector<Eigen::Vector3f> p_W(mesh.p_O.size());
  move(mesh.p_O, mesh.seen_by, p_W);
  return p_W;
}

const SimplifiedMesh& Deformation::simplified() const { return impl_->simple; }
const graph::SolveResult& Deformation::result() const { return impl_->result; }

}  // namespace covey::mesh
