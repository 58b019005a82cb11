// SPDX-License-Identifier: BSD-3-Clause
#include "core/place/bag_exchange.h"

#include <algorithm>
#include <cstdlib>

#include "core/place/lcd_messages.h"

namespace covey::place {
namespace {

constexpr std::size_t kMostStretchesHeld = 5000;  // of one run: memory
constexpr Utime kLatestUs =
    10 * kUsPerSecond;  // mail from before that was written by a clock that was set back since

bool is_listed(const KeyframeName& own, const std::map<Utime, RunInventory>& runs, bool whole) {
  const auto run = runs.find(own.segment);
  if (run == runs.end()) return !whole;
  return own.id < run->second.said_from || run->second.ids.contains(own.id);
}

// As RFC 6298 smooths round trips.
void measure(Utime taken, std::optional<Utime>& mean, Utime& deviation) {
  if (!mean) {
    mean = taken;
    deviation = taken / 2;
    return;
  }
  deviation += (std::abs(taken - *mean) - deviation) / 4;
  *mean += (taken - *mean) / 8;
}

}  // namespace

void BagExchange::offer(const KeyframeName& own) {
  const auto number = static_cast<int>(own_.size());
  own_.push_back(own);
  sent_.push_back(false);
  for (auto& [robot, peer] : peers_) {
    if (wants(robot, peer)) peer.missing.insert(number);
  }
}

bool BagExchange::take(const KeyframeName& bag) {
  auto& runs = held_[bag.robot];
  IdRanges& ids = runs[bag.segment];
  if (ids.stretches().size() >= kMostStretchesHeld || !ids.add(bag.id)) return false;
  ++new_bags_;
  // One before it is missing, which its owner should learn.
  if (bag.id == ids.last() && ids.stretches().rbegin()->first == bag.id && ids.stretches().size() > 1)
    soon_ = true;
  // Runs are named by their time: the oldest goes.
  if (runs.size() > kMostRuns) runs.erase(runs.begin());
  return true;
}

bool BagExchange::hear(int robot, Utime now) {
  const bool is_new = !present(robot, now);
  Peer& peer = peers_[robot];
  peer.heard = now;
  if (is_new) peer.patience = options_.patience_us;
  soon_ = soon_ || is_new;
  return is_new;
}

bool BagExchange::present(int robot, Utime now) const {
  const auto peer = peers_.find(robot);
  return peer != peers_.end() && std::abs(now - peer->second.heard) <= options_.silent_us;
}

const char* BagExchange::receive(const lcd_inventory_t& message, Utime now) {
  Inventory inventory;
  if (const char* reason = read_inventory(message, inventory)) return reason;
  const bool was_silent = hear(message.from, now);
  Peer& peer = peers_.at(message.from);
  if (!was_silent && peer.said && message.utime <= *peer.said && *peer.said - message.utime < kLatestUs)
    return "late";
  if (message.vocabulary != vocabulary_) return "vocabulary";
  peer.said = message.utime;
  if (!wants(message.from, peer)) return nullptr;
  std::map<Utime, RunInventory> runs;
  for (RunInventory& run : inventory.runs) {
    if (run.robot == robot_) runs[run.segment] = std::move(run);
  }
  compare(peer, runs, inventory.whole, now);
  return nullptr;
}

void BagExchange::compare(Peer& peer, const std::map<Utime, RunInventory>& runs, bool whole, Utime now) {
  std::erase_if(peer.flying, [&](const auto& each) {
    if (!is_listed(own_[static_cast<std::size_t>(each.first)], runs, whole)) return false;
    measure(now - each.second.sent, peer.taken, peer.deviation);
    peer.listed_order = std::max(peer.listed_order, each.second.order);
    peer.progress = now;
    peer.patience = options_.patience_us;
    return true;
  });
  give_up_lost(peer, now);
  peer.missing.clear();
  for (int number = 0; number < static_cast<int>(own_.size()); ++number) {
    if (!is_listed(own_[static_cast<std::size_t>(number)], runs, whole) && !peer.flying.contains(number))
      peer.missing.insert(peer.missing.end(), number);
  }
}

void BagExchange::give_up_lost(Peer& peer, Utime now) {
  const Utime late = late_after(peer);
  bool out_of_patience = false;
  std::erase_if(peer.flying, [&](const auto& each) {
    const Flight& flight = each.second;
    if (flight.order < peer.listed_order && now - flight.sent >= late) return true;
    const bool lost = now - std::max(flight.sent, peer.progress) >= std::max(peer.patience, late);
    out_of_patience = out_of_patience || lost;
    return lost;
  });
  if (out_of_patience) peer.patience = std::min(2 * peer.patience, options_.most_patience_us);
}

Utime BagExchange::late_after(const Peer& peer) const {
  if (!peer.taken) return options_.first_late_us;
  return std::max(options_.least_late_us, *peer.taken + 4 * peer.deviation);
}

std::optional<BagExchange::Due> BagExchange::next(Utime now) {
  int newest = -1;
  for (const auto& [robot, peer] : peers_) {
    if (!wants(robot, peer) || !present(robot, now) || peer.missing.empty()) continue;
    if (static_cast<int>(peer.flying.size()) < options_.window)
      newest = std::max(newest, *peer.missing.rbegin());
  }
  if (newest < 0) return std::nullopt;
  Due due{own_[static_cast<std::size_t>(newest)]};
  int lacking = 0;
  for (auto& [robot, peer] : peers_) {
    if (!present(robot, now) || peer.missing.erase(newest) == 0) continue;
    peer.flying[newest] = {peer.next_order++, now};
    ++lacking;
    due.to = robot;
  }
  if (lacking > 1 || !sent_[static_cast<std::size_t>(newest)]) due.to = -1;
  sent_[static_cast<std::size_t>(newest)] = true;
  return due;
}

std::optional<lcd_inventory_t> BagExchange::say(Utime now) {
  const Utime since = said_ ? std::abs(now - *said_) : options_.say_us;
  const bool soon = soon_ || new_bags_ >= options_.soon_bags;
  if (since < options_.say_soon_us || (!soon && since < options_.say_us)) return std::nullopt;
  said_ = now;
  new_bags_ = 0;
  soon_ = false;
  return inventory_message(robot_, now, vocabulary_, inventory(now));
}

// Where not all fits, others are left out the next time.
Inventory BagExchange::inventory(Utime now) {
  std::vector<int> robots;
  for (const auto& [robot, runs] : held_) {
    if (present(robot, now)) robots.push_back(robot);
  }
  std::rotate(robots.begin(), std::lower_bound(robots.begin(), robots.end(), turn_), robots.end());
  Inventory inventory;
  std::size_t said = 0;
  for (const int robot : robots) {
    const auto& runs = held_.at(robot);
    for (auto run = runs.rbegin(); run != runs.rend(); ++run) {
      said += std::min<std::size_t>(run->second.stretches().size(), kMostStretches);
      if (said > kMostSaid || inventory.runs.size() == kMostRuns) {
        inventory.whole = false;
        turn_ = robot == robots.front() ? robot + 1 : robot;
        return inventory;
      }
      inventory.runs.push_back({.robot = robot, .segment = run->first, .ids = run->second});
    }
  }
  return inventory;
}

bool BagExchange::owes(Utime now) const {
  return std::any_of(peers_.begin(), peers_.end(), [&](const auto& each) {
    const auto& [robot, peer] = each;
    const bool lacks = !peer.missing.empty() || !peer.flying.empty();
    return lacks && wants(robot, peer) && present(robot, now) && peer.patience <= 2 * options_.patience_us;
  });
}

}  // namespace covey::place
