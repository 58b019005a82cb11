// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Each adds one subcommand to the app, which prints its JSON while the command line is parsed. InputError for
// files that cannot be used.

namespace CLI {
class App;
}

namespace covey {

// trajectory --estimate A.tum... --reference B.tum... [--joint A.tum B.tum ...]
void add_trajectory_command(CLI::App& app);
// odometry --estimate A.tum --reference B.tum [--log vio.lcm]
void add_odometry_command(CLI::App& app);
// online --log bus.lcm... --reference B.tum...
void add_online_command(CLI::App& app);
// graph --graph DIR --estimate A.tum... --barc2 X [--truth B.tum...] [--log bus.lcm...]
void add_graph_command(CLI::App& app);
// mesh --estimate A.ply... --reference B.ply [--trajectory A.tum... --truth B.tum... | --alignment FILE] [--seen-from B.tum...]
void add_mesh_command(CLI::App& app);
// radio --log air.lcm
void add_radio_command(CLI::App& app);

}  // namespace covey
