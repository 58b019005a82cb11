// SPDX-License-Identifier: BSD-3-Clause
// How well place recognition does, against the truth: the keyframes of a team go to the robots' loop finders, which talk over a network
// that loses nothing. JSON on stdout.
//
//   bench_place [--world town] [--robots 3] [--seconds 45] [--seed 1] --config configs/robots/default.yaml [--images DIR]
//   bench_place --world rooms --aliases 200 --config configs/robots/indoor.yaml
//   bench_place --scenes rgbd/seven_scenes --config configs/robots/default.yaml
//
// A simulated world's keyframes are rendered; --images keeps the pictures, and takes those that are there. --scenes: a real sequence with
// depth, its halves as two robots'. --aliases: also how many pairs of places that look alike are accepted (aliases.h). --pairs: draws the best
// pairs of each two robots (best_pairs.h). --queries: also how long a query takes among so many keyframes, made from these. --memory: also how
// much memory a keyframe takes, own ones and others'.

#include <CLI/CLI.hpp>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <nlohmann/json.hpp>
#include <string>

#include "core/base/config.h"
#include "core/base/error.h"
#include "core/place/stereo_features.h"
#include "core/sim/scenario.h"
#include "procs/common/robot_config.h"
#include "procs/common/tool.h"
#include "procs/lcd/options.h"
#include "tests/bench/place/aliases.h"
#include "tests/bench/place/best_pairs.h"
#include "tests/bench/place/cpu_clock.h"
#include "tests/bench/place/memory.h"
#include "tests/bench/place/pictures.h"
#include "tests/bench/place/queries.h"
#include "tests/bench/place/retrieval.h"
#include "tests/bench/place/score.h"
#include "tests/bench/place/seven_scenes.h"
#include "tests/bench/place/team.h"

namespace covey::bench {
namespace {

constexpr Limits kTownLimits{0.5, 5.0};
constexpr Limits kRoomLimits{0.1, 5.0};
constexpr double kSceneCalibration = 0.05;  // 7-Scenes: focal length of a make, depth of another camera
constexpr double kLeastSimilarity = 0.03;  // the agent's: a tenth of that to the keyframe before, usually 0.3

struct Options {
  std::string world = "town";
  int robots = 3;
  double seconds = 45.0;
  std::uint64_t seed = 1;
  std::filesystem::path config;
  std::filesystem::path images;
  std::filesystem::path scenes;
  std::filesystem::path pairs;
  std::vector<int> queries;
  std::size_t aliases = 0;
  int memory = 0;
};

struct Robot {
  Rig rig;
  LcdNodeOptions lcd;
  std::shared_ptr<const place::Vocabulary> vocabulary;
};

Robot read_robot(const std::filesystem::path& config) {
  Config file = load_robot_config(config, "lcd");
  Robot robot;
  robot.rig = load_robot_rig(config);
  robot.lcd = read_lcd_options(file.root().section("lcd"), robot.rig);
  robot.vocabulary = std::make_shared<const place::Vocabulary>(
      place::Vocabulary::load(config.parent_path() / robot.lcd.vocabulary));
  return robot;
}

nlohmann::json report_of(const Team& team, const std::vector<Seen>& seen, const BestPairs& pairs,
                         const Limits& limits, double extract_s, const Options& options) {
  nlohmann::json report = score(team.views(), team.loops(), limits);
  const std::vector<Candidate> candidates = best_candidates(seen);
  report["curve"] = retrieval_curve(seen, candidates);
  if (!pairs.folder.empty()) report["best_pairs"] = draw_best_pairs(pairs, seen, candidates, team.loops());
  report.update(team.account());
  report["extract_ms"] = 1e3 * extract_s / static_cast<double>(team.views().size());
  report["query_ms"] = query_ms(team.bags(), kLeastSimilarity);
  for (const int keyframes : options.queries) {
    const double ms = query_ms(many_bags(team.bags(), keyframes), kLeastSimilarity);
    report["queries"].push_back({{"keyframes", keyframes}, {"query_ms", ms}});
  }
  return report;
}

nlohmann::json run_world(const Options& options, const Robot& robot) {
  const char* data = std::getenv("COVEY_DATA");
  sim::ScenarioOptions wanted;
  wanted.world = options.world;
  wanted.robots = options.robots;
  wanted.seconds = options.seconds;
  wanted.seed = options.seed;
  wanted.data = data ? data : "";
  wanted.imu = robot.rig.imu;
  const sim::Scenario scenario = sim::make_scenario(wanted);
  const place::StereoFeatures features(robot.rig, robot.lcd.features);
  Pictures pictures(options.images, scenario.world, robot.rig, options.seed);
  Team team(options.robots, robot.vocabulary, robot.lcd.agent);
  std::vector<Seen> seen;
  double extract_s = 0.0;
  const auto look = [&](const View& view) {
    const auto [left, right] = pictures.take(view);
    const CpuClock clock;
    place::FrameFeatures found = features.extract(left, right);
    extract_s += clock.seconds();
    return Seen{view, robot.vocabulary->bag(found.descriptors), std::move(found)};
  };
  for (const View& view : cut_keyframes(scenario)) {
    seen.push_back(look(view));
    team.add(view, seen.back().features);
  }
  team.finish();
  const auto picture = [&pictures](const View& view) { return pictures.take(view).first; };
  const BestPairs pairs{options.pairs, picture, robot.rig.left.camera, robot.lcd.agent.verification};
  nlohmann::json report = report_of(team, seen, pairs, kTownLimits, extract_s, options);
  if (options.aliases > 0) {
    if (options.world != "rooms") throw_input_error("--aliases is for --world rooms");
    report["aliases"] = try_aliases(seen, plant_aliases(seen, options.aliases), look,
                                    robot.lcd.agent.ask_similarity, robot.lcd.agent.verification);
  }
  return report;
}

nlohmann::json run_scenes(const Options& options, const Robot& robot) {
  const MountedCamera camera = scene_camera();
  place::LcdOptions agent = robot.lcd.agent;
  agent.verification.ransac_direction *= robot.rig.left.camera.fx / camera.camera.fx;
  agent.verification.calibration = kSceneCalibration;
  agent.verification.most_sigma_deg = kRoomLimits.rotation_deg;
  Team team(2, robot.vocabulary, agent);
  std::vector<Seen> all;
  double extract_s = 0.0;
  for (const View& view : scene_views(options.scenes)) {
    const SceneFrame frame = read_scene_frame(options.scenes, view);
    const CpuClock clock;
    place::FrameFeatures seen =
        place::features_with_depth(frame.image, frame.depth_m, camera, robot.lcd.features.orb);
    extract_s += clock.seconds();
    all.push_back({view, robot.vocabulary->bag(seen.descriptors), seen});
    team.add(view, std::move(seen));
  }
  team.finish();
  const auto picture = [&options](const View& view) { return read_scene_frame(options.scenes, view).image; };
  return report_of(team, all, {options.pairs, picture, camera.camera, agent.verification}, kRoomLimits,
                   extract_s, options);
}

int run(const Options& options) {
  cv::setNumThreads(1);
  const Robot robot = read_robot(options.config);
  nlohmann::json memory;
  if (options.memory > 0) {
    const MemoryUse use =
        memory_of(robot.vocabulary, robot.lcd.agent, robot.lcd.features.orb.features, options.memory);
    memory = {{"keyframes", options.memory}, {"own_kb", use.own_kb}, {"other_kb", use.other_kb}};
  }
  nlohmann::json report = options.scenes.empty() ? run_world(options, robot) : run_scenes(options, robot);
  if (!memory.is_null()) report["memory"] = memory;
  std::cout << report.dump(1) << "\n";
  return 0;
}

}  // namespace
}  // namespace covey::bench

int main(int argc, char** argv) {
  covey::bench::Options options;
  CLI::App app("place recognition against the truth", "bench_place");
  app.add_option("--world", options.world)->capture_default_str();
  app.add_option("--robots", options.robots)->capture_default_str();
  app.add_option("--seconds", options.seconds)->capture_default_str();
  app.add_option("--seed", options.seed)->capture_default_str();
  app.add_option("--config", options.config)->required();
  app.add_option("--images", options.images, "folder that keeps the pictures");
  app.add_option("--scenes", options.scenes, "folder of 7-Scenes' frames, instead of a simulated world");
  app.add_option("--pairs", options.pairs, "folder for pictures of the best accepted and refused pairs");
  app.add_option("--aliases", options.aliases,
                 "world rooms: so many pairs of places in rooms that are furnished alike");
  app.add_option("--queries", options.queries, "numbers of keyframes among which a query is timed");
  app.add_option("--memory", options.memory, "number of keyframes of either kind whose memory is measured");
  return covey::run_tool(argc, argv, app, [&options] { return covey::bench::run(options); });
}
