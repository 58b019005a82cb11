// SPDX-License-Identifier: BSD-3-Clause
#include "procs/sim/simulate.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdlib>
#include <optional>

#include "core/base/error.h"
#include "core/sim/cameras.h"
#include "core/sim/scenario.h"
#include "procs/common/robot_config.h"
#include "procs/sim/grid.h"
#include "procs/sim/interrupt.h"
#include "procs/sim/sensors.h"
#include "procs/sim/sink.h"
#include "procs/sim/truth_files.h"

namespace covey {
namespace {

std::filesystem::path data_folder(const SimOptions& options) {
  if (!options.data.empty()) return options.data;
  const char* variable = std::getenv("COVEY_DATA");
  return variable == nullptr ? "" : variable;
}

std::filesystem::path config_file(const SimOptions& options) {
  if (!options.config.empty()) return options.config;
  return std::filesystem::path(COVEY_CONFIGS) / "robots" /
         (options.world.starts_with("euroc") ? "euroc.yaml" : "default.yaml");
}

bool wants_sensors(const SimOptions& options) {
  return !options.log.empty() || !options.asl.empty() || !options.url.empty();
}

SimOptions with_defaults(SimOptions options) {
  if (!options.motion.empty()) {
    options.motion =
        std::filesystem::absolute(options.motion / "").parent_path();  // its last part is its name
    if (options.world.empty()) options.world = sim::world_for(options.motion);
    options.robots = 1;
    options.robot = std::max(options.robot, 0);
    constexpr double kEndless = 1e5;
    if (options.seconds == 0.0) options.seconds = kEndless;
    return options;
  }
  if (options.world.empty()) options.world = options.graph.empty() ? "town" : "grid";
  if (options.seconds == 0.0) options.seconds = options.world == "grid" ? 120.0 : 45.0;
  return options;
}

void check(const SimOptions& options) {
  if (!options.motion.empty() && !options.world.starts_with("euroc"))
    throw_input_error("--motion is for --world euroc-v1 and euroc-mh");
  if (options.imu_seed && options.world != "town" && options.world != "rooms")
    throw_input_error(
        "--imu-seed is for --world town and rooms; recorded flights have the IMU that was recorded");
  if (options.robot >= options.robots) {
    throw_input_error("--robot {}: there are only robots 0 to {}; raise --robots", options.robot,
                      options.robots - 1);
  }
  if (options.world == "grid") {
    if (options.graph.empty())
      throw_input_error("--world grid is a pose graph: give --graph DIR, where its files go");
    if (wants_sensors(options) || !options.truth.empty() || !options.smoothing.empty())
      throw_input_error("--world grid has no sensors; it only takes --graph");
    return;
  }
  if (!options.graph.empty()) throw_input_error("--graph is for --world grid");
  const int outputs =
      (options.log.empty() ? 0 : 1) + (options.asl.empty() ? 0 : 1) + (options.url.empty() ? 0 : 1);
  if (outputs > 1) throw_input_error("give one of --log, --asl and --url");
  if (outputs == 1 && options.robot < 0)
    throw_input_error("--robot is needed: whose sensors go to --log, --asl or --url");
  if (outputs == 0 && options.truth.empty() && options.smoothing.empty())
    throw_input_error("say what to make: --log F.lcm, --asl DIR or --url U, and --truth DIR");
  if (!options.depth_url.empty() && options.url.empty()) throw_input_error("--depth-url goes with --url");
}

std::unique_ptr<SensorSink> make_sink(const SimOptions& options, const Rig& rig, const sim::Ride& ride) {
  if (!options.log.empty()) return make_log_sink(options.log);
  if (!options.asl.empty()) return make_asl_sink(options.asl, rig, ride);
  return make_bus_sink(options);
}

sim::CameraOptions camera_options(const SimOptions& options) {
  sim::CameraOptions cameras;
  cameras.seed = options.seed;
  Config config = load_robot_config(config_file(options), "sim");
  sim::read_cameras(config.root().section("sim"), cameras);
  config.check_all_read();
  return cameras;
}

void simulate_team(const SimOptions& options) {
  const Rig rig = load_robot_rig(config_file(options));
  const sim::CameraOptions cameras = camera_options(options);
  if (!options.smoothing.empty()) write_smoothing_figures(data_folder(options), rig.imu, options.smoothing);
  if (options.truth.empty() && !wants_sensors(options)) return;
  const sim::Scenario scenario = sim::make_scenario({.world = options.world,
                                                     .robots = options.robots,
                                                     .seconds = options.seconds,
                                                     .seed = options.seed,
                                                     .imu_seed = options.imu_seed,
                                                     .data = data_folder(options),
                                                     .motion = options.motion,
                                                     .imu = rig.imu});
  if (!options.truth.empty()) write_truth(options, scenario);
  if (!wants_sensors(options)) return;
  const sim::Ride ride = scenario.ride(options.robot);
  const auto sink = make_sink(options, rig, ride);
  std::optional<sim::SensorCameras> lenses;
  if (!options.imu_only) lenses.emplace(scenario.world, rig, cameras);
  run_sensors(ride, lenses ? &*lenses : nullptr, rig.depth.has_value() && !options.no_depth, *sink);
}

}  // namespace

void add_sim_options(CLI::App& app, SimOptions& options) {
  app.add_option(
         "--world", options.world,
         "town: ground robots in streets; rooms: the same in rooms off a corridor; euroc-v1, euroc-mh: "
         "EuRoC's motion and IMU in a furnished room, in "
         "a "
         "machine hall; grid: a pose graph of robots that drive through a town (default: town, with --graph "
         "grid, with --motion the one of euroc-v1 and euroc-mh that it fits in)")
      ->check(CLI::IsMember({"town", "rooms", "euroc-v1", "euroc-mh", "grid"}));
  app.add_option("--robots", options.robots, "how many robots there are")
      ->check(CLI::Range(1, 64))
      ->capture_default_str();
  app.add_option("--robot", options.robot, "whose sensors; with grid: write only this robot's files")
      ->check(CLI::Range(0, 63));
  app.add_option("--seconds", options.seconds,
                 "length of the drive (default: 45); with --motion at most (default: all of it); grid: one "
                 "keyframe a second "
                 "(default: 120)")
      ->check(CLI::Range(2.0, 100'000.0));
  app.add_option("--seed", options.seed, "the same seed gives the same world and the same bytes")
      ->capture_default_str();
  app.add_option(
      "--imu-seed", options.imu_seed,
      "town, rooms: the same drive seen by an IMU with errors of this seed (default: that of --seed)");
  app.add_option("--data", options.data,
                 "folder with recorded motion, euroc/motion/SEQUENCE (default: the variable COVEY_DATA)");
  app.add_option(
      "--motion", options.motion,
      "folder of one recorded flight, with imu0.csv.gz and groundtruth.csv.gz: one robot flies it");
  app.add_option("--config", options.config,
                 "YAML: 'sensors' names the calibration, section 'sim' overrides the world's parameters");
  app.add_option("--log", options.log, "write the robot's IMU, STEREO and DEPTH to this LCM log");
  app.add_option("--asl", options.asl, "write the robot's data to DIR/mav0, in EuRoC's layout");
  app.add_option("--url", options.url, "publish the robot's data on this bus as they come");
  app.add_option("--depth-url", options.depth_url, "with --url: the bus of DEPTH (default: the same)");
  app.add_option("--speed", options.speed, "with --url: times real time")
      ->check(CLI::Range(1e-3, 1e3))
      ->capture_default_str();
  app.add_flag("--no-depth", options.no_depth, "leave DEPTH out");
  app.add_flag("--imu-only", options.imu_only, "leave STEREO and DEPTH out: nothing is drawn");
  app.add_option("--truth", options.truth, "folder for what is true: world, labels, contacts, trajectories");
  app.add_option("--graph", options.graph,
                 "with grid: output folder for robot<i>.csv and robot<i>_truth.tum");
  app.add_option("--smoothing", options.smoothing,
                 "JSON file: how well the smoothed motion of every recorded sequence fits its IMU and truth");
}

void simulate(const SimOptions& given) {
  const SimOptions options = with_defaults(given);
  check(options);
  handle_interrupts();
  if (options.world == "grid") {
    write_grid(options);
  } else {
    simulate_team(options);
  }
}

}  // namespace covey
