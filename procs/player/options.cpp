// SPDX-License-Identifier: BSD-3-Clause
#include "procs/player/options.h"

#include <CLI/CLI.hpp>

#include "core/base/error.h"
#include "procs/player/asl_node.h"
#include "procs/player/log_node.h"
#include "procs/player/pose_graph_node.h"
#include "procs/player/rgbd_node.h"

namespace covey {
namespace {

void check_one_source(const PlayerOptions& options) {
  const int given = (options.asl.empty() ? 0 : 1) + (options.tum_rgbd.empty() ? 0 : 1) +
                    (options.log.empty() ? 0 : 1) + (options.pose_graph.empty() ? 0 : 1);
  if (given != 1) {
    throw_input_error(
        "give one source to play: --asl DIR, --tum-rgbd DIR, --log F.lcm or --pose-graph robot<i>.csv");
  }
}

}  // namespace

void add_player_options(CLI::App& app, PlayerOptions& options) {
  app.add_option(
      "--asl", options.asl,
      "a folder in EuRoC's layout: IMU and STEREO, onto --url, or without --url into the log --out at once");
  app.add_option(
      "--tum-rgbd", options.tum_rgbd,
      "depth and colour images with poses, in TUM's layout or as frame-XXXXXX.*: STATE and KEYFRAME onto "
      "--url, "
      "DEPTH onto --depth-url, or without --url all into the log --out at once; --config names the rig");
  app.add_option("--up", options.up, "with --tum-rgbd: the axis of its poses' frame that points up")
      ->check(CLI::IsMember({"x", "-x", "y", "-y", "z", "-z"}))
      ->capture_default_str();
  app.add_option(
         "--depth-per-m", options.depth_per_m,
         "with --tum-rgbd: numbers of its depth images per metre (default: 5000 in TUM's layout, else 1000)")
      ->check(CLI::Range(1.0, 1e6));
  app.add_option("--log", options.log, "an LCM log: publish its messages again; ends with it");
  app.add_option("--channels", options.channels,
                 "with --log: only channels that match this regular expression")
      ->capture_default_str();
  app.add_option(
      "--pose-graph", options.pose_graph,
      "robot<i>.csv or a folder of them, with --robot: KEYFRAME and LOOP, one keyframe a second; stays "
      "after the end to answer RESEND");
  app.add_option("--speed", options.speed, "times recorded time; 0: as fast as is safe")
      ->check(CLI::Range(0.0, 1e6))
      ->capture_default_str();
}

std::shared_ptr<void> make_player(Process& process, const PlayerOptions& options) {
  check_one_source(options);
  if (!options.asl.empty()) return std::make_shared<AslNode>(process, options);
  if (!options.tum_rgbd.empty()) return std::make_shared<RgbdNode>(process, options);
  if (!options.log.empty()) return std::make_shared<LogNode>(process, options);
  if (process.robot() < 0) throw_input_error("--pose-graph needs --robot, the robot that speaks");
  return std::make_shared<PoseGraphNode>(process, options);
}

void convert(const PlayerOptions& options, const std::filesystem::path& config,
             const std::filesystem::path& log) {
  check_one_source(options);
  if (!options.tum_rgbd.empty()) return convert_rgbd(options, config, log);
  if (options.asl.empty()) throw_input_error("--url is needed where --robot is not given");
  convert_asl(options.asl, log);
}

}  // namespace covey
