// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/dgnc_agent.h"

#include <algorithm>
#include <type_traits>
#include <utility>

namespace covey::pgo {
namespace {

template <typename T>
constexpr bool kIsRoundMessage = std::is_constructible_v<RoundMessage, T>;

constexpr std::int64_t kLargestRound =
    1'000'000'000'000;  // one a second for 30,000 years; leaves room to count on

}  // namespace

int sender_of(const AgentMessage& message) {
  return std::visit([](const auto& m) { return m.from; }, message);
}

DgncAgent::DgncAgent(int robot, Utime start_utime, const AgentOptions& options)
    : robot_(robot), start_utime_(start_utime), options_(options), graph_(robot, options.dgnc.noise) {}

const char* DgncAgent::add(const Keyframe& keyframe) {
  snapshot_.reset();
  return graph_.add(keyframe);
}

const char* DgncAgent::add(const Loop& loop) {
  snapshot_.reset();
  return graph_.add(loop);
}

// A number is never given twice: it names the frame that the round leaves.
void DgncAgent::restore(const Solution& solution) {
  solution_ = solution;
  newest_round_ = std::max(newest_round_, solution.round.number);
}

const GraphSnapshot& DgncAgent::graph() const {
  if (!snapshot_) snapshot_ = graph_.snapshot();
  return *snapshot_;
}

template <typename T>
void DgncAgent::say(T message, Utime now) {
  message.utime = now;
  message.from = robot_;
  message.to = -1;
  outgoing_.emplace_back(std::move(message));
}

std::vector<AgentMessage> DgncAgent::take_outgoing() { return std::exchange(outgoing_, {}); }
std::optional<RoundResult> DgncAgent::take_result() { return std::exchange(result_, std::nullopt); }

AgentPhase DgncAgent::phase() const {
  if (running()) return AgentPhase::kRound;
  if (graph().poses() == 0) return AgentPhase::kIdle;
  return new_since_ || graph().hash != solution_.graph ? AgentPhase::kWaiting : AgentPhase::kIdle;
}

// ---- Receiving ----

const char* DgncAgent::receive(const AgentMessage& message, Utime now) {
  const int sender = sender_of(message);
  if (sender == robot_) return "own";
  if (const auto* beacon = std::get_if<dpgo_beacon_t>(&message)) return receive_beacon(*beacon, now);
  const auto peer = peers_.find(sender);
  if (peer == peers_.end()) return "unknown_sender";
  peer->second.heard = now;
  return std::visit(
      [&](const auto& m) -> const char* {
        using T = std::decay_t<decltype(m)>;
        if constexpr (std::is_same_v<T, dpgo_round_t>) {
          return receive_round(m, now);
        } else if constexpr (std::is_same_v<T, dpgo_request_t>) {
          return receive_request(m, now);
        } else if constexpr (kIsRoundMessage<T>) {
          return receive_round_message(m, now);
        } else {
          return nullptr;
        }
      },
      message);
}

const char* DgncAgent::receive_beacon(const dpgo_beacon_t& beacon, Utime now) {
  if (beacon.utime < 0 || beacon.from < 0 || beacon.round < 0 || beacon.round > kLargestRound ||
      beacon.solved_round < 0 || beacon.keyframes < 0) {
    return "values";
  }
  const auto known = peers_.find(beacon.from);
  if (known != peers_.end() && known->second.beacon.start_utime == beacon.start_utime) {
    // Beacons of one run overtake each other, and an older one says nothing new; unless it is so old that it cannot have
    // been on its way since: then the robot's clock was set back.
    const Utime older_by = known->second.beacon.utime - beacon.utime;
    if (older_by > 0 && older_by < options_.silence_us) return "late";
  }
  peers_[beacon.from] = {beacon, now, now};
  newest_round_ = std::max(newest_round_, beacon.round);
  return nullptr;
}

const char* DgncAgent::receive_round(const dpgo_round_t& proposal, Utime now) {
  const std::vector<int> present = present_robots(now);
  if (graph().poses() == 0) return "not_member";
  if (present.front() < proposal.from) return "not_anchor";
  const auto found = std::find(proposal.members.begin(), proposal.members.end(), robot_);
  if (found == proposal.members.end()) return "not_member";
  if (proposal.start_utimes[found - proposal.members.begin()] != start_utime_) return "not_member";
  if (!std::is_sorted(proposal.members.begin(), proposal.members.end(), std::less_equal<>()) ||
      proposal.round <= 0 || proposal.round > kLargestRound) {
    return "values";
  }
  if (round_ && proposal.round <= round_->name().number) return "old_round";
  if (proposal.round <= solution_.round.number) return "old_round";
  join_round(proposal, now);
  return nullptr;
}

const char* DgncAgent::receive_request(const dpgo_request_t& request, Utime now) {
  if (!round_ || round_->name() != RoundName{request.round, request.anchor}) return "other_round";
  if (std::find(request.robots.begin(), request.robots.end(), robot_) == request.robots.end()) return nullptr;
  const RoundMessage* message = round_->resend(request.number);
  if (message == nullptr) return nullptr;  // not made yet
  const auto last = last_resend_.find(request.number);
  if (last != last_resend_.end() && now - last->second < options_.request_us / 2) return nullptr;
  last_resend_[request.number] = now;
  std::visit([&](const auto& m) { say(m, now); }, *message);
  return nullptr;
}

const char* DgncAgent::receive_round_message(const RoundMessage& message, Utime now) {
  if (!round_ || round_->name() != round_of(message)) return "other_round";
  if (round_->done() && number_of(message) > others_number_) {  // of another part, which takes longer
    others_number_ = number_of(message);
    last_progress_ = now;
  }
  return round_->receive(message);
}

// ---- Presence ----

bool DgncAgent::present(int robot, Utime now) const {
  if (robot == robot_) return true;
  const auto peer = peers_.find(robot);
  return peer != peers_.end() && now - peer->second.heard < options_.silence_us;
}

std::vector<int> DgncAgent::present_robots(Utime now) const {
  std::vector<int> robots;
  if (graph().poses() > 0) robots.push_back(robot_);
  for (const auto& [robot, peer] : peers_) {
    if (present(robot, now) && peer.beacon.keyframes > 0) robots.push_back(robot);
  }
  std::sort(robots.begin(), robots.end());
  return robots;
}

// ---- Opening rounds ----

void DgncAgent::tick(Utime now) {
  if (now < last_tick_) follow_clock_back(now);
  last_tick_ = now;
  watch_for_changes(now);
  const std::vector<int> robots = present_robots(now);
  if (!robots.empty() && robots.front() == robot_) lead(now);
  if (!last_beacon_ || now - *last_beacon_ >= options_.beacon_us) say_beacon(now);
  ask_for_missing(now);
}

// Somebody set the clock: what was noted in its future would hold everything up until it has come that far again.
void DgncAgent::follow_clock_back(Utime now) {
  for (auto& [robot, peer] : peers_) {
    peer.heard = std::min(peer.heard, now);
    peer.beacon_heard = std::min(peer.beacon_heard, now);
  }
  for (Utime* noted : {&last_change_, &last_proposal_, &last_progress_, &last_end_, &last_request_}) {
    *noted = std::min(*noted, now);
  }
  if (new_since_) new_since_ = std::min(*new_since_, now);
  last_beacon_.reset();
  last_resend_.clear();
}

void DgncAgent::watch_for_changes(Utime now) {
  std::map<int, std::pair<Utime, std::int64_t>> seen;
  for (const int robot : present_robots(now)) {
    seen[robot] = robot == robot_
                      ? std::pair(start_utime_, static_cast<std::int64_t>(graph().hash))
                      : std::pair(peers_.at(robot).beacon.start_utime, peers_.at(robot).beacon.graph);
  }
  if (seen != watched_) {
    watched_ = std::move(seen);
    last_change_ = now;
  }
  if (!running() && something_new(now)) {
    if (!new_since_) new_since_ = now;
  } else {
    new_since_.reset();
  }
}

// Whether a present robot has what the last round had not, or has not ended that round.
bool DgncAgent::something_new(Utime now) const {
  const std::vector<int> robots = present_robots(now);
  if (robots.empty()) return false;
  if (std::binary_search(robots.begin(), robots.end(), robot_) && graph().hash != solution_.graph)
    return true;
  return std::any_of(robots.begin(), robots.end(), [&](int robot) {
    if (robot == robot_) return false;
    const Peer& peer = peers_.at(robot);
    if (peer.beacon_heard < last_end_) return false;  // where it stands since, the next one will say
    const dpgo_beacon_t& beacon = peer.beacon;
    const bool in_my_last = beacon.running && RoundName{beacon.round, beacon.anchor} == solution_.round;
    if (in_my_last && last_round_can_end(now)) return false;
    return beacon.graph != beacon.solved_graph ||
           RoundName{beacon.solved_round, beacon.solved_anchor} != solution_.round;
  });
}

// Whether those who have not ended the round that this robot has ended will do so: they miss messages, which all of its
// members still hold, if no one has left or was restarted since.
bool DgncAgent::last_round_can_end(Utime now) const {
  return round_ && round_->name() == solution_.round && !member_lost(now) &&
         now - last_progress_ <= options_.stall_us;
}

bool DgncAgent::member_lost(Utime now) const {
  for (std::size_t m = 0; m < proposal_.members.size(); ++m) {
    const int robot = proposal_.members[m];
    if (robot == robot_) continue;
    if (!present(robot, now) || peers_.at(robot).beacon.start_utime != proposal_.start_utimes[m]) return true;
  }
  return false;
}

void DgncAgent::lead(Utime now) {
  if (running()) {
    const bool mine = round_->name().anchor == robot_;
    if (!mine || member_lost(now) || now - last_progress_ > options_.stall_us) {
      open_round(now);
    } else if (round_->number() == 0 && now - last_proposal_ >= options_.request_us) {
      say_round(now);  // somebody has not joined yet
    }
    return;
  }
  if (!new_since_) return;
  const bool settled = now - last_change_ >= options_.settle_us;
  const bool patience_over = now - *new_since_ >= options_.patience_us;
  // A member may still be waiting for the end of the last round; it asks for what it misses.
  if (settled || patience_over) open_round(now);
}

void DgncAgent::open_round(Utime now) {
  dpgo_round_t proposal{};
  proposal.from = robot_;
  proposal.to = -1;
  proposal.round = ++newest_round_;
  for (const int robot : present_robots(now)) {
    proposal.members.push_back(robot);
    proposal.start_utimes.push_back(robot == robot_ ? start_utime_ : peers_.at(robot).beacon.start_utime);
  }
  proposal.n = static_cast<std::int32_t>(proposal.members.size());
  join_round(proposal, now);
  say_round(now);
}

void DgncAgent::say_round(Utime now) {
  last_proposal_ = now;
  say(proposal_, now);
}

void DgncAgent::join_round(const dpgo_round_t& proposal, Utime now) {
  keep_unfinished();
  proposal_ = proposal;
  newest_round_ = std::max(newest_round_, proposal.round);
  const double mu = unfinished_ ? unfinished_->mu : 0.0;
  std::vector<int> members(proposal.members.begin(), proposal.members.end());
  round_.emplace(RoundName{proposal.round, proposal.from}, std::move(members), graph(), starts(), mu,
                 options_.dgnc);
  last_resend_.clear();
  others_number_ = 0;
  last_progress_ = now;
  last_request_ = now;
  collect(now);
  say_beacon(now);
}

// ---- Starts ----

// A round that is left before its end: its poses and mu are the next start, if it had come to updates.
void DgncAgent::keep_unfinished() {
  if (!running() || round_->updates() == 0) return;
  Solution kept;
  kept.round = round_->name();
  kept.frame = round_->frame();
  kept.mu = round_->mu();
  for (SegmentResult& segment : round_->current()) {
    if (segment.placed) kept.segments[segment.segment] = std::move(segment.T_W_K);
  }
  unfinished_ = std::move(kept);
}

std::vector<SegmentStart> DgncAgent::starts() const {
  const Solution& from = unfinished_ ? *unfinished_ : solution_;
  std::vector<SegmentStart> starts;
  for (const Segment& segment : graph().segments) {
    SegmentStart start;
    const auto known = from.segments.find(segment.name);
    if (known != from.segments.end() && !known->second.empty()) {
      start.solution = from.frame;
      start.T_S_K = known->second;
      start.T_S_K.resize(std::min(start.T_S_K.size(), segment.poses.size()));
    } else {
      start.T_S_K = {segment.poses.front().T_O_K};
    }
    while (start.T_S_K.size() < segment.poses.size()) {
      start.T_S_K.push_back(start.T_S_K.back() * segment.poses[start.T_S_K.size()].T_P_K);
    }
    starts.push_back(std::move(start));
  }
  return starts;
}

// ---- Running rounds ----

bool DgncAgent::advance(Utime now) {
  if (!running() || !round_->advance()) return false;
  last_progress_ = now;
  last_request_ = now;
  collect(now);
  if (!round_->done()) return true;
  const RoundResult& result = round_->result();
  solution_ = {result.name, result.frame, result.graph, 0.0, {}};
  for (const SegmentResult& segment : result.segments) {
    if (segment.placed) solution_.segments[segment.segment] = segment.T_W_K;
  }
  unfinished_.reset();
  last_end_ = now;
  result_ = result;
  say_beacon(now);
  return true;
}

void DgncAgent::collect(Utime now) {
  for (RoundMessage& message : round_->take_outgoing()) {
    std::visit([&](auto& m) { say(std::move(m), now); }, message);
  }
}

void DgncAgent::ask_for_missing(Utime now) {
  if (!running() || now - last_request_ < options_.request_us) return;
  const std::vector<int> missing = round_->missing();
  if (missing.empty()) return;
  last_request_ = now;
  dpgo_request_t request{};
  request.round = round_->name().number;
  request.anchor = round_->name().anchor;
  request.number = round_->number();
  request.n = static_cast<std::int32_t>(missing.size());
  request.robots.assign(missing.begin(), missing.end());
  say(std::move(request), now);
}

void DgncAgent::say_beacon(Utime now) {
  last_beacon_ = now;
  dpgo_beacon_t beacon{};
  beacon.start_utime = start_utime_;
  beacon.keyframes = graph().poses();
  beacon.loops = graph().loops();
  beacon.graph = static_cast<std::int64_t>(graph().hash);
  beacon.round = newest_round_;
  if (round_) beacon.anchor = round_->name().anchor;
  beacon.running = running();
  if (running()) beacon.round = round_->name().number;
  beacon.solved_round = solution_.round.number;
  beacon.solved_anchor = solution_.round.anchor;
  beacon.solved_graph = static_cast<std::int64_t>(solution_.graph);
  say(beacon, now);
}

}  // namespace covey::pgo
