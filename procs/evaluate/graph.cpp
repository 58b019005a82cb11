// SPDX-License-Identifier: BSD-3-Clause
#include <CLI/CLI.hpp>
#include <fstream>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "core/base/error.h"
#include "core/eval/graph_score.h"
#include "core/pgo/robot_csv.h"
#include "core/pgo/trajectories.h"
#include "procs/evaluate/commands.h"
#include "procs/evaluate/team_log.h"

namespace covey {
namespace {

using Json = nlohmann::ordered_json;

struct GraphOptions {
  std::filesystem::path graph;
  std::vector<std::filesystem::path> estimates;
  std::vector<std::filesystem::path> truths;
  std::vector<std::filesystem::path> logs;
  std::filesystem::path loops;  // output
  double barc2 = 0.0;
  ClosureLimits limits;
};

pgo::Poses read_poses(const pgo::PoseGraph& graph, const std::vector<std::filesystem::path>& files,
                      const char* option) {
  if (static_cast<int>(files.size()) != graph.robots()) {
    throw_input_error("{} has {} files, and the graph has {} robots; give one for each, in order", option,
                      files.size(), graph.robots());
  }
  std::vector<Trajectory> robots;
  for (const auto& file : files) robots.push_back(read_tum(file));
  return pgo::from_trajectories(graph, robots);
}

Json to_json(const PairScore& score) {
  Json json = {{"total", score.total}, {"accepted", score.kept}};
  if (score.truth_known) json.update({{"true", score.kept_right}, {"true_total", score.right}});
  return json;
}

const char* word_for(const JudgedClosure& closure) {
  if (!closure.kept) return "rejected";
  if (!closure.right) return "accepted";
  return *closure.right ? "true" : "false";
}

// One closure a line, as viewer_offscreen draws it: both ends as estimated, and what became of it.
void write_loops(const std::filesystem::path& file, const pgo::PoseGraph& graph, const pgo::Poses& poses,
                 const std::vector<JudgedClosure>& closures) {
  std::ofstream stream(file);
  const std::vector<int> offsets = graph.offsets();
  const auto position = [&](const pgo::PoseId& id) {
    const Eigen::Vector3d& t = poses[offsets[id.robot] + id.index].translation;
    return fmt::format("{:.4f} {:.4f} {:.4f}", t.x(), t.y(), t.z());
  };
  auto closure = closures.begin();
  for (const pgo::Edge& edge : graph.edges) {
    if (edge.kind != pgo::EdgeKind::kLoop) continue;
    stream << fmt::format("{} {} {}\n", position(edge.from), position(edge.to), word_for(*closure++));
  }
  if (!stream.flush()) throw_input_error("{}: cannot be written", file.string());
}

void print_score(const GraphOptions& options) {
  const pgo::PoseGraph graph = pgo::read_robot_csv(options.graph);
  GraphSolution solution{read_poses(graph, options.estimates, "--estimate"), std::nullopt};
  if (!options.logs.empty()) {
    const std::vector<double> residuals_sq = pgo::squared_residuals(pgo::robust_form(graph), solution.poses);
    solution.kept = kept_by_weights(graph, residuals_sq, weights_in_logs(options.logs));
  }
  std::optional<pgo::Poses> truth;
  if (!options.truths.empty()) truth = read_poses(graph, options.truths, "--truth");
  const GraphScore score = score_graph(graph, solution, options.barc2, truth, options.limits);

  if (!options.loops.empty()) write_loops(options.loops, graph, solution.poses, score.closures);

  Json json = {{"cost", score.robust.cost},
               {"barc2", options.barc2},
               {"robots", graph.robots()},
               {"poses", graph.poses()},
               {"loops_below_threshold", score.robust.kept_loops},
               {"loops", to_json(score.loops.sum)}};
  if (score.loops.precision) json["precision"] = *score.loops.precision;
  if (score.loops.recall) json["recall"] = *score.loops.recall;
  for (const PairScore& pair : score.loops.pairs) {
    Json entry = {{"a", pair.a}, {"b", pair.b}};
    entry.update(to_json(pair));
    json["pairs"].push_back(entry);
  }
  std::cout << json.dump(2) << "\n";
}

}  // namespace

void add_graph_command(CLI::App& app) {
  auto options = std::make_shared<GraphOptions>();
  CLI::App* command =
      app.add_subcommand("graph", "robust cost of a team's solution of a pose graph, and its loop closures");
  command->add_option("--graph", options->graph, "folder of robot<i>.csv")->required();
  command->add_option("--estimate", options->estimates, "TUM files, one per robot, in one frame")->required();
  command->add_option("--barc2", options->barc2, "squared residual above which a closure is an outlier")
      ->required()
      ->check(CLI::PositiveNumber);
  command->add_option("--truth", options->truths, "TUM files, one per robot: which closures are right");
  command->add_option("--true-within-m", options->limits.translation_m, "of a true closure")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  command->add_option("--true-within-deg", options->limits.rotation_deg, "of a true closure")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  command->add_option(
      "--log", options->logs,
      "logs of the robots' buses: accepted is what LOOP_WEIGHTS says, not what the residuals say");
  command->add_option("--loops", options->loops, "write the closures, with their ends, for viewer_offscreen");
  command->callback([options] { print_score(*options); });
}

}  // namespace covey
