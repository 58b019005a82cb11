// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The options that every process has. The only user of CLI11 in procs_common is command_line.cpp: it takes
// long to compile.

#include <filesystem>
#include <optional>
#include <string>

#include "procs/common/bus_faults.h"
#include "procs/common/process.h"

namespace covey {

struct CommandLine {
  std::string name;
  int robot = -1;
  std::filesystem::path config;
  std::string url;         // empty: ProcessOptions::without_bus
  std::string sensor_url;  // empty from a log: the sensors are in it
  std::string depth_url;
  std::filesystem::path state_dir;
  std::string out;
  std::filesystem::path tum_path;
  BusFaults faults;
};

// None after --help and --version, which are printed. Throws InputError.
std::optional<CommandLine> parse_command_line(int argc, char** argv, const ProcessOptions& options);

}  // namespace covey
