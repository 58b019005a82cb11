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
  std::string rig;  // load_robot_rig() reads it
  config.root().read("sensors", rig);
  return config;
}

Rig load_robot_rig(const std::filesystem::path& file) {
  if (file.empty())
    throw_input_error("--config is needed: a file whose key 'sensors' names the sensors' calibration");
  Config config = Config::load(file);
  std::string rig;
  config.root().read("sensors", rig);
  if (rig.empty()) {
    throw_input_error("{}: key 'sensors' is missing; it names the sensors' calibration (configs/sensors)",
                      file.string());
  }
  return read_rig(file.parent_path() / rig);
}

}  // namespace covey
