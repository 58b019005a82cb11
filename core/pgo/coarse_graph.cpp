// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/coarse_graph.h"

#include <algorithm>
#include <map>
#include <tuple>
#include <utility>

#include "core/pgo/cost.h"
#include "core/pgo/elected_messages.h"
#include "core/pgo/frame_tree.h"

namespace covey::pgo {
namespace {

struct Nodes {
  std::vector<int> ids;  // ascending, the first is 0
  std::vector<SE3> T_S_N;

  int nearest(int id) const {
    const auto next = std::lower_bound(ids.begin(), ids.end(), id);
    const auto k = static_cast<int>(next - ids.begin());
    if (next == ids.end()) return k - 1;
    return k > 0 && id - ids[k - 1] < *next - id ? k - 1 : k;
  }
};

Nodes nodes_of(const OpenedMember& member, int segment, const CoarseOptions& options) {
  const auto first = member.places.lower_bound({segment, 0});
  const auto end = member.places.lower_bound({segment + 1, 0});
  Nodes nodes;
  const int span = std::prev(end)->first.second;
  const int piece = std::max(options.shortest_piece, span / options.pieces);
  for (auto place = first; place != end; ++place) {
    const bool last = std::next(place) == end;
    if (!nodes.ids.empty() && !last && place->first.second < nodes.ids.back() + piece) continue;
    nodes.ids.push_back(place->first.second);
    nodes.T_S_N.push_back(member.T_S_K[place->second]);
  }
  return nodes;
}

// Of relative poses, per axis.
struct Variance {
  double rotation = 0.0;
  double translation = 0.0;

  Precision precision() const { return {0.5 / rotation, 1.0 / translation}; }
};

Variance variance_of(const Precision& precision) { return {0.5 / precision.kappa, 1.0 / precision.tau}; }

// Of the odometry from one keyframe to a later one: what turns it early moves its end far.
Variance drift(const Segment& segment, const std::vector<SE3>& T_S_K, int from, int to) {
  Variance sum;
  for (int k = from + 1; k <= to; ++k) {
    const Variance step = variance_of(segment.poses[k].precision);
    sum.rotation += step.rotation;
    sum.translation +=
        step.translation + step.rotation * (T_S_K[to].translation - T_S_K[k].translation).squaredNorm();
  }
  return sum;
}

class CoarseGraph {
 public:
  CoarseGraph(const AgreedProblem& problem, const CoarseOptions& options)
      : problem_(problem), options_(options) {
    for (const int robot : problem.part) {
      const OpenedMember& member = problem.members.at(robot);
      for (int s = 0; s < member.join.n_segments; ++s) {
        nodes_.emplace(StartFrame{robot, s}, nodes_of(member, s, options));
        extents_.emplace(StartFrame{robot, s}, extent_of(member.public_poses(s)));
      }
    }
  }

  GraphSnapshot snapshot() {
    GraphSnapshot coarse;
    coarse.robot = problem_.robot();
    for (int s = 0; s < static_cast<int>(problem_.graph.segments.size()); ++s)
      coarse.segments.push_back(coarse_segment(s));
    add_private_loops(coarse);
    add_shared_loops(coarse);
    return coarse;
  }

 private:
  Segment coarse_segment(int s) {
    const Segment& fine = problem_.graph.segments[s];
    const std::vector<SE3>& T_S_K = problem_.starts[s].T_S_K;
    const Nodes& nodes = nodes_.at({problem_.robot(), s});
    Segment coarse{fine.name, {}};
    for (std::size_t k = 0; k < nodes.ids.size(); ++k) {
      OdometryPose node;
      node.T_O_K = nodes.T_S_N[k];
      if (k > 0) {
        node.T_P_K = nodes.T_S_N[k - 1].inverse() * nodes.T_S_N[k];
        const Variance variance = drift(fine, T_S_K, nodes.ids[k - 1], nodes.ids[k]);
        node.precision = variance.precision();
        steps_ += nodes.ids[k] - nodes.ids[k - 1];
        drift_.rotation += variance.rotation;
        drift_.translation += variance.translation;
      }
      coarse.poses.push_back(node);
    }
    return coarse;
  }

  // Of a loop, seen from nodes so many keyframes away from its ends.
  Precision seen_from(int keyframes, const Precision& loop) const {
    Variance variance = variance_of(loop);
    if (steps_ > 0) {
      variance.rotation += keyframes * drift_.rotation / steps_;
      variance.translation += keyframes * drift_.translation / steps_;
    }
    return variance.precision();
  }

  KeyframeName name(const StartFrame& frame, int node) const {
    return {frame.robot, problem_.members.at(frame.robot).join.segments[frame.segment], node};
  }

  void add_private_loops(GraphSnapshot& coarse) const {
    std::map<std::pair<KeyframeName, KeyframeName>, GraphLoop> edges;
    for (const GraphLoop& loop : problem_.graph.private_loops) {
      const StartFrame a{problem_.robot(), problem_.segment_place(loop.a.segment)};
      const StartFrame b{problem_.robot(), problem_.segment_place(loop.b.segment)};
      const auto& T_W_A = problem_.frames.pose_of(a);
      const auto& T_W_B = problem_.frames.pose_of(b);
      if (!T_W_A || !T_W_B) continue;
      const int n = nodes_.at(a).nearest(loop.a.id);
      const int m = nodes_.at(b).nearest(loop.b.id);
      if (a == b && std::abs(n - m) <= 1) continue;
      const SE3 T_W_a = *T_W_A * problem_.starts[a.segment].T_S_K[loop.a.id];
      const SE3 T_W_b = *T_W_B * problem_.starts[b.segment].T_S_K[loop.b.id];
      if (squared_residual(loop.T_A_B, loop.precision, T_W_a, T_W_b) > options_.barc2) continue;
      const KeyframeName from = name(a, n);
      const KeyframeName to = name(b, m);
      const int keyframes =
          std::abs(nodes_.at(a).ids[n] - loop.a.id) + std::abs(nodes_.at(b).ids[m] - loop.b.id);
      edges.try_emplace({from, to},
                        GraphLoop{edges.size(), from, to,
                                  (*T_W_A * nodes_.at(a).T_S_N[n]).inverse() * *T_W_B * nodes_.at(b).T_S_N[m],
                                  seen_from(keyframes, loop.precision)});
    }
    for (const auto& [ends, edge] : edges) coarse.private_loops.push_back(edge);
  }

  // The loops between two pieces, the first the lower robot's.
  struct Bundle {
    std::vector<SE3> candidates;  // for T_n_m
    Precision precision;
    int keyframes = 0;  // from the nodes to the first loop's ends
  };
  using BundleName = std::tuple<KeyframeName, KeyframeName, bool>;  // nodes, known inliers

  void add_shared_loops(GraphSnapshot& coarse) const {
    std::map<int, std::map<BundleName, Bundle>> bundles;
    for (const SharedLoop& end : problem_.ends) add_to_bundle(end, bundles[end.peer]);
    for (const auto& [peer, of_peer] : bundles) {
      for (const auto& [nodes, bundle] : of_peer) {
        const auto& [from, to, known_inlier] = nodes;
        const AlignmentResult agreed = align_pair(bundle.candidates, options_.alignment);
        auto& loops = coarse.shared_loops[peer];
        loops.push_back({loops.size(), from, to, agreed.T_A_B, seen_from(bundle.keyframes, bundle.precision),
                         known_inlier});
      }
    }
  }

  void add_to_bundle(const SharedLoop& end, std::map<BundleName, Bundle>& bundles) const {
    const bool mine_is_lower = problem_.robot() < end.peer;
    const int lower = mine_is_lower ? problem_.robot() : end.peer;
    const int higher = mine_is_lower ? end.peer : problem_.robot();
    const OpenedMember& member_a = problem_.members.at(lower);
    const OpenedMember& member_b = problem_.members.at(higher);
    const int place_a = mine_is_lower ? end.my_place : end.peer_place;
    const int place_b = mine_is_lower ? end.peer_place : end.my_place;
    const StartFrame a{lower, member_a.segments[place_a]};
    const StartFrame b{higher, member_b.segments[place_b]};
    const auto& T_W_A = problem_.frames.pose_of(a);
    const auto& T_W_B = problem_.frames.pose_of(b);
    if (!T_W_A || !T_W_B) return;
    const bool forward = end.loop.a.robot == lower;
    const SE3 T_i_j = forward ? end.loop.T_A_B : end.loop.T_A_B.inverse();
    const SE3& T_A_i = member_a.T_S_K[place_a];
    const SE3& T_B_j = member_b.T_S_K[place_b];
    const SE3 found = (*T_W_A * T_A_i).inverse() * *T_W_B * T_B_j;
    if (!explained_by_drift(found, T_i_j, extents_.at(a), extents_.at(b)) && !end.loop.known_inlier) return;
    const int id_a = forward ? end.loop.a.id : end.loop.b.id;
    const int id_b = forward ? end.loop.b.id : end.loop.a.id;
    const int n = nodes_.at(a).nearest(id_a);
    const int m = nodes_.at(b).nearest(id_b);
    const auto [bundle, fresh] = bundles.try_emplace(
        {name(a, n), name(b, m), end.loop.known_inlier},
        Bundle{{},
               end.loop.precision,
               std::abs(nodes_.at(a).ids[n] - id_a) + std::abs(nodes_.at(b).ids[m] - id_b)});
    bundle->second.candidates.push_back(nodes_.at(a).T_S_N[n].inverse() * T_A_i * T_i_j * T_B_j.inverse() *
                                        nodes_.at(b).T_S_N[m]);
  }

  const AgreedProblem& problem_;
  const CoarseOptions& options_;
  std::map<StartFrame, Nodes> nodes_;
  std::map<StartFrame, FrameExtent> extents_;
  int steps_ = 0;
  Variance drift_;  // over all own steps between nodes
};

// A segment whose nodes have moved.
class Bend {
 public:
  Bend(const Nodes& nodes, std::vector<SE3> moved) : nodes_(nodes), moved_(std::move(moved)) {}

  SE3 operator()(int id, const SE3& T_S_K) const {
    const auto next = std::upper_bound(nodes_.ids.begin(), nodes_.ids.end(), id);
    const std::size_t k = next - nodes_.ids.begin();
    const SE3 by_last = by(k - 1, T_S_K);
    if (next == nodes_.ids.end()) return by_last;
    const double s = static_cast<double>(id - nodes_.ids[k - 1]) / (nodes_.ids[k] - nodes_.ids[k - 1]);
    return interpolate(by_last, by(k, T_S_K), s);
  }

 private:
  SE3 by(std::size_t k, const SE3& T_S_K) const { return moved_[k] * nodes_.T_S_N[k].inverse() * T_S_K; }

  const Nodes& nodes_;
  std::vector<SE3> moved_;
};

void bend_segment(const StartFrame& frame, const Nodes& nodes, const std::vector<SE3>& moved,
                  AgreedProblem& problem) {
  const Bend bend(nodes, moved);
  OpenedMember& member = problem.members.at(frame.robot);
  const auto end = member.places.lower_bound({frame.segment + 1, 0});
  for (auto place = member.places.lower_bound({frame.segment, 0}); place != end; ++place) {
    SE3& T_S_K = member.T_S_K[place->second];
    T_S_K = bend(place->first.second, T_S_K);
  }
  if (frame.robot != problem.robot()) return;
  std::vector<SE3>& own = problem.starts[frame.segment].T_S_K;
  for (std::size_t id = 0; id < own.size(); ++id) own[id] = bend(static_cast<int>(id), own[id]);
}

}  // namespace

bool wants_bending(const AgreedProblem& problem, const CoarseOptions& options) {
  if (options.alignment.dimension != 2) return false;
  int shared = 0;
  for (const int robot : problem.part) {
    const dpgo_join_t& join = problem.members.at(robot).join;
    const auto from_odometry = [](std::int64_t solution) { return solution == 0; };
    if (!std::all_of(join.solutions.begin(), join.solutions.end(), from_odometry)) return false;
    for (std::size_t k = 0; k < join.peers.size(); ++k) {
      if (std::binary_search(problem.part.begin(), problem.part.end(), join.peers[k]))
        shared += join.loops[k];
    }
  }
  return shared >= options.least_loops * static_cast<int>(problem.part.size());
}

std::vector<int> coarse_nodes(const OpenedMember& member, int segment, const CoarseOptions& options) {
  const bool none = member.places.lower_bound({segment, 0}) == member.places.lower_bound({segment + 1, 0});
  return none ? std::vector<int>{} : nodes_of(member, segment, options).ids;
}

AgreedProblem coarse_problem(const AgreedProblem& problem, const CoarseOptions& options) {
  AgreedProblem coarse;
  coarse.name = problem.name;
  coarse.part = problem.part;
  coarse.members = problem.members;
  coarse.graph = CoarseGraph(problem, options).snapshot();
  return coarse;
}

void bend_starts(const dpgo_poses_t& message, const CoarseOptions& options, AgreedProblem& problem) {
  problem.bent = true;
  std::map<StartFrame, Nodes> nodes;
  for (int s = 0; s < message.n_segments; ++s) {
    const StartFrame frame{message.robots[s], message.segments[s]};
    if (problem.frames.has(frame))
      nodes.emplace(frame, nodes_of(problem.members.at(frame.robot), frame.segment, options));
  }
  int first = 0;
  for (int s = 0; s < message.n_segments; first += message.poses[s++]) {
    const StartFrame frame{message.robots[s], message.segments[s]};
    const StartFrame anchor{message.anchors[s], message.anchor_segments[s]};
    const auto of_frame = nodes.find(frame);
    const auto of_anchor = nodes.find(anchor);
    if (of_frame == nodes.end() || of_anchor == nodes.end()) continue;
    const auto& T_W_S = problem.frames.pose_of(frame);
    const auto& T_W_A = problem.frames.pose_of(anchor);
    if (!T_W_S || !T_W_A || message.poses[s] != static_cast<int>(of_frame->second.ids.size())) continue;
    const SE3 T_S_F = T_W_S->inverse() * *T_W_A * of_anchor->second.T_S_N.front();
    std::vector<SE3> moved;
    for (int k = 0; k < message.poses[s]; ++k)
      moved.push_back(T_S_F * pose_from_floats(message.values, first + k, message.dimension));
    bend_segment(frame, of_frame->second, moved, problem);
  }
}

}  // namespace covey::pgo
