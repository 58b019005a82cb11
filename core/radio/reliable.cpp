// SPDX-License-Identifier: BSD-3-Clause
#include "core/radio/reliable.h"

#include <algorithm>
#include <cstdlib>
#include <limits>

#include "core/radio/addressing.h"

namespace covey::radio {
namespace {

constexpr Utime kForever = std::numeric_limits<Utime>::max();
constexpr Utime kLongestRoundTripUs =
    30 * kUsPerSecond;                               // a larger measurement is a lie or a clock that jumped
constexpr Utime kStalledAfterUs = 5 * kUsPerSecond;  // without progress: probe with one fragment

std::int32_t window_of(Utime progress, Utime now) {
  return now - progress > kStalledAfterUs ? 1 : kFragmentWindow;
}

}  // namespace

const char* ReliableSender::submit(Module module, int priority, int to, Bytes body, Utime now) {
  if (body.size() > static_cast<std::size_t>(kMaxMessageBytes)) return "message_too_long";
  if (open_bytes_ + body.size() > options_.max_bytes || next_number_ - oldest() >= kMessageWindow - 1) {
    return "queue_full";
  }
  Message message;
  message.module = module;
  message.priority = priority;
  message.to = to;
  message.fragments = fragments_of(static_cast<std::int64_t>(body.size()));
  message.submitted = now;
  message.last_sent.assign(static_cast<std::size_t>(message.fragments), 0);
  message.body = std::move(body);
  if (to != kToEveryone) {
    message.targets.emplace(to, new_target(message, now));
  } else {
    for (const auto& [robot, peer] : peers_) {
      if (now - peer.last_heard <= options_.gone_after_us)
        message.targets.emplace(robot, new_target(message, now));
    }
  }
  open_bytes_ += message.body.size();
  ready_[index_of(module)].emplace(-priority, next_number_);
  open_.emplace(next_number_++, std::move(message));
  return nullptr;
}

std::optional<radio_fragment_t> ReliableSender::next(Module module, Utime now) {
  while (!asleep_.empty() && asleep_.begin()->first <= now) wake(open_.find(asleep_.begin()->second));
  auto& ready = ready_[index_of(module)];
  while (!ready.empty()) {
    const auto it = open_.find(ready.begin()->second);
    Message& message = it->second;
    if (finished(message, now)) {
      close(it);
      continue;
    }
    const Choice choice = choose(message, now);
    if (choice.fragment < 0) {
      sleep(it, choice.due);
      continue;
    }
    if (choice.fragment == message.unsent) {
      ++message.unsent;
      for (auto& [robot, target] : message.targets) target.progress = now;
    } else {
      ++repeats_;
    }
    message.last_sent[static_cast<std::size_t>(choice.fragment)] = now;

    radio_fragment_t fragment{};
    fragment.utime = now;
    fragment.from = robot_;
    fragment.to = choice.to;
    fragment.epoch = epoch_;
    fragment.oldest = oldest();
    fragment.message = it->first;
    fragment.fragment = choice.fragment;
    fragment.fragments = message.fragments;
    fragment.total_bytes = static_cast<std::int32_t>(message.body.size());
    fragment.module = static_cast<std::int8_t>(module);
    const auto begin = message.body.begin() + std::int64_t{choice.fragment} * kFragmentBytes;
    fragment.data.assign(begin, begin + std::min<std::int64_t>(kFragmentBytes, message.body.end() - begin));
    fragment.n = static_cast<std::int32_t>(fragment.data.size());
    return fragment;
  }
  return std::nullopt;
}

// Which fragment to send now, and to whom: first what was never sent, then the first that somebody has waited for.
ReliableSender::Choice ReliableSender::choose(const Message& message, Utime now) const {
  struct Waiting {
    int robot;
    const Target& target;
    std::int32_t end;  // fragments below it may be sent to this robot now
    bool silent;
    Utime progress;
    Utime shortest_wait;
    bool wants(std::int32_t fragment) const {
      return fragment < end && !target.have[static_cast<std::size_t>(fragment)];
    }
  };
  std::vector<Waiting> waiting;
  waiting.reserve(message.targets.size());
  std::int32_t first = message.unsent;
  for (const auto& [robot, target] : message.targets) {
    const auto found = peers_.find(robot);
    const Peer peer = found == peers_.end() ? Peer{} : found->second;
    waiting.push_back({robot, target, target.below + window_of(target.progress, now), silent(robot, now),
                       std::max(target.progress, peer.progress), round_trip_bound(peer)});
    first = std::min(first, target.below);
  }

  if (message.unsent < message.fragments) {
    const bool wanted =
        waiting.empty() || std::any_of(waiting.begin(), waiting.end(),
                                       [&](const Waiting& each) { return each.wants(message.unsent); });
    if (wanted) return {.fragment = message.unsent, .to = message.to, .due = now};
  }

  Choice choice{.fragment = -1, .to = message.to, .due = kForever};
  if (waiting.empty()) choice.due = message.submitted + options_.linger_us;
  for (std::int32_t fragment = first; fragment < message.unsent; ++fragment) {
    const Utime sent = message.last_sent[static_cast<std::size_t>(fragment)];
    int missing = 0;
    int missed_by = kToEveryone;
    Utime due = kForever;
    for (const Waiting& each : waiting) {
      if (!each.wants(fragment)) continue;
      ++missing;
      missed_by = each.robot;
      if (each.silent) continue;
      due = std::min(
          due, sent + std::clamp((sent - each.progress) / 2, each.shortest_wait, options_.longest_wait_us));
    }
    if (due <= now) return {.fragment = fragment, .to = missing == 1 ? missed_by : message.to, .due = now};
    choice.due = std::min(choice.due, due);
  }
  return choice;
}

const char* ReliableSender::on_ack(const radio_ack_t& ack, Utime now) {
  if (ack.sender_epoch != epoch_) return "ack_stale";
  const auto n = static_cast<std::size_t>(ack.n);
  for (std::size_t i = 0; i < n; ++i) {
    if (ack.messages[i] < 0 || ack.messages[i] >= next_number_ || ack.below[i] < 0) return "ack_numbers";
    const auto it = open_.find(ack.messages[i]);
    if (it != open_.end() && ack.below[i] > it->second.fragments) return "ack_numbers";
  }
  const auto peer = peers_.find(ack.from);
  if (peer != peers_.end()) peer->second.acknowledges = true;
  if (peer != peers_.end() && ack.heard_utime >= epoch_ && ack.heard_utime <= now && ack.held_us >= 0 &&
      ack.held_us <= now - ack.heard_utime) {
    measure(peer->second, now - ack.heard_utime - ack.held_us);
  }
  for (std::size_t i = 0; i < n; ++i) {
    const auto it = open_.find(ack.messages[i]);
    if (it == open_.end()) continue;
    Message& message = it->second;
    const auto found = message.targets.find(ack.from);
    if (found == message.targets.end() || ack.number <= found->second.ack_number) continue;
    Target& target = found->second;
    target.ack_number = ack.number;
    target.below = ack.below[i];
    // The receiver may have dropped what it had: the newest ack is the whole truth.
    const auto mask = static_cast<std::uint64_t>(ack.masks[i]);
    for (std::int32_t fragment = 0; fragment < message.fragments; ++fragment) {
      const std::int32_t bit = fragment - ack.below[i] - 1;
      target.have[static_cast<std::size_t>(fragment)] =
          fragment < ack.below[i] || (bit >= 0 && bit < kFragmentWindow && (mask >> bit & 1U) != 0);
    }
    // Only more than ever before is progress: acks that take back and give again must not hurry us.
    const auto has = std::count(target.have.begin(), target.have.end(), true);
    if (has > target.most) {
      target.most = has;
      target.progress = now;
      if (peer != peers_.end()) peer->second.progress = now;
    }
    if (target.below == message.fragments) {
      message.targets.erase(found);
      message.finished.insert(ack.from);
    }
    wake(it);
  }
  return nullptr;
}

void ReliableSender::on_heard(int robot, Utime now) {
  const bool known = peers_.count(robot) > 0;
  const bool back = silent(robot, now);
  peers_[robot].last_heard = now;
  if (!back) return;
  for (auto it = open_.begin(); it != open_.end(); ++it) {
    Message& message = it->second;
    const auto target = message.targets.find(robot);
    if (target != message.targets.end()) {
      target->second.progress = now;
    } else if (!known && message.to == kToEveryone && message.finished.count(robot) == 0) {
      message.targets.emplace(robot, new_target(message, now));
    } else {
      continue;
    }
    wake(it);
  }
}

void ReliableSender::on_restart(int robot, Utime now) {
  for (auto it = open_.begin(); it != open_.end(); ++it) {
    const auto target = it->second.targets.find(robot);
    if (target == it->second.targets.end()) continue;
    target->second = new_target(it->second, now);
    wake(it);
  }
}

int ReliableSender::on_tick(Utime now) {
  int missed = 0;
  for (auto it = open_.begin(); it != open_.end(); ++it) {
    Message& message = it->second;
    for (auto target = message.targets.begin(); target != message.targets.end();) {
      const auto peer = peers_.find(target->first);
      const bool counts = peer != peers_.end() && peer->second.acknowledges;
      const Utime heard = counts ? std::max(peer->second.last_heard, message.submitted) : message.submitted;
      if (now - heard > options_.gone_after_us) {
        ++missed;
        target = message.targets.erase(target);
        wake(it);
      } else {
        ++target;
      }
    }
  }
  std::erase_if(peers_,
                [&](const auto& peer) { return now - peer.second.last_heard > options_.gone_after_us; });
  return missed;
}

ReliableSender::Target ReliableSender::new_target(const Message& message, Utime now) const {
  Target target;
  target.have.assign(static_cast<std::size_t>(message.fragments), false);
  target.progress = now;
  return target;
}

Utime ReliableSender::round_trip_bound(const Peer& peer) const {
  if (!peer.round_trip) return options_.first_wait_us;
  return std::clamp(*peer.round_trip + 4 * peer.deviation, options_.shortest_wait_us,
                    options_.longest_wait_us);
}

void ReliableSender::measure(Peer& peer, Utime round_trip) {
  if (round_trip > kLongestRoundTripUs) return;
  if (!peer.round_trip) {
    peer.round_trip = round_trip;
    peer.deviation = round_trip / 2;
    return;
  }
  peer.deviation += (std::abs(round_trip - *peer.round_trip) - peer.deviation) / 4;
  *peer.round_trip += (round_trip - *peer.round_trip) / 8;
}

bool ReliableSender::silent(int robot, Utime now) const {
  const auto peer = peers_.find(robot);
  return peer == peers_.end() || now - peer->second.last_heard > options_.silent_after_us;
}

bool ReliableSender::finished(const Message& message, Utime now) const {
  if (!message.targets.empty()) return false;
  if (message.to != kToEveryone) return true;  // arrived or given up: nobody waits for what was not sent yet
  return message.unsent == message.fragments && now - message.submitted >= options_.linger_us;
}

void ReliableSender::wake(Messages::iterator message) {
  const auto until = asleep_until_.find(message->first);
  if (until == asleep_until_.end()) return;
  asleep_.erase({until->second, message->first});
  asleep_until_.erase(until);
  ready_[index_of(message->second.module)].emplace(-message->second.priority, message->first);
}

void ReliableSender::sleep(Messages::iterator message, Utime due) {
  ready_[index_of(message->second.module)].erase({-message->second.priority, message->first});
  asleep_.emplace(due, message->first);
  asleep_until_[message->first] = due;
}

void ReliableSender::close(Messages::iterator message) {
  ready_[index_of(message->second.module)].erase({-message->second.priority, message->first});
  open_bytes_ -= message->second.body.size();
  open_.erase(message);
}

}  // namespace covey::radio
