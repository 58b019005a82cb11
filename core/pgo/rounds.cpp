// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/rounds.h"

#include <algorithm>
#include <utility>

namespace covey::pgo {

void Rounds::restore(const Solution& solution) {
  solution_ = solution;
  hear_of(solution.round.number);
}

bool Rounds::is_new(const dpgo_round_t& proposal) const {
  return proposal.round > solution_.round.number && (!round_ || proposal.round > round_->name().number);
}

void Rounds::join(const dpgo_round_t& proposal, const GraphSnapshot& graph, Utime now) {
  keep_unfinished();
  proposal_ = proposal;
  hear_of(proposal.round);
  // Of loops that have come since nothing is decided: mu starts again.
  const double mu = unfinished_ && unfinished_->graph == graph.hash ? unfinished_->mu : 0.0;
  round_.emplace(RoundName{proposal.round, proposal.from},
                 std::vector<int>(proposal.members.begin(), proposal.members.end()), graph,
                 starts_from(unfinished_ ? *unfinished_ : solution_, graph), mu, options_);
  others_number_ = 0;
  joined_at_ = last_progress_ = last_request_ = now;
  last_repeat_.clear();
}

// A round that is left before its end: its poses and mu are the next start, if it had come to updates.
void Rounds::keep_unfinished() {
  if (running() && round_->updates() > 0) unfinished_ = unfinished_solution_of(*round_);
}

const char* Rounds::receive(const RoundMessage& message, Utime now) {
  if (!round_ || round_->name() != round_of(message)) return "other_round";
  if (round_->done() && number_of(message) > others_number_) {  // of another part, which takes longer
    others_number_ = number_of(message);
    last_progress_ = now;
  }
  return round_->receive(message);
}

bool Rounds::advance(Utime now) {
  if (!running() || !round_->advance()) return false;
  last_progress_ = last_request_ = now;
  if (round_->done()) keep_result(now);
  return true;
}

void Rounds::keep_result(Utime now) {
  result_ = round_->result();
  solution_ = solution_of(*result_);
  unfinished_.reset();
  members_ = round_->members();
  ended_at_ = now;
}

bool Rounds::is_of_this_round(const dpgo_request_t& request) const {
  return round_ && round_->name() == RoundName{request.round, request.anchor};
}

const RoundMessage* Rounds::repeat(const dpgo_request_t& request, Utime now) {
  if (std::find(request.robots.begin(), request.robots.end(), robot_) == request.robots.end()) return nullptr;
  const RoundMessage* message = round_->resend(request.number);
  if (message == nullptr) return nullptr;  // not made yet
  const auto last = last_repeat_.find(request.number);
  if (last != last_repeat_.end() && now - last->second < request_us_ / 2) return nullptr;
  last_repeat_[request.number] = now;
  return message;
}

std::optional<dpgo_request_t> Rounds::request(Utime now) {
  if (!running() || now - last_request_ < request_us_) return std::nullopt;
  const std::vector<int> missing = round_->missing();
  if (missing.empty()) return std::nullopt;
  last_request_ = now;
  dpgo_request_t request{};
  request.round = round_->name().number;
  request.anchor = round_->name().anchor;
  request.number = round_->number();
  request.n = static_cast<std::int32_t>(missing.size());
  request.robots.assign(missing.begin(), missing.end());
  return request;
}

bool Rounds::member_lost(const Presence& presence, Utime now) const {
  for (std::size_t m = 0; m < proposal_.members.size(); ++m) {
    const int robot = proposal_.members[m];
    if (robot == robot_) continue;
    if (!presence.present(robot, now) || presence.peer(robot).beacon.start_utime != proposal_.start_utimes[m])
      return true;
  }
  return false;
}

void Rounds::follow_clock_back(Utime now) {
  for (Utime* noted : {&joined_at_, &ended_at_, &last_progress_, &last_request_})
    *noted = std::min(*noted, now);
  last_repeat_.clear();
}

void Rounds::excuse(Utime deaf_us, Utime now) { last_progress_ = std::min(last_progress_ + deaf_us, now); }

}  // namespace covey::pgo
