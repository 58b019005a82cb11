// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Carries messages between one robot's bus and the radio.
//
//   reads   OUT_x on the robot's bus, for every x of the radio's channel table; datagrams from the radio
//   writes  IN_x on the robot's bus; datagrams to the radio: x as itself, RADIO_FRAGMENT, RADIO_ACK; STATUS
//
// From logs (--url file://PRIVATE.lcm --radio-url file://AIR.lcm --out O.lcm) both sides are written to O.lcm: IN_x as on
// the bus, and what would have gone on air under its bare channel name.

#include <functional>
#include <memory>
#include <string>

#include "core/radio/link.h"
#include "procs/common/process.h"
#include "procs/radio_bridge/options.h"
#include "procs/radio_bridge/radio_socket.h"

namespace covey {

// What is opened before the robot's bus is: the radio, in the network that the process was started in.
class RadioDoor {
 public:
  RadioBridgeOptions options;
  std::unique_ptr<RadioSocket> socket;  // null: the radio is a log

  void open(Process& process);
};

class RadioBridgeNode {
 public:
  RadioBridgeNode(Process& process, RadioDoor& door);

 private:
  void open_radio_log(const std::string& url);
  void flush();
  void put_on_air(const radio::Bytes& datagram);

  Process& process_;
  RadioDoor& door_;
  radio::Link link_;
  std::uint32_t log_sequence_ = 0;
};

}  // namespace covey
