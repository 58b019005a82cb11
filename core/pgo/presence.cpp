// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/presence.h"

#include <algorithm>
#include <functional>

#include "core/pgo/round_message.h"
#include "core/radio/addressing.h"

namespace covey::pgo {
namespace {

bool is_robot(int id) { return id >= 0 && id < radio::kMaxRobots; }

}  // namespace

const char* Presence::take(const dpgo_beacon_t& beacon, Utime now) {
  if (beacon.utime < 0 || !is_robot(beacon.from) || beacon.round < 0 || beacon.round > kLargestRound ||
      beacon.solved_round < 0 || beacon.keyframes < 0) {
    return "values";
  }
  const auto known = peers_.find(beacon.from);
  if (known != peers_.end() && known->second.beacon.start_utime == beacon.start_utime) {
    // Beacons of one run overtake each other, and an older one says nothing new; unless it is so old that it cannot have
    // been on its way since: then the robot's clock was set back.
    const Utime older_by = known->second.beacon.utime - beacon.utime;
    if (older_by > 0 && older_by < silence_us_) return "late";
  }
  Peer& peer = peers_[beacon.from];
  peer.beacon = beacon;
  peer.beacon_heard = now;
  return nullptr;
}

const char* Presence::take(const dpgo_neighbours_t& neighbours, Utime now) {
  if (!knows(neighbours.from)) return "unknown_sender";
  if (neighbours.n > radio::kMaxRobots ||
      !std::all_of(neighbours.robots.begin(), neighbours.robots.end(), is_robot) ||
      !std::is_sorted(neighbours.robots.begin(), neighbours.robots.end(), std::less_equal<>())) {
    return "values";
  }
  Peer& peer = peers_.at(neighbours.from);
  const Utime older_by = peer.neighbours.utime - neighbours.utime;
  if (peer.neighbours_heard >= 0 && older_by > 0 && older_by < silence_us_) return "late";
  peer.neighbours = neighbours;
  peer.neighbours_heard = now;
  return nullptr;
}

void Presence::hear(int robot, bool directly, Utime now) {
  Peer& peer = peers_.at(robot);
  peer.heard = now;
  if (directly) peer.heard_directly = now;
}

void Presence::follow_clock_back(Utime now) {
  for (auto& [robot, peer] : peers_) {
    for (Utime* noted : {&peer.heard, &peer.beacon_heard, &peer.heard_directly, &peer.neighbours_heard}) {
      *noted = std::min(*noted, now);
    }
  }
}

void Presence::excuse(Utime deaf_us, Utime now) {
  for (auto& [robot, peer] : peers_) {
    for (Utime* noted : {&peer.heard, &peer.heard_directly, &peer.neighbours_heard}) {
      if (*noted >= 0) *noted = std::min(*noted + deaf_us, now);
    }
  }
}

bool Presence::present(int robot, Utime now) const {
  if (robot == robot_) return true;
  const auto peer = peers_.find(robot);
  return peer != peers_.end() && now - peer->second.heard < silence_us_;
}

bool Presence::neighbour(int robot, Utime now) const {
  const auto peer = peers_.find(robot);
  return peer != peers_.end() && peer->second.heard_directly >= 0 &&
         now - peer->second.heard_directly < silence_us_ / 2;
}

std::vector<int> Presence::neighbours(Utime now) const {
  std::vector<int> robots;
  for (const auto& [robot, peer] : peers_) {
    if (neighbour(robot, now)) robots.push_back(robot);
  }
  return robots;
}

bool Presence::hears(int listener, int speaker, Utime now) const {
  const auto peer = peers_.find(listener);
  if (peer == peers_.end() || peer->second.neighbours_heard < 0) return false;
  if (now - peer->second.neighbours_heard >= silence_us_) return false;
  const auto& robots = peer->second.neighbours.robots;
  return std::binary_search(robots.begin(), robots.end(), speaker);
}

}  // namespace covey::pgo
