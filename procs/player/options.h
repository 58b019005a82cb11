// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The player's own command line, and the node that it asks for.

#include <filesystem>
#include <memory>
#include <string>

#include "procs/common/process.h"

namespace covey {

struct PlayerOptions {
  std::filesystem::path asl;         // a folder in EuRoC's layout: IMU and STEREO
  std::filesystem::path tum_rgbd;    // depth and colour images with poses: DEPTH, STATE, KEYFRAME
  std::string up = "z";              // with tum_rgbd: the axis of the data's frame that points up
  double depth_per_m = 0.0;          // with tum_rgbd: of the depth images; 0: as the layout has it
  std::filesystem::path log;         // an LCM log to publish again
  std::string channels = ".*";       // of the log, as a regular expression for the whole name
  std::filesystem::path pose_graph;  // robot<i>.csv, or a folder of them
  double speed = 1.0;                // of recorded time; 0: as fast as is safe
};

void add_player_options(CLI::App& app, PlayerOptions& options);

// InputError unless exactly one source is given, and what it needs with it.
std::shared_ptr<void> make_player(Process& process, const PlayerOptions& options);

// What --out asks for without --url.
void convert(const PlayerOptions& options, const std::filesystem::path& config,
             const std::filesystem::path& log);

}  // namespace covey
