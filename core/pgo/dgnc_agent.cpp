// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/dgnc_agent.h"

#include <algorithm>
#include <numeric>
#include <type_traits>
#include <utility>

namespace covey::pgo {
namespace {

template <typename T>
constexpr bool kIsRoundMessage = std::is_constructible_v<RoundMessage, T>;

}  // namespace

std::size_t RoundAccount::total_bytes() const {
  return std::accumulate(bytes.begin(), bytes.end(), std::size_t{0},
                         [](std::size_t sum, const auto& type) { return sum + type.second; });
}

DgncAgent::DgncAgent(int robot, Utime start_utime, const AgentOptions& options)
    : robot_(robot),
      start_utime_(start_utime),
      options_(options),
      graph_(robot, options.dgnc.noise),
      presence_(robot, options.silence_us),
      relay_(robot) {}

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
  said_bytes_[type_of(outgoing_.back())] += bytes_of(outgoing_.back());
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
  if (const auto* relay = std::get_if<dpgo_relay_t>(&message)) return receive_relay(*relay, now);
  return receive_from(message, sender_of(message), 0, now);
}

const char* DgncAgent::receive_relay(const dpgo_relay_t& relay, Utime now) {
  if (relay.from == robot_ || relay.origin == robot_) return "own";
  if (!presence_.knows(relay.from)) return "unknown_sender";
  presence_.hear(relay.from, true, now);
  const Unwrapped unwrapped = unwrap(relay);
  if (unwrapped.refused != nullptr) return unwrapped.refused;
  return receive_from(*unwrapped.message, relay.from, relay.hops, now);
}

const char* DgncAgent::receive_from(const AgentMessage& message, int speaker, int hops, Utime now) {
  const int sender = sender_of(message);
  if (sender == robot_) return "own";
  if (const auto* beacon = std::get_if<dpgo_beacon_t>(&message)) {
    if (const char* refused = take(*beacon, now)) return refused;
  }
  if (!presence_.knows(sender)) return "unknown_sender";
  presence_.hear(sender, speaker == sender, now);
  if (const auto* neighbours = std::get_if<dpgo_neighbours_t>(&message)) {
    if (const char* refused = presence_.take(*neighbours, now)) return refused;
  }
  pass_on(message, speaker, hops, now);
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

// What is passed on is for the robots behind this one: whether it fits a round is theirs to judge.
void DgncAgent::pass_on(const AgentMessage& message, int speaker, int hops, Utime now) {
  if (const auto* request = std::get_if<dpgo_request_t>(&message); request != nullptr && hops == 0) {
    Relay::Repeated repeated = relay_.repeat(*request, presence_, options_.request_us / 2, now);
    for (dpgo_relay_t& relay : repeated.relays) say(std::move(relay), now);
    if (repeated.complete) return;
  }
  if (auto relay = relay_.pass_on(message, speaker, hops, presence_, now)) say(std::move(*relay), now);
}

const char* DgncAgent::take(const dpgo_beacon_t& beacon, Utime now) {
  if (const char* refused = presence_.take(beacon, now)) return refused;
  newest_round_ = std::max(newest_round_, beacon.round);
  return nullptr;
}

const char* DgncAgent::receive_round(const dpgo_round_t& proposal, Utime now) {
  const std::vector<int> present = present_robots(now);
  if (graph().poses() == 0) return "not_member";
  if (present.front() < proposal.from) return "not_anchor";
  if (!is_member(proposal)) return "not_member";
  if (!std::is_sorted(proposal.members.begin(), proposal.members.end(), std::less_equal<>()) ||
      proposal.round <= 0 || proposal.round > kLargestRound) {
    return "values";
  }
  if (round_ && proposal.round <= round_->name().number) return "old_round";
  if (proposal.round <= solution_.round.number) return "old_round";
  join_round(proposal, now);
  return nullptr;
}

// Of the round as this run of the process.
bool DgncAgent::is_member(const dpgo_round_t& proposal) const {
  const auto found = std::find(proposal.members.begin(), proposal.members.end(), robot_);
  return found != proposal.members.end() &&
         proposal.start_utimes[found - proposal.members.begin()] == start_utime_;
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

std::vector<int> DgncAgent::present_robots(Utime now) const {
  std::vector<int> robots;
  if (graph().poses() > 0) robots.push_back(robot_);
  for (const auto& [robot, peer] : presence_.peers()) {
    if (presence_.present(robot, now) && peer.beacon.keyframes > 0) robots.push_back(robot);
  }
  std::sort(robots.begin(), robots.end());
  return robots;
}

std::vector<ApartRobot> DgncAgent::apart(Utime now) const {
  std::vector<ApartRobot> robots;
  const std::vector<int>& in_frame = solution_.robots;
  for (const auto& [robot, peer] : presence_.peers()) {
    const bool present = presence_.present(robot, now);
    const bool together = std::binary_search(in_frame.begin(), in_frame.end(), robot);
    if (present && together) continue;
    const bool was_member = std::binary_search(members_.begin(), members_.end(), robot);
    const Apart why = !present ? Apart::kSilent : was_member ? Apart::kNoClosure : Apart::kNotYet;
    robots.push_back({robot, why, together, now - peer.heard});
  }
  return robots;
}

// ---- Opening rounds ----

void DgncAgent::tick(Utime now) {
  if (now < last_tick_) follow_clock_back(now);
  if (now - last_tick_ > options_.beacon_us) excuse_silence(now);
  last_tick_ = now;
  watch_for_changes(now);
  const std::vector<int> robots = present_robots(now);
  if (!robots.empty() && robots.front() == robot_) lead(now);
  say_presence(now);
  ask_for_missing(now);
}

void DgncAgent::say_presence(Utime now) {
  if (!last_beacon_ || now - *last_beacon_ >= options_.beacon_us) say_beacon(now);
  if (!last_neighbours_ || now - *last_neighbours_ >= options_.beacon_us) say_neighbours(now);
}

// Somebody set the clock: what was noted in its future would hold everything up until it has come that far again.
void DgncAgent::follow_clock_back(Utime now) {
  presence_.follow_clock_back(now);
  for (Utime* noted :
       {&last_change_, &last_proposal_, &last_progress_, &last_join_, &last_end_, &last_request_}) {
    *noted = std::min(*noted, now);
  }
  if (new_since_) new_since_ = std::min(*new_since_, now);
  last_beacon_.reset();
  last_neighbours_.reset();
  last_resend_.clear();
}

// Nor has the round stood still for that long.
void DgncAgent::excuse_silence(Utime now) {
  const Utime deaf_us = now - last_tick_;
  presence_.excuse(deaf_us, now);
  last_progress_ = std::min(last_progress_ + deaf_us, now);
}

void DgncAgent::watch_for_changes(Utime now) {
  std::map<int, std::pair<Utime, std::int64_t>> seen;
  for (const int robot : present_robots(now)) {
    seen[robot] = robot == robot_ ? std::pair(start_utime_, static_cast<std::int64_t>(graph().hash))
                                  : std::pair(presence_.peer(robot).beacon.start_utime,
                                              presence_.peer(robot).beacon.graph);
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
    const Peer& peer = presence_.peer(robot);
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
    if (!presence_.present(robot, now) ||
        presence_.peer(robot).beacon.start_utime != proposal_.start_utimes[m])
      return true;
  }
  return false;
}

void DgncAgent::lead(Utime now) {
  if (following_) return;
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
    proposal.start_utimes.push_back(robot == robot_ ? start_utime_
                                                    : presence_.peer(robot).beacon.start_utime);
  }
  proposal.n = static_cast<std::int32_t>(proposal.members.size());
  join_round(proposal, now);
  say_round(now);
}

void DgncAgent::say_round(Utime now) {
  last_proposal_ = now;
  say(proposal_, now);
}

void DgncAgent::follow(const dpgo_beacon_t& own) {
  following_ = true;
  start_utime_ = own.start_utime;
}

void DgncAgent::follow(const dpgo_round_t& own, Utime now) {
  following_ = true;
  const bool known = round_ && own.round <= round_->name().number;
  if (graph().poses() > 0 && !known && own.from == robot_ && is_member(own)) join_round(own, now);
}

void DgncAgent::join_round(const dpgo_round_t& proposal, Utime now) {
  keep_unfinished();
  proposal_ = proposal;
  newest_round_ = std::max(newest_round_, proposal.round);
  // Of loops that have come since nothing is decided: mu starts again.
  const double mu = unfinished_ && unfinished_->graph == graph().hash ? unfinished_->mu : 0.0;
  std::vector<int> members(proposal.members.begin(), proposal.members.end());
  round_.emplace(RoundName{proposal.round, proposal.from}, std::move(members), graph(),
                 starts_from(unfinished_ ? *unfinished_ : solution_, graph()), mu, options_.dgnc);
  said_bytes_.clear();
  last_join_ = now;
  last_resend_.clear();
  others_number_ = 0;
  last_progress_ = now;
  last_request_ = now;
  collect(now);
  say_beacon(now);
}

// A round that is left before its end: its poses and mu are the next start, if it had come to updates.
void DgncAgent::keep_unfinished() {
  if (running() && round_->updates() > 0) unfinished_ = unfinished_solution_of(*round_);
}

// ---- Running rounds ----

bool DgncAgent::advance(Utime now) {
  if (!running() || !round_->advance()) return false;
  last_progress_ = now;
  last_request_ = now;
  collect(now);
  if (!round_->done()) return true;
  keep_result(now);
  say_beacon(now);
  return true;
}

void DgncAgent::keep_result(Utime now) {
  const RoundResult& result = round_->result();
  solution_ = solution_of(result);
  unfinished_.reset();
  members_ = round_->members();
  account_ = {now - last_join_, said_bytes_};
  last_end_ = now;
  result_ = result;
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

void DgncAgent::say_neighbours(Utime now) {
  last_neighbours_ = now;
  dpgo_neighbours_t neighbours{};
  const std::vector<int> robots = presence_.neighbours(now);
  neighbours.n = static_cast<std::int32_t>(robots.size());
  neighbours.robots.assign(robots.begin(), robots.end());
  say(std::move(neighbours), now);
}

}  // namespace covey::pgo
