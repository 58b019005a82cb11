// SPDX-License-Identifier: BSD-3-Clause
#include "core/radio/link_model.h"

#include <algorithm>

#include "core/radio/addressing.h"

namespace covey::radio {
namespace {

constexpr std::size_t kMaxInFlight = 65'536;  // datagrams; 79 MB at most

Utime from_ms(double duration_ms) { return static_cast<Utime>(duration_ms * 1e3); }

Contact read_contact(ConfigSection& section) {
  Contact contact;
  section.read("a", contact.a, 0, kMaxRobots - 1);
  section.read("b", contact.b, 0, kMaxRobots - 1);
  section.read("from_s", contact.from_s, 0.0, 1e9);
  section.read("until_s", contact.until_s, 0.0, 1e9);
  if (contact.until_s <= contact.from_s) {
    throw_input_error("{}: a contact must end after it begins ({} s)", section.where("until_s"),
                      contact.from_s);
  }
  return contact;
}

}  // namespace

LinkModelOptions read_link_model(ConfigSection& section) {
  LinkModelOptions options;
  section.read("loss", options.loss, 0.0, 1.0);
  section.read("delay_ms", options.delay_ms, 0.0, 60'000.0);
  section.read("jitter_ms", options.jitter_ms, 0.0, 60'000.0);
  section.read("duplicate", options.duplicate, 0.0, 1.0);
  section.read("rate_bytes_per_s", options.rate_bytes_per_s, 0.0, 1e12);
  section.read("burst_bytes", options.burst_bytes, 1200.0, 1e9);
  section.read("seed", options.seed);
  section.read("epoch_utime", options.epoch_utime);
  if (section.has("contacts")) {
    options.contacts.emplace();
    for (ConfigSection* contact : section.list("contacts"))
      options.contacts->push_back(read_contact(*contact));
  }
  return options;
}

LinkModel::LinkModel(int own_robot, LinkModelOptions options)
    : own_robot_(own_robot),
      options_(std::move(options)),
      random_(static_cast<std::uint64_t>(options_.seed) * 0x9e3779b97f4a7c15U +
              static_cast<std::uint64_t>(own_robot)) {
  if (options_.epoch_utime != 0) epoch_ = options_.epoch_utime;
}

bool LinkModel::in_contact(int from, Utime now) const {
  if (!options_.contacts) return true;
  const double t = to_seconds(now - epoch_.value_or(now));
  return std::any_of(options_.contacts->begin(), options_.contacts->end(), [&](const Contact& contact) {
    return std::minmax(contact.a, contact.b) == std::minmax(from, own_robot_) && t >= contact.from_s &&
           t < contact.until_s;
  });
}

const char* LinkModel::offer(int from, ByteView datagram, Utime now) {
  if (!epoch_) epoch_ = now;
  if (!in_contact(from, now)) return "no_contact";
  const int copies = uniform() < options_.duplicate ? 2 : 1;
  const char* refused = "simulated_loss";
  for (int copy = 0; copy < copies; ++copy) {
    const bool lost = uniform() < options_.loss;
    const Utime delay = from_ms(options_.delay_ms + uniform() * options_.jitter_ms);
    if (lost) continue;
    if (in_flight_.size() >= kMaxInFlight) {
      refused = "simulated_backlog";
      continue;
    }
    in_flight_.push({now + delay, order_++, Bytes(datagram.begin(), datagram.end())});
    refused = nullptr;
  }
  return refused;
}

std::vector<Bytes> LinkModel::take_due(Utime now) {
  std::vector<Bytes> due;
  while (!in_flight_.empty() && in_flight_.top().arrival <= now) {
    due.push_back(in_flight_.top().datagram);
    in_flight_.pop();
  }
  return due;
}

bool Budget::open(Utime now) {
  if (rate_ <= 0.0) return true;
  if (filled_ && now > *filled_) tokens_ = std::min(burst_, tokens_ + rate_ * to_seconds(now - *filled_));
  filled_ = now;
  return tokens_ > 0.0;
}

void Budget::spend(std::size_t bytes) {
  if (rate_ > 0.0) tokens_ -= static_cast<double>(bytes);
}

}  // namespace covey::radio
