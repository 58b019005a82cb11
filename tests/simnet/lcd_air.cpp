// SPDX-License-Identifier: BSD-3-Clause
#include "tests/simnet/lcd_air.h"

#include <optional>
#include <tuple>

#include "core/base/bytes.h"
#include "procs/common/channels.h"

namespace covey::place {
namespace {

constexpr std::tuple kChannels{kLcdInventory, kLcdBag, kLcdRequest, kLcdMore, kLcdFrame, kLcdLoop};

template <typename T>
const char* channel_of(const T&) {
  const char* name = nullptr;
  std::apply(
      [&name]<typename... U>(const RadioChannel<U>&... channel) {
        ((std::is_same_v<T, U> ? void(name = channel.name) : void()), ...);
      },
      kChannels);
  return name;
}

std::optional<LcdMessage> message_of(const std::string& name, const Bytes& payload) {
  std::optional<LcdMessage> result;
  const auto read = [&]<typename T>(const RadioChannel<T>& channel) {
    T message{};
    if (channel.name == name && decode(payload, message)) result = std::move(message);
  };
  std::apply([&](const auto&... channel) { (read(channel), ...); }, kChannels);
  return result;
}

}  // namespace

void BareAir::send(int from, const LcdMessage& message, Utime now) {
  network_.send(from, std::visit([](const auto& m) { return m.to; }, message), message, now);
}

void BareAir::pass(Utime now, const Deliver& deliver) {
  network_.deliver_until(now,
                         [&](int to, int, const LcdMessage& message, Utime t) { deliver(to, message, t); });
}

RadioAir::RadioAir(int robots, LinkFaults faults, std::uint64_t seed, double rate_bytes_per_s)
    : network_(seed, faults, robots), rate_(rate_bytes_per_s), links_(static_cast<std::size_t>(robots)) {
  for (int robot = 0; robot < robots; ++robot) restart_bridge(robot, 0);
}

void RadioAir::restart_bridge(int robot, Utime now) {
  network_.restart(robot);
  links_[static_cast<std::size_t>(robot)] = std::make_unique<radio::Link>(
      robot, now + 1, radio_table(), radio::LinkOptions{}, radio::LinkModelOptions{.rate_bytes_per_s = rate_},
      [this](const std::string& name, std::int64_t n) { counts_[name] += n; });
}

void RadioAir::send(int from, const LcdMessage& message, Utime now) {
  std::visit(
      [&](const auto& m) { links_[static_cast<std::size_t>(from)]->send(channel_of(m), encode(m), now); },
      message);
}

void RadioAir::pass(Utime now, const Deliver& deliver) {
  network_.deliver_until(now, [&](int to, int, const radio::Bytes& datagram, Utime t) {
    links_[static_cast<std::size_t>(to)]->receive(datagram, t);
  });
  for (std::size_t robot = 0; robot < links_.size(); ++robot) {
    const radio::Link::Output output = links_[robot]->on_tick(now);
    for (const radio::Bytes& datagram : output.air)
      network_.send(static_cast<int>(robot), kEveryone, datagram, now);
    for (const auto& delivery : output.bus) {
      if (const auto message = message_of(delivery.channel, delivery.payload))
        deliver(static_cast<int>(robot), *message, now);
    }
  }
}

std::int64_t RadioAir::count(const std::string& name) const {
  const auto found = counts_.find(name);
  return found == counts_.end() ? 0 : found->second;
}

}  // namespace covey::place
