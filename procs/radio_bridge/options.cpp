// SPDX-License-Identifier: BSD-3-Clause
#include "procs/radio_bridge/options.h"

#include <CLI/CLI.hpp>

namespace covey {

void add_command_line(CLI::App& app, RadioBridgeOptions& options) {
  app.add_option("--radio-url", options.radio_url,
                 "the radio: udpm://GROUP:PORT[?ttl=N], or file://F.lcm (a log of it)")
      ->capture_default_str();
  app.add_option("--netns", options.netns,
                 "enter this network namespace after the radio is opened and before the private bus is");
}

void read_config(ConfigSection& section, RadioBridgeOptions& options) {
  section.read("ttl", options.ttl, 0, 255);
  section.read("interface", options.interface);
  options.model = radio::read_link_model(section);
}

}  // namespace covey
