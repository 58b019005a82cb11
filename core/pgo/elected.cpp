// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/elected.h"

#include <algorithm>
#include <limits>
#include <set>
#include <utility>

#include "core/base/error.h"
#include "core/pgo/central.h"
#include "core/pgo/cost.h"
#include "core/pgo/measured_noise.h"
#include "core/pgo/start.h"
#include "core/pgo/start_frames.h"

namespace covey::pgo {
namespace {

constexpr float kNoResidual = std::numeric_limits<float>::infinity();

// All parts as one pose graph, in which each segment is a robot of its own.
struct Whole {
  PoseGraph graph;
  MeasuredNoise noise;  // with full covariances
  std::vector<StartFrame> segments;
  std::map<StartFrame, int> index;
  std::vector<int> edge_of_loop;  // part after part; -1: its ends are not there
};

void add_segments(const dpgo_graph_t& part, const ElectedOptions& options, Whole& whole) {
  int keyframes = 0;
  for (int s = 0; s < part.n_segments; ++s) {
    whole.index[{part.from, s}] = static_cast<int>(whole.segments.size());
    whole.segments.push_back({part.from, s});
    whole.graph.poses_per_robot.push_back(part.poses[s]);
    for (int id = 0; options.packing.full_covariances && id < part.poses[s]; ++id) {
      whole.noise.gravity.push_back(gravity_at(part, keyframes++));
    }
  }
}

// Takes the measurements of a part one after the other.
class EdgeReader {
 public:
  EdgeReader(const dpgo_graph_t& part, const ElectedOptions& options, Whole& whole)
      : part_(part), options_(options), whole_(whole) {}

  // The index of the edge; -1 and nothing added where it is not wanted.
  int next(PoseId from, PoseId to, EdgeKind kind, bool known_inlier, bool wanted) {
    const int k = k_++;
    if (!wanted) return -1;
    Precision precision;
    if (options_.packing.full_covariances) {
      whole_.noise.covariances.push_back(covariance_at(part_, k));
      precision = precision_of(deciding_covariance(whole_.noise.covariances.back(), options_.noise));
    } else {
      precision = precision_at(part_, k);
    }
    if (options_.packing.dimension == 2) precision.kappa *= 2.0;  // robust_form's half is taken back
    whole_.graph.edges.push_back({from, to, pose_from_floats(part_.values, k, part_.dimension),
                                  precision.kappa, precision.tau, kind, known_inlier});
    return static_cast<int>(whole_.graph.edges.size()) - 1;
  }

 private:
  const dpgo_graph_t& part_;
  const ElectedOptions& options_;
  Whole& whole_;
  int k_ = 0;
};

void add_edges(const dpgo_graph_t& part, const ElectedOptions& options, Whole& whole) {
  EdgeReader reader(part, options, whole);
  for (int s = 0; s < part.n_segments; ++s) {
    const int robot = whole.index.at({part.from, s});
    for (int id = 1; id < part.poses[s]; ++id) {
      reader.next({robot, id - 1}, {robot, id}, EdgeKind::kOdometry, true, true);
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
      whole.edge_of_loop.push_back(
          reader.next(from, to, EdgeKind::kLoop, part.known_inliers[g] != 0, there && from != to));
    }
  }
}

Whole assemble(const std::vector<dpgo_graph_t>& parts, const ElectedOptions& options) {
  Whole whole;
  whole.graph.dimension = options.packing.dimension;
  for (const dpgo_graph_t& part : parts) add_segments(part, options, whole);
  for (const dpgo_graph_t& part : parts) add_edges(part, options, whole);
  return whole;
}

struct Solved {
  Poses poses;                              // relative to the first of the anchor's
  std::vector<std::optional<int>> anchors;  // per segment, the segment that is the frame
  std::vector<double> weights;              // per edge
  std::vector<double> r2;                   // per edge; infinite where it is not in one frame
  int iterations = 0;
};

// Those segments of the whole that have a place among the frames, and where their edges and poses stand in it.
struct Selection {
  PoseGraph graph;
  MeasuredNoise noise;
  Poses start;
  std::vector<int> edges;
};

Selection select(const Whole& whole, const StartFrames& frames, const Poses& odometry) {
  const std::vector<int> offsets = whole.graph.offsets();
  Selection selection{whole.graph, {}, {}, {}};
  PoseGraph& graph = selection.graph;
  for (int s = 0; s < graph.robots(); ++s) {
    const auto& T_W_S = frames.pose_of(whole.segments[s]);
    if (!T_W_S) {
      graph.poses_per_robot[s] = 0;
      continue;
    }
    for (int flat = offsets[s]; flat < offsets[s + 1]; ++flat) {
      selection.start.push_back(*T_W_S * odometry[flat]);
      if (!whole.noise.gravity.empty()) selection.noise.gravity.push_back(whole.noise.gravity[flat]);
    }
  }
  graph.edges.clear();
  for (std::size_t e = 0; e < whole.graph.edges.size(); ++e) {
    const Edge& edge = whole.graph.edges[e];
    if (graph.poses_per_robot[edge.from.robot] == 0 || graph.poses_per_robot[edge.to.robot] == 0) continue;
    graph.edges.push_back(edge);
    if (!whole.noise.covariances.empty()) selection.noise.covariances.push_back(whole.noise.covariances[e]);
    selection.edges.push_back(static_cast<int>(e));
  }
  return selection;
}

// As the cost of the selection has it; the pose `gauge` stays at its start.
MeasuredResult solve_selection(const Selection& selection, int gauge, const ElectedOptions& options) {
  if (options.packing.full_covariances) {
    return solve_measured(selection.graph, selection.noise, selection.start,
                          {.noise = options.noise,
                           .barc2 = options.barc2,
                           .mu_step = options.mu_step,
                           .each_step = options.each_step,
                           .gauge = gauge});
  }
  MeasuredResult result;
  result.central =
      solve_robust(selection.graph, selection.start,
                   {.barc2 = options.barc2, .mu_step = options.mu_step, .each_step = options.each_step});
  result.r2 = squared_residuals(robust_form(selection.graph), result.central.poses);
  const SE3 T_back = selection.start[gauge] * result.central.poses[gauge].inverse();
  for (SE3& T : result.central.poses) T = T_back * T;
  return result;
}

// One part of the team: the segments that have a place among its frames.
void solve_connected(const Whole& whole, const StartFrames& frames, const Poses& odometry,
                     const ElectedOptions& options, Solved& solved) {
  const Selection selection = select(whole, frames, odometry);
  const int anchor = whole.index.at(frames.root());
  const std::vector<int> placed = selection.graph.offsets();
  const MeasuredResult result = solve_selection(selection, placed[anchor], options);
  solved.iterations += result.central.iterations;
  for (std::size_t k = 0; k < selection.edges.size(); ++k) {
    solved.weights[selection.edges[k]] = result.central.weights[k];
    solved.r2[selection.edges[k]] = result.r2[k];
  }
  const SE3 T_F_W = selection.start[placed[anchor]].inverse();
  const std::vector<int> offsets = whole.graph.offsets();
  for (int s = 0; s < selection.graph.robots(); ++s) {
    if (selection.graph.poses_per_robot[s] == 0) continue;
    solved.anchors[s] = anchor;
    for (int k = 0; k < selection.graph.poses_per_robot[s]; ++k) {
      solved.poses[offsets[s] + k] = T_F_W * result.central.poses[placed[s] + k];
    }
  }
}

Solved solve_whole(const Whole& whole, const ElectedOptions& options) {
  Solved solved;
  solved.poses.resize(whole.graph.poses());
  solved.anchors.resize(whole.segments.size());
  solved.weights.assign(whole.graph.edges.size(), 0.0);
  solved.r2.assign(whole.graph.edges.size(), std::numeric_limits<double>::infinity());
  const RobustStart start = robust_start(whole.graph, options.alignment);
  const Poses odometry = odometry_start(whole.graph);
  StartFrames frames;
  for (std::size_t s = 0; s < whole.segments.size(); ++s) frames.add(whole.segments[s], 0, start.extents[s]);
  std::set<int> robots;  // whose part is solved
  for (const StartFrame& segment : whole.segments) {
    if (robots.count(segment.robot) > 0) continue;
    const std::vector<int> part = frames.place(start.alignments, segment.robot);
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

void write_decisions(const std::vector<dpgo_graph_t>& parts, const Whole& whole, const Solved& solved,
                     dpgo_poses_t& message) {
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
        message.residuals_sq.push_back(edge >= 0 ? static_cast<float>(solved.r2[edge]) : kNoResidual);
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
double squared_residual_of(const OwnedLoop& owned, int owner, const PlacedSegments& placed,
                           const ElectedOptions& options) {
  const StartFrame a{owner, owned.segment_a};
  const StartFrame b{owned.robot_b, owned.segment_b};
  if (placed.poses(a) <= owned.id_a || placed.poses(b) <= owned.id_b ||
      placed.anchor(a) != placed.anchor(b)) {
    return kNoResidual;
  }
  const SE3 T_a = placed.pose(a, owned.id_a);
  const SE3 T_b = placed.pose(b, owned.id_b);
  const GraphLoop& loop = *owned.loop;
  return owned.reversed
             ? deciding_residual_sq(loop.T_A_B, loop.precision, loop.covariance, T_b, T_a, options)
             : deciding_residual_sq(loop.T_A_B, loop.precision, loop.covariance, T_a, T_b, options);
}

const std::vector<GraphLoop>& loops_with(const GraphSnapshot& graph, int peer) {
  static const std::vector<GraphLoop> kNone;
  if (peer == graph.robot) return graph.private_loops;
  const auto found = graph.shared_loops.find(peer);
  return found == graph.shared_loops.end() ? kNone : found->second;
}

}  // namespace

double deciding_residual_sq(const SE3& T_A_B, const Precision& precision, const Matrix6d& covariance,
                            const SE3& T_W_A, const SE3& T_W_B, const ElectedOptions& options) {
  if (options.packing.full_covariances) {
    return mahalanobis_sq(T_A_B, deciding_covariance(covariance, options.noise), T_W_A, T_W_B);
  }
  return squared_residual(T_A_B, precision, T_W_A, T_W_B);
}

Gathered solve_parts(const std::vector<dpgo_graph_t>& parts, const ElectedOptions& options) {
  COVEY_CHECK(!parts.empty());
  const Whole whole = assemble(parts, options);
  const Solved solved = solve_whole(whole, options);
  dpgo_poses_t message{};
  message.from = parts.front().from;
  message.to = -1;
  message.dimension = static_cast<std::int8_t>(options.packing.dimension);
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
                                     const SegmentNames& names, const ElectedOptions& options) {
  const PlacedSegments placed(message);
  ElectedShare share;
  for (int s = 0; s < static_cast<int>(graph.segments.size()); ++s) {
    const StartFrame segment{graph.robot, s};
    if (!placed.has(segment)) return std::nullopt;
    const int poses = placed.poses(segment);
    const StartFrame anchor = placed.anchor(segment);
    const auto of_anchor = names.find(anchor.robot);
    if (anchor.robot >= 0 && (of_anchor == names.end() || anchor.segment < 0 ||
                              anchor.segment >= static_cast<int>(of_anchor->second.size()))) {
      return std::nullopt;
    }
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
      const double r2 = of_sender ? message.residuals_sq[first_residual + k]
                                  : squared_residual_of(owned[k], a, placed, options);
      share.loops.push_back({*owned[k].loop, bit_at(message.kept, first_loop + k), r2});
    }
  }
  return share;
}

}  // namespace covey::pgo
