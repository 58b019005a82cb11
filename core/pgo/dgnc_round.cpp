// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/dgnc_round.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <utility>

#include "core/base/error.h"
#include "core/pgo/gnc_stages.h"
#include "core/pgo/hash.h"
#include "core/pgo/momentum.h"
#include "core/pgo/public_poses.h"
#include "core/pgo/start_frames.h"
#include "core/pgo/tls.h"

namespace covey::pgo {
namespace {

enum class Phase { kJoin, kKeys, kStart, kAlignment, kUpdate, kDone };

std::int64_t hash_of(const std::vector<GraphLoop>& loops) {
  Hash hash;
  for (const GraphLoop& loop : loops) hash.add(loop.key);
  return static_cast<std::int64_t>(hash.value());
}

double residual_sq(const SE3& T_W_A, const SE3& T_W_B, const SE3& T_A_B, const Precision& precision) {
  const SE3 predicted = T_W_A * T_A_B;
  return precision.kappa * (T_W_B.rotation.matrix() - predicted.rotation.matrix()).squaredNorm() +
         precision.tau * (T_W_B.translation - predicted.translation).squaredNorm();
}

// A public keyframe's place in dpgo_start_t, by (place of its segment, id).
using Places = std::map<std::pair<int, int>, int>;

// What is known of a member of the round, this robot included.
struct Member {
  dpgo_join_t join;
  Places places;
  std::vector<SE3> start;  // public keyframes, in the frames of their segments' starts, as sent
  std::vector<int> start_segments;
  Lifted now;     // public keyframes as sent, r x 4m
  Lifted before;  // one update earlier
  double cost = 0.0;
  double decrease = 0.0;
  double overshoot = 0.0;
  double max_r2 = 0.0;
  int undecided = 0;
};

struct SharedEnd {  // of shared loop e, in the order of BlockSolver::shared()
  GraphLoop loop;
  int peer;
  int my_place;
  int peer_place;
};

}  // namespace

std::int64_t frame_name(const RoundName& name, int anchor, Utime segment) {
  Hash hash;
  hash.add(static_cast<std::uint64_t>(name.number));
  hash.add(static_cast<std::uint64_t>(name.anchor));
  hash.add(static_cast<std::uint64_t>(anchor));
  hash.add(static_cast<std::uint64_t>(segment));
  return static_cast<std::int64_t>(hash.value() | 1U);  // 0 means none
}

struct DgncRound::State {
  RoundName name;
  std::vector<int> members;
  GraphSnapshot graph;
  std::vector<SegmentStart> starts;
  double start_mu;
  DgncOptions options;

  Phase phase = Phase::kJoin;
  int number = -1;
  std::map<int, std::map<int, RoundMessage>> inbox;  // by sender, by number
  std::map<int, RoundMessage> sent;                  // the last two, and those at partings
  std::set<int> partings;                            // numbers after which this part waits for fewer
  std::vector<RoundMessage> outgoing;

  // Whose messages are waited for: all members, then those with my options, then of these those connected to me.
  std::vector<int> part;
  std::map<int, Member> known;
  std::vector<int> offsets;       // of each segment's first pose in the block
  std::vector<int> public_index;  // of each public keyframe, in the block
  std::vector<SharedEnd> ends;
  std::vector<GraphLoop> private_loops;
  StartFrames frames;
  std::vector<std::string> warnings;

  std::unique_ptr<BlockSolver> solver;
  int odometry_edges = 0;  // the solver's private edges begin with them, then come the private loops
  Lifted X;
  Lifted X_before;
  Eigen::VectorXd loop_weights;  // private loops
  Eigen::VectorXd shared_weights;
  GncStages stages;
  Momentum momentum;
  int my_undecided = 0;
  int updates = 0;
  RoundResult result;

  State(const RoundName& name_in, std::vector<int> members_in, GraphSnapshot graph_in,
        std::vector<SegmentStart> starts_in, double start_mu_in, const DgncOptions& options_in)
      : name(name_in),
        members(std::move(members_in)),
        graph(std::move(graph_in)),
        starts(std::move(starts_in)),
        start_mu(start_mu_in),
        options(options_in),
        part(members),
        stages(options_in) {}

  int me() const { return graph.robot; }
  Member& self() { return known[me()]; }

  template <typename T>
  T message() const {
    T m{};
    m.from = me();
    m.to = -1;
    m.round = name.number;
    m.anchor = name.anchor;
    return m;
  }
  template <typename T>
  void send(T m) {
    m.number = ++number;
    inbox[me()].clear();
    inbox[me()].emplace(number, m);
    sent.emplace(number, m);
    if (partings.count(number - 2) == 0) sent.erase(number - 2);
    outgoing.emplace_back(std::move(m));
  }
  // The message of the current number; of the type that the phase wants.
  template <typename T>
  const T& from(int robot) const {
    return std::get<T>(inbox.at(robot).at(number));
  }

  // Messages that are not what the phase wants, of a sender that does not follow the protocol, count as missing.
  bool drop_misfits() {
    bool all_fit = true;
    for (const int robot : part) {
      auto& box = inbox.at(robot);
      if (fits_phase(robot, box.at(number))) continue;
      box.erase(number);
      all_fit = false;
    }
    return all_fit;
  }
  bool fits_phase(int robot, const RoundMessage& m) const {
    switch (phase) {
      case Phase::kJoin:
        return std::holds_alternative<dpgo_join_t>(m);
      case Phase::kKeys:
        return std::holds_alternative<dpgo_keys_t>(m);
      case Phase::kStart: {
        const auto* start = std::get_if<dpgo_start_t>(&m);
        if (start == nullptr) return false;
        // The first keyframe of each segment must be there: one of them will be the origin of W.
        std::set<int> firsts;
        for (int k = 0; k < start->n; ++k) {
          if (start->segments[k] < 0 || start->segments[k] >= known.at(robot).join.n_segments) return false;
          if (start->ids[k] == 0) firsts.insert(start->segments[k]);
        }
        return static_cast<int>(firsts.size()) == known.at(robot).join.n_segments;
      }
      case Phase::kAlignment:
        return std::holds_alternative<dpgo_alignment_t>(m);
      case Phase::kUpdate: {
        const auto* update = std::get_if<dpgo_update_t>(&m);
        return update != nullptr && fits(*update, known.at(robot).now);
      }
      case Phase::kDone:
        break;
    }
    return false;
  }

  // ---- Joining, and agreeing on the loops ----

  void join() {
    dpgo_join_t m = message<dpgo_join_t>();
    m.mu = start_mu;
    for (std::size_t s = 0; s < graph.segments.size(); ++s) {
      m.segments.push_back(graph.segments[s].name);
      m.solutions.push_back(starts[s].solution);
      append_pose(graph.segments[s].poses.front().T_O_K, m.T_O_K);
    }
    m.n_segments = static_cast<std::int32_t>(m.segments.size());
    m.n_values = static_cast<std::int32_t>(m.T_O_K.size());
    for (const auto& [peer, loops] : graph.shared_loops) {
      if (!std::binary_search(members.begin(), members.end(), peer)) continue;
      m.peers.push_back(peer);
      m.loops.push_back(static_cast<std::int32_t>(loops.size()));
      m.hashes.push_back(hash_of(loops));
    }
    m.peers.push_back(me());
    m.loops.push_back(0);
    m.hashes.push_back(static_cast<std::int64_t>(common_hash(options)));
    m.n_peers = static_cast<std::int32_t>(m.peers.size());
    send(std::move(m));
  }

  void take_joins() {
    for (const int robot : members) known[robot].join = from<dpgo_join_t>(robot);
    part_by_options();
    bool differ = false;
    for (const int a : part) {
      for (const int b : part) differ = differ || (a < b && agreed_hash(a, b) != agreed_hash(b, a));
    }
    if (differ) {
      phase = Phase::kKeys;
      send_keys();
    } else {
      agree([](int, const GraphLoop&) { return true; });
    }
  }

  // Members with other options would end their stages elsewhere: each such part goes its own way.
  void part_by_options() {
    std::vector<int> alike;
    for (const int robot : members) {
      if (agreed_hash(robot, robot) == agreed_hash(me(), me())) {
        alike.push_back(robot);
      } else {
        warnings.push_back(
            fmt::format("robot {}'s section dpgo differs from robot {}'s, so they do not solve together; "
                        "give all robots the same",
                        robot, me()));
      }
    }
    continue_with(std::move(alike));
  }

  // Waits for these alone from here on. The others may yet miss the message that all had to have to get here.
  void continue_with(std::vector<int> robots) {
    if (robots.size() < part.size()) partings.insert(number);
    part = std::move(robots);
  }

  std::int64_t agreed_hash(int robot, int peer) const {
    const dpgo_join_t& m = known.at(robot).join;
    const auto found = std::find(m.peers.begin(), m.peers.end(), peer);
    return found == m.peers.end() ? 0 : m.hashes[found - m.peers.begin()];
  }

  void send_keys() {
    dpgo_keys_t m = message<dpgo_keys_t>();
    for (const auto& [peer, loops] : graph.shared_loops) {
      if (!std::binary_search(part.begin(), part.end(), peer)) continue;
      if (agreed_hash(me(), peer) == agreed_hash(peer, me())) continue;
      for (const GraphLoop& loop : loops) {
        m.peers.push_back(peer);
        m.keys.push_back(static_cast<std::int64_t>(loop.key));
      }
    }
    m.n = static_cast<std::int32_t>(m.peers.size());
    send(std::move(m));
  }

  void take_keys() {
    std::map<int, std::set<std::uint64_t>> theirs;
    for (const int robot : part) {
      const dpgo_keys_t& m = from<dpgo_keys_t>(robot);
      for (int k = 0; k < m.n; ++k) {
        if (m.peers[k] == me()) theirs[robot].insert(static_cast<std::uint64_t>(m.keys[k]));
      }
    }
    agree([&](int peer, const GraphLoop& loop) {
      return agreed_hash(me(), peer) == agreed_hash(peer, me()) || theirs[peer].count(loop.key) > 0;
    });
  }

  template <typename Agreed>
  void agree(Agreed agreed) {
    for (auto& [peer, loops] : graph.shared_loops) {
      if (!std::binary_search(part.begin(), part.end(), peer)) {
        loops.clear();
        continue;
      }
      const std::size_t before = loops.size();
      const int other = peer;
      loops.erase(std::remove_if(loops.begin(), loops.end(),
                                 [&](const GraphLoop& loop) { return !agreed(other, loop); }),
                  loops.end());
      const std::size_t lost = before - loops.size();
      if (lost > 0) {
        warnings.push_back(
            fmt::format("{} of {} closures of robots {}-{} are left out: robot {} does not know them", lost,
                        before, std::min(me(), peer), std::max(me(), peer), peer));
      }
    }
    phase = Phase::kStart;
    send_start();
  }

  // ---- Starts and frames ----

  int segment_place(Utime segment) const {
    for (std::size_t s = 0; s < graph.segments.size(); ++s) {
      if (graph.segments[s].name == segment) return static_cast<int>(s);
    }
    return -1;
  }
  const KeyframeName& mine(const GraphLoop& loop) const { return loop.a.robot == me() ? loop.a : loop.b; }
  const KeyframeName& theirs(const GraphLoop& loop) const { return loop.a.robot == me() ? loop.b : loop.a; }

  void send_start() {
    std::set<std::pair<int, int>> names;  // (place of segment, id)
    int poses = 0;
    for (std::size_t s = 0; s < graph.segments.size(); ++s) {
      offsets.push_back(poses);
      poses += static_cast<int>(graph.segments[s].poses.size());
      names.insert({static_cast<int>(s), 0});
    }
    for (const auto& [peer, loops] : graph.shared_loops) {
      for (const GraphLoop& loop : loops) names.insert({segment_place(mine(loop).segment), mine(loop).id});
    }
    dpgo_start_t m = message<dpgo_start_t>();
    std::vector<double> values;
    for (const auto& [segment, id] : names) {
      public_index.push_back(offsets[segment] + id);
      m.segments.push_back(static_cast<std::int16_t>(segment));
      m.ids.push_back(id);
      append_pose(starts[segment].T_S_K[id], values);
    }
    m.n = static_cast<std::int32_t>(m.ids.size());
    m.T_S_K.assign(values.begin(), values.end());
    m.n_values = static_cast<std::int32_t>(m.T_S_K.size());
    send(std::move(m));
  }

  void take_starts() {
    for (const int robot : part) {
      const dpgo_start_t& m = from<dpgo_start_t>(robot);
      Member& member = known[robot];
      for (int k = 0; k < m.n; ++k) {
        member.places[{m.segments[k], m.ids[k]}] = k;
        member.start.push_back(pose_at(m.T_S_K, k));
        member.start_segments.push_back(m.segments[k]);
      }
      for (int s = 0; s < member.join.n_segments; ++s) frames.add({robot, s}, member.join.solutions[s]);
    }
    resolve_loops();
    phase = Phase::kAlignment;
    send_alignment();
  }

  // Finds both ends of each shared loop among the public keyframes.
  void resolve_loops() {
    private_loops = graph.private_loops;
    for (const auto& [peer, loops] : graph.shared_loops) {
      if (loops.empty()) continue;
      const Member& other = known.at(peer);
      for (const GraphLoop& loop : loops) {
        const auto segment =
            std::find(other.join.segments.begin(), other.join.segments.end(), theirs(loop).segment);
        const auto found = segment == other.join.segments.end()
                               ? other.places.end()
                               : other.places.find({static_cast<int>(segment - other.join.segments.begin()),
                                                    theirs(loop).id});
        if (found == other.places.end())
          continue;  // it says that it knows the loop, and not its own end of it
        const int my_place = self().places.at({segment_place(mine(loop).segment), mine(loop).id});
        ends.push_back({loop, peer, my_place, found->second});
      }
    }
  }

  void send_alignment() {
    // Candidates for T_A_B (paper, eq. 4) of each pair of frames a < b whose first robot is this one.
    std::map<std::pair<StartFrame, StartFrame>, std::vector<SE3>> candidates;
    const auto add = [&](const StartFrame& from_frame, const StartFrame& to_frame, const SE3& T_S_from,
                         const SE3& T_S_to, const SE3& measurement) {
      if (frames.same_solution(from_frame, to_frame)) return;
      const SE3 T = T_S_from * measurement * T_S_to.inverse();
      if (from_frame < to_frame) {
        candidates[{from_frame, to_frame}].push_back(T);
      } else {
        candidates[{to_frame, from_frame}].push_back(T.inverse());
      }
    };
    for (const SharedEnd& end : ends) {
      if (end.peer < me()) continue;
      const StartFrame my_frame{me(), self().start_segments[end.my_place]};
      const StartFrame peer_frame{end.peer, known.at(end.peer).start_segments[end.peer_place]};
      const SE3& T_mine = self().start[end.my_place];
      const SE3& T_peer = known.at(end.peer).start[end.peer_place];
      if (end.loop.a.robot == me()) {
        add(my_frame, peer_frame, T_mine, T_peer, end.loop.T_A_B);
      } else {
        add(peer_frame, my_frame, T_peer, T_mine, end.loop.T_A_B);
      }
    }
    for (const GraphLoop& loop : private_loops) {
      const int a = segment_place(loop.a.segment);
      const int b = segment_place(loop.b.segment);
      if (a == b) continue;
      add({me(), a}, {me(), b}, starts[a].T_S_K[loop.a.id], starts[b].T_S_K[loop.b.id], loop.T_A_B);
    }
    dpgo_alignment_t m = message<dpgo_alignment_t>();
    for (const auto& [pair, list] : candidates) {
      const AlignmentResult aligned = align_pair(list, options.alignment);
      m.segments_a.push_back(static_cast<std::int16_t>(pair.first.segment));
      m.robots_b.push_back(pair.second.robot);
      m.segments_b.push_back(static_cast<std::int16_t>(pair.second.segment));
      m.inliers.push_back(aligned.ok ? aligned.inliers : 0);
      m.loops.push_back(aligned.total);
      append_pose(aligned.T_A_B, m.T_A_B);
    }
    m.n = static_cast<std::int32_t>(m.robots_b.size());
    m.n_values = static_cast<std::int32_t>(m.T_A_B.size());
    send(std::move(m));
  }

  void take_alignments() {
    std::vector<PairAlignment> pairs;
    for (const int robot : part) {
      const dpgo_alignment_t& m = from<dpgo_alignment_t>(robot);
      for (int k = 0; k < m.n; ++k) {
        const StartFrame a{robot, m.segments_a[k]};
        const StartFrame b{m.robots_b[k], m.segments_b[k]};
        if (!frames.has(a) || !frames.has(b)) continue;
        PairAlignment pair{frames.index_of(a), frames.index_of(b), {}};
        pair.alignment.T_A_B = pose_at(m.T_A_B, k);
        pair.alignment.inliers = m.inliers[k];
        pair.alignment.ok = m.inliers[k] > 0;
        pairs.push_back(pair);
      }
    }
    continue_with(frames.place(std::move(pairs), me()));
    build_block();
    phase = Phase::kUpdate;
    send_first_update();
  }

  void build_block() {
    std::vector<PrivateEdge> edges;
    for (std::size_t s = 0; s < graph.segments.size(); ++s) {
      const auto& poses = graph.segments[s].poses;
      for (std::size_t k = 1; k < poses.size(); ++k) {
        const int to = offsets[s] + static_cast<int>(k);
        edges.push_back({to - 1, to, poses[k].T_P_K, poses[k].precision.kappa, poses[k].precision.tau});
      }
    }
    odometry_edges = static_cast<int>(edges.size());
    for (const GraphLoop& loop : private_loops) {
      edges.push_back(
          {index_of(loop.a), index_of(loop.b), loop.T_A_B, loop.precision.kappa, loop.precision.tau});
    }
    ends.erase(std::remove_if(ends.begin(), ends.end(),
                              [&](const SharedEnd& end) {
                                return !std::binary_search(part.begin(), part.end(), end.peer);
                              }),
               ends.end());
    std::vector<SharedEdge> shared;
    for (const SharedEnd& end : ends) {
      shared.push_back({public_index[end.my_place], end.loop.a.robot == me(), end.loop.T_A_B,
                        end.loop.precision.kappa, end.loop.precision.tau});
    }
    X.resize(options.rank, 4 * graph.poses());
    for (std::size_t s = 0; s < graph.segments.size(); ++s) {
      const SE3 T = frames.pose_of({me(), static_cast<int>(s)}).value_or(SE3{});
      for (std::size_t k = 0; k < starts[s].T_S_K.size(); ++k) {
        X.middleCols<4>(4 * (offsets[s] + static_cast<int>(k))) = lift(T * starts[s].T_S_K[k], options.rank);
      }
    }
    X_before = X;
    for (const int robot : part) {
      Member& member = known[robot];
      member.now.resize(options.rank, 4 * static_cast<int>(member.start.size()));
      for (int k = 0; k < static_cast<int>(member.start.size()); ++k) {
        const SE3 T = frames.pose_of({robot, member.start_segments[k]}).value_or(SE3{});
        member.now.middleCols<4>(4 * k) = lift(T * member.start[k], options.rank);
      }
      member.before = member.now;
    }
    loop_weights = Eigen::VectorXd::Ones(static_cast<Eigen::Index>(private_loops.size()));
    shared_weights = Eigen::VectorXd::Ones(static_cast<Eigen::Index>(shared.size()));
    solver = std::make_unique<BlockSolver>(graph.poses(), options.rank, std::move(edges), std::move(shared),
                                           options.block);
  }

  int index_of(const KeyframeName& keyframe) const {
    return offsets[segment_place(keyframe.segment)] + keyframe.id;
  }

  // ---- Updates ----

  Eigen::VectorXd private_loop_residuals() const {
    return solver->edge_residuals(X).tail(loop_weights.size());
  }

  // From the poses as sent, which both ends know.
  Eigen::VectorXd shared_loop_residuals() const {
    Eigen::VectorXd r2(shared_weights.size());
    for (std::size_t e = 0; e < ends.size(); ++e) {
      const SharedEdge& edge = solver->shared()[e];
      const Lifted difference =
          my_side(edge, known.at(me()).now.middleCols<4>(4 * ends[e].my_place)) -
          other_side(edge, known.at(ends[e].peer).now.middleCols<4>(4 * ends[e].peer_place));
      r2[static_cast<Eigen::Index>(e)] = weighted_square(difference, edge.kappa, edge.tau);
    }
    return r2;
  }

  static double largest(const Eigen::VectorXd& r2) { return r2.size() == 0 ? 0.0 : r2.maxCoeff(); }

  void send_first_update() {
    dpgo_update_t m = message<dpgo_update_t>();
    // One loop without any sense must not make this message one that the others refuse: nobody would go on.
    m.max_residual_sq =
        std::min(std::max(largest(private_loop_residuals()), largest(shared_loop_residuals())),
                 0.5 * kLargestResidualSq);
    send(std::move(m));
  }

  void take_updates() {
    for (const int robot : part) {
      const dpgo_update_t& m = from<dpgo_update_t>(robot);
      Member& member = known[robot];
      member.before = member.now;
      add_differences(m, member.now);
      member.cost = m.cost;
      member.decrease = m.decrease;
      member.overshoot = m.overshoot;
      member.max_r2 = m.max_residual_sq;
      member.undecided = m.undecided;
    }
    const TeamUpdate team = team_update();
    if (stages.ended(team)) {
      if (!stages.begin(team, first_mu())) {
        finish();
        return;
      }
      momentum.restart();
      set_weights();
    }
    send_update(update());
  }

  TeamUpdate team_update() const {
    TeamUpdate team;
    for (const int robot : part) {
      const Member& member = known.at(robot);
      team.cost += member.cost;
      team.decrease += member.decrease;
      team.undecided += member.undecided;
    }
    return team;
  }

  // The team's largest residual says where the surrogate is convex. A start that all left unfinished at the same place goes
  // on at the mu that it had (the lowest, as they may be one update apart).
  double first_mu() const {
    double max_r2 = 0.0;
    double left_at = std::numeric_limits<double>::infinity();
    const std::int64_t frame = frames.solution_of(frames.root());
    for (const int robot : part) {
      const Member& member = known.at(robot);
      max_r2 = std::max(max_r2, member.max_r2);
      left_at = std::min(left_at, member.join.mu);
      for (const std::int64_t solution : member.join.solutions) {
        if (frame == 0 || solution != frame) left_at = 0.0;
      }
    }
    return left_at > 0.0 ? left_at : tls_first_mu(max_r2, options.barc2);
  }

  void set_weights() {
    int open = 0;
    const auto weigh = [&](const Eigen::VectorXd& r2, Eigen::VectorXd& weights, const auto& loop_of,
                           const auto& owned) {
      for (Eigen::Index e = 0; e < weights.size(); ++e) {
        if (loop_of(e).known_inlier) continue;
        const double weight = stages.weight(r2[e]);
        if (stages.undecided(weight, weights[e]) && owned(e)) ++open;
        weights[e] = weight;
      }
    };
    if (options.robust) {
      weigh(
          private_loop_residuals(), loop_weights,
          [&](Eigen::Index e) -> const GraphLoop& { return private_loops[e]; },
          [](Eigen::Index) { return true; });
      weigh(
          shared_loop_residuals(), shared_weights,
          [&](Eigen::Index e) -> const GraphLoop& { return ends[e].loop; },
          [&](Eigen::Index e) { return ends[e].peer > me(); });
    }
    my_undecided = open;
    Eigen::VectorXd edge_weights = Eigen::VectorXd::Ones(odometry_edges + loop_weights.size());
    edge_weights.tail(loop_weights.size()) = loop_weights;
    solver->set_weights(edge_weights, 2.0 * shared_weights);  // 2: of the majorisation
  }

  dpgo_update_t update() {
    double overshoot = 0.0;
    for (const int robot : part) overshoot += known.at(robot).overshoot;
    if (overshoot > 0.0) momentum.restart();
    const double beta = options.momentum ? momentum.next() : 0.0;

    const auto ahead = [&](int robot, int place) -> Lifted {
      const Member& member = known.at(robot);
      const auto now = member.now.middleCols<4>(4 * place);
      return now + beta * (now - member.before.middleCols<4>(4 * place));
    };
    Lifted targets(options.rank, 4 * static_cast<int>(ends.size()));
    for (std::size_t e = 0; e < ends.size(); ++e) {
      const SharedEdge& edge = solver->shared()[e];
      targets.middleCols<4>(4 * static_cast<int>(e)) =
          0.5 * (my_side(edge, ahead(me(), ends[e].my_place)) +
                 other_side(edge, ahead(ends[e].peer, ends[e].peer_place)));
    }
    const Lifted ahead_of_X = beta == 0.0 ? X : retract(X, beta * (X - X_before));
    const Lifted gradient = solver->riemannian_gradient(targets, ahead_of_X);
    Lifted next = ahead_of_X;
    const BlockStep step = solver->minimise(targets, next);
    dpgo_update_t m = message<dpgo_update_t>();
    const Lifted moved = next - X;
    m.cost = static_cast<float>(step.cost_before);
    m.decrease = static_cast<float>(step.cost_before - step.cost_after);
    m.overshoot = beta == 0.0 ? 0.0F : static_cast<float>(gradient.cwiseProduct(moved).sum());
    m.undecided = my_undecided;
    X_before = std::exchange(X, std::move(next));
    ++updates;
    stages.count_update();
    return m;
  }

  void send_update(dpgo_update_t m) {
    Lifted wanted(options.rank, 4 * static_cast<int>(public_index.size()));
    for (int k = 0; k < static_cast<int>(public_index.size()); ++k) {
      wanted.middleCols<4>(4 * k) = X.middleCols<4>(4 * public_index[k]);
    }
    encode_differences(wanted - self().now, m);
    send(std::move(m));
  }

  // ---- Result ----

  std::int64_t world_name() const {
    const StartFrame& frame = frames.root();
    return frame_name(name, frame.robot, known.at(frame.robot).join.segments[frame.segment]);
  }

  // A lifted pose in W.
  SE3 rounded(const Lifted& pose) const {
    const StartFrame& frame = frames.root();
    const Member& anchor = known.at(frame.robot);
    const int place = anchor.places.at({frame.segment, 0});
    return pose_at(anchor.join.T_O_K, frame.segment) *
           round_to_pose(anchor.now.middleCols<4>(4 * place), pose);
  }

  std::vector<SegmentResult> placed_poses() const {
    std::vector<SegmentResult> segments;
    for (std::size_t s = 0; s < graph.segments.size(); ++s) {
      SegmentResult segment{
          graph.segments[s].name, frames.pose_of({me(), static_cast<int>(s)}).has_value(), {}};
      for (int k = 0; k < static_cast<int>(graph.segments[s].poses.size()); ++k) {
        segment.T_W_K.push_back(rounded(X.middleCols<4>(4 * (offsets[s] + k))));
      }
      segments.push_back(std::move(segment));
    }
    return segments;
  }

  void finish() {
    phase = Phase::kDone;
    result.name = name;
    result.anchor = part.front();
    result.frame = world_name();
    result.robots = part;
    result.segments = placed_poses();
    result.graph = graph.hash;
    result.keyframes = graph.poses();
    result.stages = stages.stages();
    result.updates = updates;
    for (const Segment& segment : graph.segments) {
      const auto& T = result.segments[segment_place(segment.name)].T_W_K;
      for (std::size_t k = 1; k < T.size(); ++k) {
        result.owned_cost += residual_sq(T[k - 1], T[k], segment.poses[k].T_P_K, segment.poses[k].precision);
      }
    }
    const auto pose = [&](const KeyframeName& keyframe) {
      return result.segments[segment_place(keyframe.segment)].T_W_K[keyframe.id];
    };
    const auto add = [&](const GraphLoop& loop, double weight, double r2, bool owned) {
      result.loops.push_back({loop, weight, r2});
      if (weight == 1.0) ++result.loops_kept;
      if (weight == 1.0 && owned) ++result.owned_kept;
      if (owned) result.owned_cost += options.robust ? std::min(r2, options.barc2) : r2;
    };
    for (std::size_t e = 0; e < private_loops.size(); ++e) {
      const GraphLoop& loop = private_loops[e];
      add(loop, loop_weights[static_cast<Eigen::Index>(e)],
          residual_sq(pose(loop.a), pose(loop.b), loop.T_A_B, loop.precision), true);
    }
    for (std::size_t e = 0; e < ends.size(); ++e) {
      const GraphLoop& loop = ends[e].loop;
      const SE3 T_mine = pose(mine(loop));
      const SE3 T_peer = rounded(known.at(ends[e].peer).now.middleCols<4>(4 * ends[e].peer_place));
      const bool a_mine = loop.a.robot == me();
      add(loop, shared_weights[static_cast<Eigen::Index>(e)],
          residual_sq(a_mine ? T_mine : T_peer, a_mine ? T_peer : T_mine, loop.T_A_B, loop.precision),
          ends[e].peer > me());
    }
    result.loops_used = static_cast<int>(result.loops.size());
    warn_of_rejected_pairs();
    for (const SegmentResult& segment : result.segments) {
      if (!segment.placed) {
        warnings.push_back(fmt::format("segment {} of robot {} has no closure that connects it to the team",
                                       segment.segment, me()));
      }
    }
    result.warnings = warnings;
  }

  // The lower robot of a pair says when nothing is left between them.
  void warn_of_rejected_pairs() {
    struct Pair {
      int total = 0;
      int rejected = 0;
      double smallest = std::numeric_limits<double>::infinity();
    };
    std::map<int, Pair> pairs;
    for (const LoopResult& loop : result.loops) {
      const int peer = theirs(loop.loop).robot;
      if (peer <= me()) continue;
      Pair& pair = pairs[peer];
      ++pair.total;
      if (loop.weight == 0.0) ++pair.rejected;
      pair.smallest = std::min(pair.smallest, loop.r2);
    }
    for (const auto& [peer, pair] : pairs) {
      if (pair.rejected < pair.total) continue;
      warnings.push_back(
          fmt::format("all {} closures of robots {}-{} were rejected; the smallest squared residual is "
                      "{:.4g} against barc^2 {:.4g}",
                      pair.total, me(), peer, pair.smallest, options.barc2));
    }
  }
};

DgncRound::DgncRound(const RoundName& name, std::vector<int> members, GraphSnapshot graph,
                     std::vector<SegmentStart> starts, double mu, const DgncOptions& options)
    : state_(std::make_unique<State>(name, std::move(members), std::move(graph), std::move(starts), mu,
                                     options)) {
  COVEY_CHECK(!state_->graph.segments.empty() && state_->graph.segments.size() == state_->starts.size());
  COVEY_CHECK(std::binary_search(state_->members.begin(), state_->members.end(), state_->me()));
  state_->join();
}
DgncRound::~DgncRound() = default;
DgncRound::DgncRound(DgncRound&&) noexcept = default;

const RoundName& DgncRound::name() const { return state_->name; }
const std::vector<int>& DgncRound::members() const { return state_->members; }
bool DgncRound::done() const { return state_->phase == Phase::kDone; }
const RoundResult& DgncRound::result() const { return state_->result; }
int DgncRound::number() const { return state_->number; }
int DgncRound::updates() const { return state_->updates; }
double DgncRound::mu() const { return state_->stages.mu(); }

std::int64_t DgncRound::frame() const { return state_->world_name(); }

std::vector<SegmentResult> DgncRound::current() const {
  return state_->solver ? state_->placed_poses() : std::vector<SegmentResult>{};
}

void DgncRound::stop() {
  COVEY_CHECK(state_->solver != nullptr);
  if (!done()) state_->finish();
}

const char* DgncRound::receive(const RoundMessage& message) {
  State& state = *state_;
  const int sender = sender_of(message);
  const int n = number_of(message);
  if (sender == state.me() || !std::binary_search(state.members.begin(), state.members.end(), sender))
    return "sender";
  if (n < state.number || done()) return "duplicate";
  if (n > state.number + 1) return "number";
  if (!values_are_good(message)) return "values";
  if (!state.inbox[sender].emplace(n, message).second) return "duplicate";
  return nullptr;
}

std::vector<int> DgncRound::missing() const {
  std::vector<int> robots;
  if (done()) return robots;
  for (const int robot : state_->part) {
    const auto box = state_->inbox.find(robot);
    if (box == state_->inbox.end() || box->second.count(state_->number) == 0) robots.push_back(robot);
  }
  return robots;
}

bool DgncRound::advance() {
  State& state = *state_;
  if (done() || !missing().empty()) return false;
  if (!state.drop_misfits()) return false;
  switch (state.phase) {
    case Phase::kJoin:
      state.take_joins();
      break;
    case Phase::kKeys:
      state.take_keys();
      break;
    case Phase::kStart:
      state.take_starts();
      break;
    case Phase::kAlignment:
      state.take_alignments();
      break;
    case Phase::kUpdate:
      state.take_updates();
      break;
    case Phase::kDone:
      return false;
  }
  for (auto& [robot, box] : state.inbox) box.erase(box.begin(), box.lower_bound(state.number));
  return true;
}

std::vector<RoundMessage> DgncRound::take_outgoing() { return std::exchange(state_->outgoing, {}); }

const RoundMessage* DgncRound::resend(int number) const {
  const auto found = state_->sent.find(number);
  return found == state_->sent.end() ? nullptr : &found->second;
}

}  // namespace covey::pgo
