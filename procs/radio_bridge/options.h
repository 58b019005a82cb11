// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// What a radio_bridge is told, on the command line and in its section of the configuration.

#include <string>

#include "core/base/config.h"
#include "core/radio/link_model.h"

namespace CLI {
class App;
}

namespace covey {

struct RadioBridgeOptions {
  std::string radio_url = "udpm://239.255.76.68:7800";  // or file://AIR.lcm, when --url is a log too
  std::string netns;                                    // network namespace of the private bus; "": this one

  // configs/radio/*.yaml, section radio_bridge
  int ttl = 0;            // how many hops the radio reaches; 0: this host only
  std::string interface;  // address of this host on the radio's network; "": as the multicast route says
  radio::LinkModelOptions model;
};

void add_command_line(CLI::App& app, RadioBridgeOptions& options);
void read_config(ConfigSection& section, RadioBridgeOptions& options);

}  // namespace covey
