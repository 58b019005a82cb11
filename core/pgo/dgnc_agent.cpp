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
      relay_(robot),
      rounds_(robot, options.dgnc, options.request_us) {}

const char* DgncAgent::add(const Keyframe& keyframe) {
  snapshot_.reset();
  return graph_.add(keyframe);
}

const char* DgncAgent::add(const Loop& loop) {
  snapshot_.reset();
  return graph_.add(loop);
}

void DgncAgent::restore(const Solution& solution) { rounds_.restore(solution); }

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
std::optional<RoundResult> DgncAgent::take_result() { return rounds_.take_result(); }

AgentPhase DgncAgent::phase() const {
  if (rounds_.running()) return AgentPhase::kRound;
  if (graph().poses() == 0) return AgentPhase::kIdle;
  return new_since_ || graph().hash != solution().graph ? AgentPhase::kWaiting : AgentPhase::kIdle;
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
          return rounds_.receive(m, now);
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
  rounds_.hear_of(beacon.round);
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
  if (!rounds_.is_new(proposal)) return "old_round";
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
  if (!rounds_.is_of_this_round(request)) return "other_round";
  const RoundMessage* message = rounds_.repeat(request, now);
  if (message != nullptr) std::visit([&](const auto& m) { say(m, now); }, *message);
  return nullptr;
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
  const std::vector<int>& in_frame = solution().robots;
  for (const auto& [robot, peer] : presence_.peers()) {
    const bool present = presence_.present(robot, now);
    const bool together = std::binary_search(in_frame.begin(), in_frame.end(), robot);
    if (present && together) continue;
    const bool was_member = std::binary_search(rounds_.members().begin(), rounds_.members().end(), robot);
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
  if (auto request = rounds_.request(now)) say(std::move(*request), now);
}

void DgncAgent::say_presence(Utime now) {
  if (!last_beacon_ || now - *last_beacon_ >= options_.beacon_us) say_beacon(now);
  if (!last_neighbours_ || now - *last_neighbours_ >= options_.beacon_us) say_neighbours(now);
}

// Somebody set the clock: what was noted in its future would hold everything up until it has come that far again.
void DgncAgent::follow_clock_back(Utime now) {
  presence_.follow_clock_back(now);
  rounds_.follow_clock_back(now);
  for (Utime* noted : {&last_change_, &last_proposal_}) *noted = std::min(*noted, now);
  if (new_since_) new_since_ = std::min(*new_since_, now);
  last_beacon_.reset();
  last_neighbours_.reset();
}

void DgncAgent::excuse_silence(Utime now) {
  const Utime deaf_us = now - last_tick_;
  presence_.excuse(deaf_us, now);
  rounds_.excuse(deaf_us, now);
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
  if (!rounds_.running() && something_new(now)) {
    if (!new_since_) new_since_ = now;
  } else {
    new_since_.reset();
  }
}

// Whether a present robot has what the last round had not, or has not ended that round.
bool DgncAgent::something_new(Utime now) const {
  const std::vector<int> robots = present_robots(now);
  if (robots.empty()) return false;
  if (std::binary_search(robots.begin(), robots.end(), robot_) && graph().hash != solution().graph)
    return true;
  return std::any_of(robots.begin(), robots.end(), [&](int robot) {
    if (robot == robot_) return false;
    const Peer& peer = presence_.peer(robot);
    if (peer.beacon_heard < rounds_.ended_at()) return false;  // where it stands since, the next one will say
    const dpgo_beacon_t& beacon = peer.beacon;
    const bool in_my_last = beacon.running && RoundName{beacon.round, beacon.anchor} == solution().round;
    if (in_my_last && last_round_can_end(now)) return false;
    return beacon.graph != beacon.solved_graph ||
           RoundName{beacon.solved_round, beacon.solved_anchor} != solution().round;
  });
}

// Whether those who have not ended the round that this robot has ended will do so: they miss messages, which all of its
// members still hold, if no one has left or was restarted since.
bool DgncAgent::last_round_can_end(Utime now) const {
  return round() != nullptr && round()->name() == solution().round && !rounds_.member_lost(presence_, now) &&
         now - rounds_.last_progress() <= options_.stall_us;
}

void DgncAgent::lead(Utime now) {
  if (following_) return;
  if (rounds_.running()) {
    const bool mine = round()->name().anchor == robot_;
    if (!mine || rounds_.member_lost(presence_, now) || now - rounds_.last_progress() > options_.stall_us) {
      open_round(now);
    } else if (round()->number() == 0 && now - last_proposal_ >= options_.request_us) {
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
  proposal.round = rounds_.newest() + 1;
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
  say(rounds_.proposal(), now);
}

void DgncAgent::follow(const dpgo_beacon_t& own) {
  following_ = true;
  start_utime_ = own.start_utime;
}

void DgncAgent::follow(const dpgo_round_t& own, Utime now) {
  following_ = true;
  const bool known = round() != nullptr && own.round <= round()->name().number;
  if (graph().poses() > 0 && !known && own.from == robot_ && is_member(own)) join_round(own, now);
}

void DgncAgent::join_round(const dpgo_round_t& proposal, Utime now) {
  rounds_.join(proposal, graph(), now);
  said_bytes_.clear();
  collect(now);
  say_beacon(now);
}

bool DgncAgent::advance(Utime now) {
  if (!rounds_.advance(now)) return false;
  collect(now);
  if (rounds_.running()) return true;
  account_ = {now - rounds_.joined_at(), said_bytes_};
  say_beacon(now);
  return true;
}

void DgncAgent::collect(Utime now) {
  for (RoundMessage& message : rounds_.take_outgoing()) {
    std::visit([&](auto& m) { say(std::move(m), now); }, message);
  }
}

void DgncAgent::say_beacon(Utime now) {
  last_beacon_ = now;
  dpgo_beacon_t beacon{};
  beacon.start_utime = start_utime_;
  beacon.keyframes = graph().poses();
  beacon.loops = graph().loops();
  beacon.graph = static_cast<std::int64_t>(graph().hash);
  beacon.round = rounds_.newest();
  if (round() != nullptr) beacon.anchor = round()->name().anchor;
  beacon.running = rounds_.running();
  if (rounds_.running()) beacon.round = round()->name().number;
  beacon.solved_round = solution().round.number;
  beacon.solved_anchor = solution().round.anchor;
  beacon.solved_graph = static_cast<std::int64_t>(solution().graph);
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
