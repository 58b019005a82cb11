// SPDX-License-Identifier: BSD-3-Clause
#include <CLI/CLI.hpp>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "core/base/error.h"
#include "core/eval/ate.h"
#include "procs/evaluate/commands.h"

namespace covey {
namespace {

using Json = nlohmann::ordered_json;

struct TrajectoryOptions {
  std::vector<std::string> estimates;
  std::vector<std::string> references;
  std::vector<std::string> joint;  // estimate, reference, estimate, reference, ...
  AteOptions ate;
};

Json to_json(const TrajectoryError& error) {
  const Eigen::Quaterniond q = error.T_reference_estimate.rotation.canonical_quaternion();
  const Eigen::Vector3d& t = error.T_reference_estimate.translation;
  return {{"rmse_m", error.rmse_m},
          {"mean_m", error.mean_m},
          {"median_m", error.median_m},
          {"max_m", error.max_m},
          {"matched", error.matched},
          {"estimate_poses", error.estimate_poses},
          {"reference_poses", error.reference_poses},
          {"T_reference_estimate", {q.w(), q.x(), q.y(), q.z(), t.x(), t.y(), t.z()}}};
}

// The pairs of --estimate and --reference, then those of --joint.
std::vector<std::array<std::string, 2>> file_pairs(const TrajectoryOptions& options) {
  if (options.estimates.size() != options.references.size()) {
    throw_input_error("--estimate has {} files and --reference {}; give one reference for each estimate",
                      options.estimates.size(), options.references.size());
  }
  if (options.joint.size() % 2 != 0) {
    throw_input_error("--joint has {} files; give an estimate and its reference in turn",
                      options.joint.size());
  }
  std::vector<std::array<std::string, 2>> pairs;
  for (std::size_t k = 0; k < options.estimates.size(); ++k) {
    pairs.push_back({options.estimates[k], options.references[k]});
  }
  for (std::size_t k = 0; k < options.joint.size(); k += 2)
    pairs.push_back({options.joint[k], options.joint[k + 1]});
  return pairs;
}

void print_errors(const TrajectoryOptions& options) {
  const auto files = file_pairs(options);
  std::vector<TrajectoryPair> robots;
  for (const auto& [estimate, reference] : files) robots.push_back({read_tum(estimate), read_tum(reference)});
  const TeamError error = team_error(robots, options.ate);
  for (std::size_t r = 0; r < files.size(); ++r) {
    if (error.with_team[r].matched > 0) continue;
    throw_input_error("{} and {} have no stamps in common within {} s", files[r][0], files[r][1],
                      options.ate.max_stamp_difference_s);
  }
  Json json = {{"ate_m", error.team.rmse_m}};
  json.update(to_json(error.team));
  for (std::size_t r = 0; r < files.size(); ++r) {
    json["robots"].push_back({{"estimate", files[r][0]},
                              {"reference", files[r][1]},
                              {"with_team", to_json(error.with_team[r])},
                              {"by_itself", to_json(error.by_itself[r])}});
  }
  std::cout << json.dump(2) << "\n";
}

}  // namespace

void add_trajectory_command(CLI::App& app) {
  auto options = std::make_shared<TrajectoryOptions>();
  CLI::App* command = app.add_subcommand(
      "trajectory", "absolute trajectory error after SE(3) alignment; several robots share one alignment");
  command->add_option("--estimate", options->estimates, "TUM files, one per robot")->required();
  command->add_option("--reference", options->references, "TUM files, one per estimate, in the same order")
      ->required();
  command
      ->add_option("--joint", options->joint,
                   "further robots of the team: estimate, reference, estimate, ...")
      ->expected(0, -1);
  command
      ->add_option("--max-stamp-difference-s", options->ate.max_stamp_difference_s,
                   "poses further apart in time are not compared")
      ->check(CLI::Range(0.0, 10.0))
      ->capture_default_str();
  command->callback([options] { print_errors(*options); });
}

}  // namespace covey
