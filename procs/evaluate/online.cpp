// SPDX-License-Identifier: BSD-3-Clause
#include <CLI/CLI.hpp>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "core/base/bytes.h"
#include "core/base/error.h"
#include "core/eval/ate.h"
#include "core/eval/online.h"
#include "procs/common/channels.h"
#include "procs/common/log_file.h"
#include "procs/evaluate/commands.h"

namespace covey {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kAnchor = 0;

struct OnlineOptions {
  std::vector<std::string> logs;
  std::vector<std::string> references;
};

OnlineTrajectory read_online(const std::string& file, int robot) {
  OnlineTrajectory online(robot, kAnchor);
  LogReader log(file, [&online](const std::string& channel, const Bytes& bytes) {
    keyframe_t keyframe{};
    trajectory_t part{};
    if (channel == kKeyframe.name && decode(bytes, keyframe)) online.take(keyframe);
    if (channel == kTrajectory.name && decode(bytes, part)) online.take(part);
  });
  while (log.next_time()) log.deliver();
  return online;
}

Json to_json(const TrajectoryError& error, int keyframes) {
  Json json = {{"keyframes", keyframes}, {"counted", error.matched}};
  if (error.matched > 0) json["ate_m"] = error.rmse_m;
  return json;
}

void print_online(const OnlineOptions& options) {
  if (options.logs.size() != options.references.size()) {
    throw_input_error("--log has {} files and --reference {}; give one of each for every robot",
                      options.logs.size(), options.references.size());
  }
  std::vector<TrajectoryPair> pairs;
  std::vector<int> keyframes;
  int sum = 0;
  for (std::size_t r = 0; r < options.logs.size(); ++r) {
    const OnlineTrajectory online = read_online(options.logs[r], static_cast<int>(r));
    pairs.push_back({online.believed(), read_tum(options.references[r])});
    keyframes.push_back(online.keyframes());
    sum += online.keyframes();
  }
  const TeamError error = team_error(pairs);
  Json json = to_json(error.team, sum);
  for (std::size_t r = 0; r < pairs.size(); ++r) {
    Json robot = {{"robot", r}};
    robot.update(to_json(error.with_team[r], keyframes[r]));
    json["robots"].push_back(robot);
  }
  std::cout << json.dump(2) << "\n";
}

}  // namespace

void add_online_command(CLI::App& app) {
  auto options = std::make_shared<OnlineOptions>();
  CLI::App* command = app.add_subcommand(
      "online",
      "error of the poses that each robot believed when it took its keyframes; one alignment for all");
  command->add_option("--log", options->logs, "logs of the robots' buses: robot 0, 1, ... in order")
      ->required();
  command->add_option("--reference", options->references, "TUM files, one per log, in the same order")
      ->required();
  command->callback([options] { print_online(*options); });
}

}  // namespace covey
