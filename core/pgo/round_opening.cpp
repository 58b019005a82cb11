// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/round_opening.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "core/pgo/hash.h"
#include "core/pgo/keyframe_code.h"
#include "core/pgo/local_start.h"
#include "core/pgo/public_poses.h"

namespace covey::pgo {
namespace {

constexpr double kUnitsPerSigma = 16.0;

std::int64_t hash_of(const std::vector<GraphLoop>& loops) {
  Hash hash;
  for (const GraphLoop& loop : loops) hash.add(loop.key);
  return static_cast<std::int64_t>(hash.value());
}

// Far finer than any loop with others says where its ends are.
PoseUnits start_units(const GraphSnapshot& graph) {
  Precision finest{1.0, 1.0};
  for (const auto& [peer, loops] : graph.shared_loops) {
    for (const GraphLoop& loop : loops) {
      finest.kappa = std::max(finest.kappa, loop.precision.kappa);
      finest.tau = std::max(finest.tau, loop.precision.tau);
    }
  }
  return {1.0 / (kUnitsPerSigma * std::sqrt(2.0 * finest.kappa)),
          1.0 / (kUnitsPerSigma * std::sqrt(finest.tau))};
}

bool contains(const std::vector<int>& ascending, int robot) {
  return std::binary_search(ascending.begin(), ascending.end(), robot);
}

}  // namespace

RoundOpening::RoundOpening(RoundMail& mail, GraphSnapshot graph, std::vector<SegmentStart> starts, double mu,
                           const OpeningOptions& options)
    : options_(options) {
  COVEY_CHECK(!graph.segments.empty() && graph.segments.size() == starts.size());
  problem_.name = mail.name();
  problem_.graph = std::move(graph);
  problem_.starts = std::move(starts);
  if (options.local) solve_odometry_starts(problem_.graph, *options.local, problem_.starts);
  send_join(mail, mu);
}

bool RoundOpening::fits(int robot, const RoundMessage& message) const {
  switch (phase_) {
    case Phase::kJoin:
      return std::holds_alternative<dpgo_join_t>(message);
    case Phase::kKeys:
      return std::holds_alternative<dpgo_keys_t>(message);
    case Phase::kStart: {
      const auto* m = std::get_if<dpgo_keyframes_t>(&message);
      const auto keyframes = m != nullptr ? decode_keyframes(*m) : std::nullopt;
      if (!keyframes) return false;
      // The first keyframe of each segment must be there: one of them will be the origin of W.
      const int n_segments = problem_.members.at(robot).join.n_segments;
      int firsts = 0;
      for (const PublicKeyframe& keyframe : *keyframes) {
        if (keyframe.segment >= n_segments) return false;
        if (keyframe.id == 0) ++firsts;
      }
      return firsts == n_segments;
    }
    case Phase::kAlignment:
      return std::holds_alternative<dpgo_alignment_t>(message);
    case Phase::kDone:
      break;
  }
  return false;
}

void RoundOpening::advance(RoundMail& mail) {
  switch (phase_) {
    case Phase::kJoin:
      take_joins(mail);
      break;
    case Phase::kKeys:
      take_keys(mail);
      break;
    case Phase::kStart:
      take_starts(mail);
      break;
    case Phase::kAlignment:
      take_alignments(mail);
      break;
    case Phase::kDone:
      break;
  }
}

// ---- Joining, and agreeing on the loops ----

void RoundOpening::send_join(RoundMail& mail, double mu) {
  const GraphSnapshot& graph = problem_.graph;
  auto m = mail.compose<dpgo_join_t>();
  m.mu = mu;
  for (std::size_t s = 0; s < graph.segments.size(); ++s) {
    m.segments.push_back(graph.segments[s].name);
    m.solutions.push_back(problem_.starts[s].solution);
    append_pose(graph.segments[s].poses.front().T_O_K, m.T_O_K);
  }
  m.n_segments = static_cast<std::int32_t>(m.segments.size());
  m.n_values = static_cast<std::int32_t>(m.T_O_K.size());
  for (const auto& [peer, loops] : graph.shared_loops) {
    if (!contains(mail.members(), peer)) continue;
    m.peers.push_back(peer);
    m.loops.push_back(static_cast<std::int32_t>(loops.size()));
    m.hashes.push_back(hash_of(loops));
  }
  m.peers.push_back(problem_.robot());
  m.loops.push_back(0);
  m.hashes.push_back(static_cast<std::int64_t>(options_.hash));
  m.n_peers = static_cast<std::int32_t>(m.peers.size());
  mail.send(std::move(m));
}

void RoundOpening::take_joins(RoundMail& mail) {
  for (const int robot : mail.members()) problem_.members[robot].join = mail.from<dpgo_join_t>(robot);
  part_by_options(mail);
  bool differ = false;
  for (const int a : mail.part()) {
    for (const int b : mail.part()) differ = differ || (a < b && told_hash(a, b) != told_hash(b, a));
  }
  if (differ) {
    phase_ = Phase::kKeys;
    send_keys(mail);
  } else {
    agree(mail, [](int, const GraphLoop&) { return true; });
  }
}

// Members with other options would end their stages elsewhere: each such part goes its own way.
void RoundOpening::part_by_options(RoundMail& mail) {
  const int me = problem_.robot();
  std::vector<int> alike;
  for (const int robot : mail.members()) {
    if (told_hash(robot, robot) == told_hash(me, me)) {
      alike.push_back(robot);
    } else {
      problem_.warnings.push_back(
          fmt::format("robot {}'s section dpgo differs from robot {}'s, so they do not solve together; "
                      "give all robots the same",
                      robot, me));
    }
  }
  mail.continue_with(std::move(alike));
}

// What `robot` said of its loops with `peer`.
std::int64_t RoundOpening::told_hash(int robot, int peer) const {
  const dpgo_join_t& m = problem_.members.at(robot).join;
  const auto found = std::find(m.peers.begin(), m.peers.end(), peer);
  return found == m.peers.end() ? 0 : m.hashes[found - m.peers.begin()];
}

void RoundOpening::send_keys(RoundMail& mail) {
  const int me = problem_.robot();
  auto m = mail.compose<dpgo_keys_t>();
  for (const auto& [peer, loops] : problem_.graph.shared_loops) {
    if (!contains(mail.part(), peer) || told_hash(me, peer) == told_hash(peer, me)) continue;
    for (const GraphLoop& loop : loops) {
      m.peers.push_back(peer);
      m.keys.push_back(static_cast<std::int64_t>(loop.key));
    }
  }
  m.n = static_cast<std::int32_t>(m.peers.size());
  mail.send(std::move(m));
}

void RoundOpening::take_keys(RoundMail& mail) {
  const int me = problem_.robot();
  std::map<int, std::set<std::uint64_t>> theirs;
  for (const int robot : mail.part()) {
    const auto& m = mail.from<dpgo_keys_t>(robot);
    for (int k = 0; k < m.n; ++k) {
      if (m.peers[k] == me) theirs[robot].insert(static_cast<std::uint64_t>(m.keys[k]));
    }
  }
  agree(mail, [&](int peer, const GraphLoop& loop) {
    return told_hash(me, peer) == told_hash(peer, me) || theirs[peer].count(loop.key) > 0;
  });
}

template <typename Agreed>
void RoundOpening::agree(RoundMail& mail, Agreed agreed) {
  const int me = problem_.robot();
  for (auto& [peer, loops] : problem_.graph.shared_loops) {
    if (!contains(mail.part(), peer)) {
      loops.clear();
      continue;
    }
    const std::size_t before = loops.size();
    const int other = peer;
    std::erase_if(loops, [&](const GraphLoop& loop) { return !agreed(other, loop); });
    const std::size_t lost = before - loops.size();
    if (lost == 0) continue;
    problem_.warnings.push_back(
        fmt::format("{} of {} closures of robots {}-{} are left out: robot {} does not know them", lost,
                    before, std::min(me, peer), std::max(me, peer), peer));
  }
  if (!options_.align) {
    problem_.part = mail.part();
    phase_ = Phase::kDone;
    return;
  }
  phase_ = Phase::kStart;
  send_start(mail);
}

// ---- Starts and frames ----

void RoundOpening::send_start(RoundMail& mail) {
  std::set<std::pair<int, int>> names;  // (place of segment, id)
  int poses = 0;
  for (std::size_t s = 0; s < problem_.graph.segments.size(); ++s) {
    problem_.offsets.push_back(poses);
    poses += static_cast<int>(problem_.graph.segments[s].poses.size());
    names.insert({static_cast<int>(s), 0});
  }
  for (const auto& [peer, loops] : problem_.graph.shared_loops) {
    for (const GraphLoop& loop : loops) {
      const KeyframeName& own = problem_.own_end(loop);
      names.insert({problem_.segment_place(own.segment), own.id});
    }
  }
  std::vector<PublicKeyframe> keyframes;
  for (const auto& [segment, id] : names) {
    problem_.public_index.push_back(problem_.offsets[segment] + id);
    keyframes.push_back({segment, id, problem_.starts[segment].T_S_K[id]});
  }
  auto m = mail.compose<dpgo_keyframes_t>();
  encode_keyframes(keyframes, start_units(problem_.graph), m);
  mail.send(std::move(m));
}

void RoundOpening::take_starts(RoundMail& mail) {
  for (const int robot : mail.part()) {
    OpenedMember& member = problem_.members[robot];
    const auto keyframes = decode_keyframes(mail.from<dpgo_keyframes_t>(robot));
    COVEY_CHECK(keyframes.has_value());  // fits() has seen to that
    for (const PublicKeyframe& keyframe : *keyframes) {
      member.places[{keyframe.segment, keyframe.id}] = static_cast<int>(member.T_S_K.size());
      member.segments.push_back(keyframe.segment);
      member.T_S_K.push_back(keyframe.T_S_K);
    }
    for (int s = 0; s < member.join.n_segments; ++s)
      problem_.frames.add({robot, s}, member.join.solutions[s], extent_of(member.public_poses(s)));
  }
  resolve_loops();
  phase_ = Phase::kAlignment;
  send_alignment(mail);
}

// Finds both ends of each shared loop among the public keyframes.
void RoundOpening::resolve_loops() {
  for (const auto& [peer, loops] : problem_.graph.shared_loops) {
    if (loops.empty()) continue;
    const OpenedMember& other = problem_.members.at(peer);
    for (const GraphLoop& loop : loops) {
      const KeyframeName& theirs = problem_.other_end(loop);
      const auto segment = std::find(other.join.segments.begin(), other.join.segments.end(), theirs.segment);
      const auto found =
          segment == other.join.segments.end()
              ? other.places.end()
              : other.places.find({static_cast<int>(segment - other.join.segments.begin()), theirs.id});
      if (found == other.places.end()) continue;  // it says that it knows the loop, and not its own end of it
      const KeyframeName& own = problem_.own_end(loop);
      const int my_place = problem_.self().places.at({problem_.segment_place(own.segment), own.id});
      problem_.ends.push_back({loop, peer, my_place, found->second});
    }
  }
}

void RoundOpening::send_alignment(RoundMail& mail) {
  const int me = problem_.robot();
  // Candidates for T_A_B (paper, eq. 4) of each pair of frames a < b whose first robot is this one.
  std::map<std::pair<StartFrame, StartFrame>, std::vector<SE3>> candidates;
  const auto add = [&](const StartFrame& from_frame, const StartFrame& to_frame, const SE3& T_S_from,
                       const SE3& T_S_to, const SE3& measurement) {
    const SE3 T = T_S_from * measurement * T_S_to.inverse();
    if (from_frame < to_frame) {
      candidates[{from_frame, to_frame}].push_back(T);
    } else {
      candidates[{to_frame, from_frame}].push_back(T.inverse());
    }
  };
  const OpenedMember& self = problem_.self();
  for (const SharedLoop& end : problem_.ends) {
    if (end.peer < me) continue;
    const OpenedMember& peer = problem_.members.at(end.peer);
    const StartFrame my_frame{me, self.segments[end.my_place]};
    const StartFrame peer_frame{end.peer, peer.segments[end.peer_place]};
    const SE3& T_mine = self.T_S_K[end.my_place];
    const SE3& T_peer = peer.T_S_K[end.peer_place];
    if (end.loop.a.robot == me) {
      add(my_frame, peer_frame, T_mine, T_peer, end.loop.T_A_B);
    } else {
      add(peer_frame, my_frame, T_peer, T_mine, end.loop.T_A_B);
    }
  }
  for (const GraphLoop& loop : problem_.graph.private_loops) {
    const int a = problem_.segment_place(loop.a.segment);
    const int b = problem_.segment_place(loop.b.segment);
    if (a == b) continue;
    add({me, a}, {me, b}, problem_.starts[a].T_S_K[loop.a.id], problem_.starts[b].T_S_K[loop.b.id],
        loop.T_A_B);
  }
  auto m = mail.compose<dpgo_alignment_t>();
  for (const auto& [pair, list] : candidates) {
    const bool same = problem_.frames.same_solution(pair.first, pair.second);
    for (const AlignmentResult& aligned : same ? std::vector{confirm_same_frame(list, options_.alignment)}
                                               : possible_alignments(list, options_.alignment)) {
      m.segments_a.push_back(static_cast<std::int16_t>(pair.first.segment));
      m.robots_b.push_back(pair.second.robot);
      m.segments_b.push_back(static_cast<std::int16_t>(pair.second.segment));
      m.inliers.push_back(aligned.ok ? aligned.inliers : 0);
      m.loops.push_back(aligned.total);
      append_pose(aligned.T_A_B, m.T_A_B);
    }
  }
  m.n = static_cast<std::int32_t>(m.robots_b.size());
  m.n_values = static_cast<std::int32_t>(m.T_A_B.size());
  mail.send(std::move(m));
}

void RoundOpening::take_alignments(RoundMail& mail) {
  std::vector<PairAlignment> pairs;
  std::vector<TiedFrames> tied;
  for (const int robot : mail.part()) {
    const auto& m = mail.from<dpgo_alignment_t>(robot);
    for (int k = 0; k < m.n; ++k) {
      const StartFrame a{robot, m.segments_a[k]};
      const StartFrame b{m.robots_b[k], m.segments_b[k]};
      if (!problem_.frames.has(a) || !problem_.frames.has(b)) continue;
      tied.push_back({a, b, m.loops[k]});
      PairAlignment pair{problem_.frames.index_of(a), problem_.frames.index_of(b), {}};
      pair.alignment.T_A_B = pose_at(m.T_A_B, k);
      pair.alignment.inliers = m.inliers[k];
      pair.alignment.total = m.loops[k];
      pair.alignment.ok = m.inliers[k] > 0;
      pairs.push_back(pair);
    }
  }
  mail.continue_with(problem_.frames.place(std::move(pairs), problem_.robot()));
  problem_.part = mail.part();
  std::erase_if(problem_.ends, [&](const SharedLoop& end) { return !contains(problem_.part, end.peer); });
  keep_lone_loops(tied);
  phase_ = Phase::kDone;
}

// A loop between two frames that nothing else connects, not even through others, fits whatever the rest says.
void RoundOpening::keep_lone_loops(const std::vector<TiedFrames>& tied) {
  const auto connected_without = [&](const TiedFrames& bridge) {
    std::set<StartFrame> reached{bridge.a};
    for (bool grown = true; grown;) {
      grown = false;
      for (const TiedFrames& tie : tied) {
        if (&tie == &bridge || tie.loops <= 0 || reached.count(tie.a) == reached.count(tie.b)) continue;
        reached.insert({tie.a, tie.b});
        grown = true;
      }
    }
    return reached.count(bridge.b) > 0;
  };
  for (const TiedFrames& tie : tied) {
    if (tie.loops == 1 && !connected_without(tie)) problem_.lone_pairs.emplace_back(tie.a, tie.b);
  }
  const auto is_lone = [&](const StartFrame& a, const StartFrame& b) {
    return std::find(problem_.lone_pairs.begin(), problem_.lone_pairs.end(),
                     std::pair(std::min(a, b), std::max(a, b))) != problem_.lone_pairs.end();
  };
  const int me = problem_.robot();
  for (SharedLoop& end : problem_.ends) {
    const StartFrame mine{me, problem_.self().segments[end.my_place]};
    const StartFrame theirs{end.peer, problem_.members.at(end.peer).segments[end.peer_place]};
    if (is_lone(mine, theirs)) end.loop.known_inlier = true;
  }
  for (GraphLoop& loop : problem_.graph.private_loops) {
    const StartFrame a{me, problem_.segment_place(loop.a.segment)};
    const StartFrame b{me, problem_.segment_place(loop.b.segment)};
    if (a != b && is_lone(a, b)) loop.known_inlier = true;
  }
}

}  // namespace covey::pgo
