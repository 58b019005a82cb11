// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// What carries the messages between lcd agents in virtual time: a network that just loses, delays, doubles and disorders them, or
// radio_bridge's links (core/radio), with their datagrams, acknowledgements and rate, over such a network.

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "core/place/lcd_agent.h"
#include "core/radio/link.h"
#include "tests/simnet/network.h"

namespace covey::place {

class Air {
 public:
  using Deliver = std::function<void(int to, const LcdMessage& message, Utime now)>;
  virtual ~Air() = default;
  virtual void send(int from, const LcdMessage& message, Utime now) = 0;
  // Called often: hands over what is due.
  virtual void pass(Utime now, const Deliver& deliver) = 0;
  // The robot's lcd was started anew.
  virtual void restart(int robot) = 0;
  virtual void isolate(int robot) = 0;
  virtual void cut(int a, int b) = 0;
  virtual void heal() = 0;
};

class BareAir : public Air {
 public:
  BareAir(int robots, LinkFaults faults, std::uint64_t seed) : network_(seed, faults, robots) {}
  void send(int from, const LcdMessage& message, Utime now) override;
  void pass(Utime now, const Deliver& deliver) override;
  void restart(int robot) override { network_.restart(robot); }
  void isolate(int robot) override { network_.isolate(robot); }
  void cut(int a, int b) override { network_.cut(a, b); }
  void heal() override { network_.heal(); }

 private:
  SimNetwork<LcdMessage> network_;
};

class RadioAir : public Air {
 public:
  // 0: no limit.
  RadioAir(int robots, LinkFaults faults, std::uint64_t seed, double rate_bytes_per_s);
  void send(int from, const LcdMessage& message, Utime now) override;
  void pass(Utime now, const Deliver& deliver) override;
  void restart(int) override {}  // the bridge lives on
  void restart_bridge(int robot, Utime now);
  void isolate(int robot) override { network_.isolate(robot); }
  void cut(int a, int b) override { network_.cut(a, b); }
  void heal() override { network_.heal(); }

  // As the bridges count: "sent_bytes/MODULE", of all robots.
  std::int64_t count(const std::string& name) const;

 private:
  SimNetwork<radio::Bytes> network_;
  double rate_;
  std::map<std::string, std::int64_t> counts_;
  std::vector<std::unique_ptr<radio::Link>> links_;
};

}  // namespace covey::place
