// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/elected.h"

#include <algorithm>
#include <limits>
#include <set>
#include <utility>

#include "core/base/error.h"
#include "core/pgo/central.h"
#include "core/pgo/cost.h"
#include "core/pgo/start.h"
#include "core/pgo/start_frames.h"
#include "core/pgo/team_split.h"

namespace covey::pgo {
namespace {

constexpr float kNoResidual = std::numeric_limits<float>::infinity();

// All parts as one pose graph, in which each segment is a robot of its own.
struct Whole {
  PoseGraph graph;
  std::vector<StartFrame> segments;
  std::map<StartFrame, int> index;
  std::vector<int> edge_of_loop;  // part after part; -1: its ends are not there
};

void add_segments(const dpgo_graph_t& part, Whole& whole) {
  for (int s = 0; s < part.n_segments; ++s) {
    whole.index[{part.from, s}] = static_cast<int>(whole.segments.size());
    whole.segments.push_back({part.from, s});
    whole.graph.poses_per_robot.push_back(part.poses[s]);
  }
}

class EdgeReader {
 public:
  // kappa_scale: from the precisions of the messages to those of a PoseGraph.
  EdgeReader(const dpgo_graph_t& part, double kappa_scale) : part_(part), kappa_scale_(kappa_scale) {}

  Edge next(PoseId from, PoseId to, EdgeKind kind, bool known_inlier) {
    const Precision precision = precision_at(part_, k_);
    const SE3 measurement = pose_from_floats(part_.values, k_++, part_.dimension);
    return {from, to, measurement, kappa_scale_ * precision.kappa, precision.tau, kind, known_inlier};
  }

 private:
  const dpgo_graph_t& part_;
  double kappa_scale_;
  int k_ = 0;
};

void add_edges(const dpgo_graph_t& part, double kappa_scale, Whole& whole) {
  EdgeReader reader(part, kappa_scale);
  std::vector<Edge>& edges = whole.graph.edges;
  for (int s = 0; s < part.n_segments; ++s) {
    const int robot = whole.index.at({part.from, s});
    for (int id = 1; id < part.poses[s]; ++id) {
      edges.push_back(reader.next({robot, id - 1}, {robot, id}, EdgeKind::kOdometry, true));
    }
  }
  int loop = 0;
  for (int g = 0; g < part.n_groups; ++g) {
    const int a = whole.index.at({part.from, part.segments_a[g]});
    const auto b = whole.index.find({part.robots_b[g], part.segments_b[g]});
    for (int k = 0; k < part.sizes[g]; ++k, ++loop) {
      PoseId from{a, part.ids_a[loop]};
      PoseId to{b == whole.index.end() ? -1 : b->second, part.ids_b[loop]};
      const bool there = to.robot >= 0 && from.index < whole.graph.poses_per_robot[from.robot] &&
                         to.index < whole.graph.poses_per_robot[to.robot];
      if (part.reversed[g] != 0) std::swap(from, to);
      const Edge edge = reader.next(from, to, EdgeKind::kLoop, part.known_inliers[g] != 0);
      whole.edge_of_loop.push_back(there ? static_cast<int>(edges.size()) : -1);
      if (there) edges.push_back(edge);
    }
  }
}

Whole assemble(const std::vector<dpgo_graph_t>& parts, const ElectedOptions& options) {
  Whole whole;
  whole.graph.dimension = options.dimension;
  for (const dpgo_graph_t& part : parts) add_segments(part, whole);
  const double kappa_scale = options.dimension == 2 ? 2.0 : 1.0;  // robust_form's half is taken back
  for (const dpgo_graph_t& part : parts) add_edges(part, kappa_scale, whole);
  return whole;
}

struct Solved {
  Poses poses;                              // relative to the first of the anchor's
  std::vector<std::optional<int>> anchors;  // per segment, the segment that is the frame
  std::vector<double> weights;              // per edge
  int iterations = 0;
};

// One part of the team: the segments that have a place among its frames, in W.
void solve_connected(const Whole& whole, const StartFrames& frames, const Poses& odometry,
                     const ElectedOptions& options, Solved& solved) {
  const std::vector<int> offsets = whole.graph.offsets();
  PoseGraph graph = whole.graph;
  Poses start;
  for (int s = 0; s < graph.robots(); ++s) {
    const auto& T_W_S = frames.pose_of(whole.segments[s]);
    if (!T_W_S) {
      graph.poses_per_robot[s] = 0;
      continue;
    }
    for (int flat = offsets[s]; flat < offsets[s + 1]; ++flat) start.push_back(*T_W_S * odometry[flat]);
  }
  std::vector<int> edges;
  graph.edges.clear();
  for (std::size_t e = 0; e < whole.graph.edges.size(); ++e) {
    const Edge& edge = whole.graph.edges[e];
    if (graph.poses_per_robot[edge.from.robot] == 0 || graph.poses_per_robot[edge.to.robot] == 0) continue;
    graph.edges.push_back(edge);
    edges.push_back(static_cast<int>(e));
  }

  const CentralResult result =
      solve_robust(graph, start, {.barc2 = options.barc2, .mu_step = options.mu_step});
  solved.iterations += result.iterations;
  for (std::size_t k = 0; k < edges.size(); ++k) solved.weights[edges[k]] = result.weights[k];
  const int anchor = whole.index.at(frames.root());
  const std::vector<int> placed = graph.offsets();
  const SE3 T_F_W = result.poses[placed[anchor]].inverse();
  for (int s = 0; s < graph.robots(); ++s) {
    if (graph.poses_per_robot[s] == 0) continue;
    solved.anchors[s] = anchor;
    for (int k = 0; k < graph.poses_per_robot[s]; ++k)
      solved.poses[offsets[s] + k] = T_F_W * result.poses[placed[s] + k];
  }
}

Solved solve_whole(const Whole& whole, const ElectedOptions& options) {
  Solved solved;
  solved.poses.resize(whole.graph.poses());
  solved.anchors.resize(whole.segments.size());
  solved.weights.assign(whole.graph.edges.size(), 0.0);
  const std::vector<PairAlignment> alignments = robust_start(whole.graph, options.alignment).alignments;
  const Poses odometry = odometry_start(whole.graph);
  StartFrames frames;
  for (const StartFrame& segment : whole.segments) frames.add(segment, 0);
  std::set<int> robots;  // whose part is solved
  for (const StartFrame& segment : whole.segments) {
    if (robots.count(segment.robot) > 0) continue;
    const std::vector<int> part = frames.place(alignments, segment.robot);
    robots.insert(part.begin(), part.end());
    solve_connected(whole, frames, odometry, options, solved);
  }
  return solved;
}

void write_poses(const Whole& whole, const Solved& solved, dpgo_poses_t& message) {
  const std::vector<int> offsets = whole.graph.offsets();
  for (std::size_t s = 0; s < whole.segments.size(); ++s) {
    const StartFrame none{-1, 0};
    const StartFrame& anchor = solved.anchors[s] ? whole.segments[*solved.anchors[s]] : none;
    message.robots.push_back(whole.segments[s].robot);
    message.segments.push_back(static_cast<std::int16_t>(whole.segments[s].segment));
    message.anchors.push_back(anchor.robot);
    message.anchor_segments.push_back(static_cast<std::int16_t>(anchor.segment));
    message.poses.push_back(solved.anchors[s] ? whole.graph.poses_per_robot[s] : 0);
    if (!solved.anchors[s]) continue;
    for (int flat = offsets[s]; flat < offsets[s + 1]; ++flat) {
      append_floats(solved.poses[flat], message.dimension, message.values);
    }
  }
  message.n_segments = static_cast<std::int32_t>(message.robots.size());
  message.n_values = static_cast<std::int32_t>(message.values.size());
}

bool in_one_frame(const Edge& edge, const Solved& solved) {
  const auto& anchor = solved.anchors[edge.from.robot];
  return anchor && anchor == solved.anchors[edge.to.robot];
}

void write_decisions(const std::vector<dpgo_graph_t>& parts, const Whole& whole, const Solved& solved,
                     dpgo_poses_t& message) {
  const PoseGraph form = robust_form(whole.graph);
  const std::vector<double> r2 = squared_residuals(form, solved.poses);
  std::vector<bool> kept;
  std::size_t loop = 0;
  for (const dpgo_graph_t& part : parts) {
    for (int g = 0; g < part.n_groups; ++g) {
      const int b = part.robots_b[g];
      if (message.robots_a.empty() || message.robots_a.back() != part.from || message.robots_b.back() != b) {
        message.robots_a.push_back(part.from);
        message.robots_b.push_back(b);
        message.loops.push_back(0);
      }
      message.loops.back() += part.sizes[g];
      for (int k = 0; k < part.sizes[g]; ++k, ++loop) {
        const int edge = whole.edge_of_loop[loop];
        kept.push_back(edge >= 0 && solved.weights[edge] > 0.5);
        if (part.from != message.from || b == message.from) continue;
        const bool placed = edge >= 0 && in_one_frame(form.edges[edge], solved);
        message.residuals_sq.push_back(placed ? static_cast<float>(r2[edge]) : kNoResidual);
      }
    }
  }
  message.kept = pack_bits(kept);
  message.n_pairs = static_cast<std::int32_t>(message.loops.size());
  message.n_kept = static_cast<std::int32_t>(message.kept.size());
  message.n_residuals = static_cast<std::int32_t>(message.residuals_sq.size());
}

// The poses of a message, segment by segment.
class PlacedSegments {
 public:
  explicit PlacedSegments(const dpgo_poses_t& message) : message_(message) {
    int first = 0;
    for (int s = 0; s < message.n_segments; ++s) {
      first_of_[{message.robots[s], message.segments[s]}] = {s, first};
      first += message.poses[s];
    }
  }

  bool has(const StartFrame& segment) const { return first_of_.count(segment) > 0; }
  int poses(const StartFrame& segment) const { return message_.poses[first_of_.at(segment).place]; }
  StartFrame anchor(const StartFrame& segment) const {
    const int s = first_of_.at(segment).place;
    return {message_.anchors[s], message_.anchor_segments[s]};
  }
  SE3 pose(const StartFrame& segment, int id) const {
    return pose_from_floats(message_.values, first_of_.at(segment).pose + id, message_.dimension);
  }

 private:
  struct First {
    int place = 0;
    int pose = 0;
  };
  const dpgo_poses_t& message_;
  std::map<StartFrame, First> first_of_;
};

// Of a loop whose ends both stand in the message.
double squared_residual_of(const OwnedLoop& owned, int owner, const PlacedSegments& placed) {
  const StartFrame a{owner, owned.segment_a};
  const StartFrame b{owned.robot_b, owned.segment_b};
  if (placed.poses(a) <= owned.id_a || placed.poses(b) <= owned.id_b ||
      placed.anchor(a) != placed.anchor(b)) {
    return kNoResidual;
  }
  const SE3 T_a = placed.pose(a, owned.id_a);
  const SE3 T_b = placed.pose(b, owned.id_b);
  const GraphLoop& loop = *owned.loop;
  const Edge edge{
      {}, {}, loop.T_A_B, loop.precision.kappa, loop.precision.tau, EdgeKind::kLoop, loop.known_inlier};
  return owned.reversed ? squared_residual(edge, T_b, T_a) : squared_residual(edge, T_a, T_b);
}

const std::vector<GraphLoop>& loops_with(const GraphSnapshot& graph, int peer) {
  static const std::vector<GraphLoop> kNone;
  if (peer == graph.robot) return graph.private_loops;
  const auto found = graph.shared_loops.find(peer);
  return found == graph.shared_loops.end() ? kNone : found->second;
}

}  // namespace

Gathered solve_parts(const std::vector<dpgo_graph_t>& parts, const ElectedOptions& options) {
  COVEY_CHECK(!parts.empty());
  const Whole whole = assemble(parts, options);
  const Solved solved = solve_whole(whole, options);
  dpgo_poses_t message{};
  message.from = parts.front().from;
  message.to = -1;
  message.dimension = static_cast<std::int8_t>(options.dimension);
  write_poses(whole, solved, message);
  write_decisions(parts, whole, solved, message);
  return {std::move(message), solved.iterations};
}

dpgo_poses_t without_own(dpgo_poses_t message) {
  std::ptrdiff_t own = 0;
  for (int s = 0; s < message.n_segments && message.robots[s] == message.from; ++s)
    own += std::exchange(message.poses[s], 0);
  message.values.erase(message.values.begin(),
                       message.values.begin() + own * floats_per_pose(message.dimension));
  message.n_values = static_cast<std::int32_t>(message.values.size());
  return message;
}

std::optional<ElectedShare> share_of(const dpgo_poses_t& message, const GraphSnapshot& graph,
                                     const SegmentNames& names) {
  const PlacedSegments placed(message);
  ElectedShare share;
  for (int s = 0; s < static_cast<int>(graph.segments.size()); ++s) {
    const StartFrame segment{graph.robot, s};
    if (!placed.has(segment)) return std::nullopt;
    const int poses = placed.poses(segment);
    const StartFrame anchor = placed.anchor(segment);
    if (anchor.robot >= 0 && poses != static_cast<int>(graph.segments[s].poses.size())) return std::nullopt;
    ElectedShare::Placed mine{anchor.robot, anchor.segment, {}};
    for (int id = 0; id < poses; ++id) mine.T_F_K.push_back(placed.pose(segment, id));
    share.segments.push_back(std::move(mine));
  }
  int loop = 0;
  int residual = 0;  // of the sender's with other robots
  for (int p = 0; p < message.n_pairs; ++p) {
    const int a = message.robots_a[p];
    const int b = message.robots_b[p];
    const bool of_sender = a == message.from && b != a;
    const int first_loop = std::exchange(loop, loop + message.loops[p]);
    const int first_residual = std::exchange(residual, residual + (of_sender ? message.loops[p] : 0));
    if (a != graph.robot && b != graph.robot) continue;
    const std::vector<OwnedLoop> owned =
        in_message_order(loops_with(graph, a == graph.robot ? b : a), a, names);
    if (static_cast<int>(owned.size()) != message.loops[p] || residual > message.n_residuals)
      return std::nullopt;
    for (int k = 0; k < message.loops[p]; ++k) {
      const double r2 =
          of_sender ? message.residuals_sq[first_residual + k] : squared_residual_of(owned[k], a, placed);
      share.loops.push_back({*owned[k].loop, bit_at(message.kept, first_loop + k), r2});
    }
  }
  return share;
}

ElectedResult solve_elected(const PoseGraph& graph, const ElectedOptions& options) {
  const std::map<int, TeamMember> team = split_team(graph, std::nullopt);
  COVEY_CHECK(!team.empty());
  SegmentNames names;
  for (const auto& [robot, member] : team) {
    for (const Segment& segment : member.graph.segments) names[robot].push_back(segment.name);
  }
  ElectedResult result;
  DistributedResult& evidence = result.team;
  std::vector<dpgo_graph_t> parts;
  for (const auto& [robot, member] : team) {
    parts.push_back(part_of(member.graph, names, options.dimension));
    if (parts.size() > 1) evidence.bytes[dpgo_graph_t::getTypeName()] += parts.back().getEncodedSize();
  }
  const Gathered gathered = solve_parts(parts, options);
  const dpgo_poses_t sent = without_own(gathered.poses);
  if (team.size() > 1) evidence.bytes[dpgo_poses_t::getTypeName()] += sent.getEncodedSize();
  result.iterations = gathered.iterations;
  evidence.messages = 2;

  std::map<int, std::vector<SegmentResult>> segments;
  evidence.weights.assign(graph.edges.size(), 1.0);
  for (const auto& [robot, member] : team) {
    const bool elected = robot == parts.front().from;
    const auto share = share_of(elected ? gathered.poses : sent, member.graph, names);
    COVEY_CHECK(share.has_value());
    for (std::size_t s = 0; s < share->segments.size(); ++s) {
      const ElectedShare::Placed& placed = share->segments[s];
      segments[robot].push_back(
          {member.graph.segments[s].name, placed.anchor == parts.front().from, placed.T_F_K});
    }
    for (const ElectedShare::Decision& decision : share->loops)
      evidence.weights[decision.loop.key] = decision.kept;
  }
  evidence.poses = gather_poses(graph, team, segments);
  evidence.placed = gather_placed(graph, team, segments);
  const std::vector<double> r2 = squared_residuals(graph, evidence.poses);
  const std::vector<int> offsets = graph.offsets();
  for (std::size_t e = 0; e < graph.edges.size(); ++e) {
    const Edge& edge = graph.edges[e];
    if (!evidence.placed[offsets[edge.from.robot] + edge.from.index]) continue;
    if (!evidence.placed[offsets[edge.to.robot] + edge.to.index]) continue;
    evidence.cost += edge.known_inlier ? r2[e] : std::min(r2[e], options.barc2);
    if (edge.kind == EdgeKind::kLoop && evidence.weights[e] == 1.0) ++evidence.kept;
  }
  return result;
}

}  // namespace covey::pgo
