// SPDX-License-Identifier: BSD-3-Clause
#include "core/radio/assembler.h"

#include <algorithm>

namespace covey::radio {
namespace {

constexpr std::int64_t kLargestNumber = std::int64_t{1} << 62;

// Null when the numbers of the fragment agree with each other.
const char* refusal_of_numbers(const radio_fragment_t& fragment) {
  if (fragment.total_bytes <= 0 || fragment.total_bytes > kMaxMessageBytes) return "fragment_numbers";
  if (fragment.fragments != fragments_of(fragment.total_bytes)) return "fragment_numbers";
  if (fragment.fragment < 0 || fragment.fragment >= fragment.fragments) return "fragment_numbers";
  if (fragment.oldest < 0 || fragment.oldest > kLargestNumber) return "fragment_numbers";
  const bool last = fragment.fragment == fragment.fragments - 1;
  const int bytes = last ? fragment.total_bytes - fragment.fragment * kFragmentBytes : kFragmentBytes;
  if (fragment.n != bytes || fragment.data.size() != static_cast<std::size_t>(bytes))
    return "fragment_length";
  if (fragment.message < fragment.oldest || fragment.message - fragment.oldest >= kMessageWindow) {
    return "fragment_window";
  }
  return nullptr;
}

}  // namespace

Assembler::Result Assembler::add(const radio_fragment_t& fragment, Utime now) {
  if (const char* refused = refusal_of_numbers(fragment)) return {.refused = refused, .body = {}};
  advance_floor(fragment.oldest);
  if (fragment.message < floor_) return {.refused = "fragment_stale", .body = {}};

  touched_[fragment.message] = fragment.fragments;
  if (done(fragment.message)) return {.refused = "fragment_duplicate", .body = {}};

  auto it = partial_.find(fragment.message);
  if (it == partial_.end()) {
    make_room(static_cast<std::size_t>(fragment.total_bytes));
    it = partial_.emplace(fragment.message, Partial{}).first;
    it->second.have.assign(static_cast<std::size_t>(fragment.fragments), false);
    it->second.body.assign(static_cast<std::size_t>(fragment.total_bytes), 0);
    partial_bytes_ += it->second.body.size();
  }
  Partial& partial = it->second;
  if (partial.body.size() != static_cast<std::size_t>(fragment.total_bytes)) {
    return {.refused = "fragment_inconsistent", .body = {}};
  }
  partial.touched = now;
  const auto index = static_cast<std::size_t>(fragment.fragment);
  if (partial.have[index]) return {.refused = "fragment_duplicate", .body = {}};

  partial.have[index] = true;
  std::copy(fragment.data.begin(), fragment.data.end(),
            partial.body.begin() + std::int64_t{fragment.fragment} * kFragmentBytes);
  while (partial.below < fragment.fragments && partial.have[static_cast<std::size_t>(partial.below)])
    ++partial.below;
  if (partial.below < fragment.fragments) return {};

  Result result;
  result.body = std::move(partial.body);
  partial_bytes_ -= static_cast<std::size_t>(fragment.total_bytes);
  partial_.erase(it);
  done_.set(static_cast<std::size_t>(fragment.message % kMessageWindow));
  last_completed_.emplace_back(fragment.message, fragment.fragments);
  if (last_completed_.size() > kRepeatedAcks) last_completed_.pop_front();
  return result;
}

std::vector<Arrived> Assembler::take_arrived(std::size_t most) {
  std::vector<Arrived> arrived;
  while (!touched_.empty() && arrived.size() < most) {
    const auto [message, fragments] = *touched_.begin();
    touched_.erase(touched_.begin());
    Arrived entry{.message = message};
    const auto partial = partial_.find(message);
    if (done(message)) {
      entry.below = fragments;
    } else if (partial != partial_.end()) {
      const std::vector<bool>& have = partial->second.have;
      entry.below = partial->second.below;
      for (std::size_t bit = 0; bit < kFragmentWindow; ++bit) {
        const std::size_t index = static_cast<std::size_t>(entry.below) + 1 + bit;
        if (index < have.size() && have[index]) entry.mask |= std::uint64_t{1} << bit;
      }
    }
    arrived.push_back(entry);
  }
  for (const auto& [message, fragments] : last_completed_) {
    const bool said = std::any_of(arrived.begin(), arrived.end(), [number = message](const Arrived& entry) {
      return entry.message == number;
    });
    if (!said && message >= floor_ && arrived.size() < most) arrived.push_back({message, fragments, 0});
  }
  return arrived;
}

int Assembler::expire(Utime now) {
  int expired = 0;
  for (auto it = partial_.begin(); it != partial_.end();) {
    const auto next = std::next(it);
    if (now - it->second.touched > kPartialTimeoutUs) {
      drop(it);
      ++expired;
    }
    it = next;
  }
  return expired;
}

// Everything below the floor is finished for the sender, and so for us.
void Assembler::advance_floor(std::int64_t floor) {
  if (floor <= floor_) return;
  if (floor - floor_ >= kMessageWindow) {
    done_.reset();
  } else {
    for (std::int64_t i = floor_; i < floor; ++i) done_.reset(static_cast<std::size_t>(i % kMessageWindow));
  }
  floor_ = floor;
  while (!partial_.empty() && partial_.begin()->first < floor) drop(partial_.begin());
  touched_.erase(touched_.begin(), touched_.lower_bound(floor));
}

void Assembler::make_room(std::size_t bytes) {
  while (!partial_.empty() && partial_bytes_ + bytes > kMaxPartialBytes) {
    drop(std::min_element(partial_.begin(), partial_.end(), [](const auto& left, const auto& right) {
      return left.second.touched < right.second.touched;
    }));
  }
}

void Assembler::drop(std::map<std::int64_t, Partial>::iterator partial) {
  partial_bytes_ -= partial->second.body.size();
  partial_.erase(partial);
}

}  // namespace covey::radio
