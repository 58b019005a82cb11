// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/relay.h"

#include <algorithm>
#include <utility>

#include "core/pgo/hash.h"
#include "core/radio/addressing.h"

namespace covey::pgo {
namespace {

constexpr int kMostHops = radio::kMaxRobots;  // whatever the robots' hashes have forgotten ends here
constexpr std::size_t kRemembered = 4096;     // messages passed on
constexpr std::size_t kKept = 4;  // of rounds, per origin: members are within one message of each other
constexpr std::size_t kLongestKept = 64'000;  // bytes; what is longer is asked for at its origin

std::uint64_t hash_of(const Bytes& bytes) {
  Hash hash;
  std::uint64_t word = 0;
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    word = word << 8 | bytes[i];
    if (i % 8 == 7) hash.add(std::exchange(word, 0));
  }
  hash.add(word);
  hash.add(static_cast<std::uint64_t>(bytes.size()));
  return hash.value();
}

}  // namespace

Unwrapped unwrap(const dpgo_relay_t& relay) {
  if (relay.hops < 1 || relay.hops > kMostHops || relay.origin < 0 || relay.origin >= radio::kMaxRobots ||
      relay.origin == relay.from) {
    return {"values", std::nullopt};
  }
  std::optional<AgentMessage> message = decode_message(relay.message);
  if (!message || std::holds_alternative<dpgo_relay_t>(*message)) return {"undecodable", std::nullopt};
  if (sender_of(*message) != relay.origin) return {"origin_mismatch", std::nullopt};
  return {nullptr, std::move(message)};
}

bool is_of_a_round(const dpgo_relay_t& relay) {
  const auto message = decode_message(relay.message);
  return message && round_message(*message);
}

std::optional<dpgo_relay_t> Relay::pass_on(const AgentMessage& message, int speaker, int hops,
                                           const Presence& presence, Utime now) {
  const int origin = sender_of(message);
  if (hops >= kMostHops || !needed(origin, speaker, presence, now)) return std::nullopt;
  dpgo_relay_t relay{};
  relay.origin = origin;
  relay.hops = hops + 1;
  relay.message = encode_message(message);
  relay.n = static_cast<std::int32_t>(relay.message.size());
  if (!first_time(relay.message)) return std::nullopt;
  keep(message, relay, now);
  return relay;
}

bool Relay::needed(int origin, int speaker, const Presence& presence, Utime now) const {
  const std::vector<int> neighbours = presence.neighbours(now);
  return std::any_of(neighbours.begin(), neighbours.end(), [&](int to) {
    return to != origin && to != speaker && presence.hears(to, robot_, now) &&
           !presence.hears(to, origin, now) && !presence.hears(to, speaker, now) &&
           !lower_passes_on(origin, speaker, to, presence, now);
  });
}

bool Relay::lower_passes_on(int origin, int speaker, int to, const Presence& presence, Utime now) const {
  return std::any_of(presence.peers().begin(), presence.peers().end(), [&](const auto& known) {
    const int other = known.first;
    return other < robot_ && other != origin && other != to && presence.hears(other, speaker, now) &&
           presence.hears(other, to, now) && presence.hears(to, other, now);
  });
}

bool Relay::first_time(const Bytes& message) {
  const std::uint64_t hash = hash_of(message);
  if (!passed_.insert(hash).second) return false;
  order_.push_back(hash);
  if (order_.size() > kRemembered) {
    passed_.erase(order_.front());
    order_.pop_front();
  }
  return true;
}

void Relay::keep(const AgentMessage& message, const dpgo_relay_t& relay, Utime now) {
  const auto of_round = round_message(message);
  if (!of_round || relay.message.size() > kLongestKept) return;
  const RoundName round = round_of(*of_round);
  const int number = number_of(*of_round);
  std::deque<Kept>& kept = kept_[relay.origin];
  kept.erase(
      std::remove_if(kept.begin(), kept.end(),
                     [&](const Kept& other) { return other.round == round && other.number == number; }),
      kept.end());
  kept.push_back({round, number, now, relay});
  if (kept.size() > kKept) kept.pop_front();
}

Relay::Repeated Relay::repeat(const dpgo_request_t& request, const Presence& presence, Utime pause_us,
                              Utime now) {
  Repeated repeated;
  for (const int origin : request.robots) {
    if (origin == robot_) continue;
    Kept* kept = presence.hears(request.from, origin, now) ? nullptr : find(origin, request);
    if (kept == nullptr) {
      repeated.complete = false;
    } else if (now - kept->said >= pause_us) {
      kept->said = now;
      repeated.relays.push_back(kept->relay);
    }
  }
  return repeated;
}

Relay::Kept* Relay::find(int origin, const dpgo_request_t& request) {
  const auto of_origin = kept_.find(origin);
  if (of_origin == kept_.end()) return nullptr;
  const RoundName round{request.round, request.anchor};
  const auto found = std::find_if(of_origin->second.begin(), of_origin->second.end(), [&](const Kept& kept) {
    return kept.round == round && kept.number == request.number;
  });
  return found == of_origin->second.end() ? nullptr : &*found;
}

}  // namespace covey::pgo
