// SPDX-License-Identifier: BSD-3-Clause
#include "procs/common/robot_config.h"

#include <array>

namespace covey {
namespace {

constexpr std::array kSections = {"vio",    "mesher",           "lcd", "dpgo", "lmo", "radio_bridge", "sim",
                                  "player", "viewer_offscreen", "demo"};

}  // namespace

Config load_robot_config(const std::filesystem::path& file, const std::string& program) {
  Config config = file.empty() ? Config::parse("", "(no --config)") : Config::load(file);
  for (const char* section : kSections) {
    YAML::Node of_another;
    if (section != program) config.root().read(section, of_another);
  }
  return config;
}

}  // namespace covey
