// SPDX-License-Identifier: BSD-3-Clause
#include "procs/pgo/problem.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>

#include "core/base/error.h"
#include "core/pgo/experiment.h"
#include "core/pgo/g2o.h"
#include "core/pgo/kitti_loops.h"
#include "core/pgo/robot_csv.h"

namespace covey {
namespace {

template <typename... Args>
void warn(fmt::format_string<Args...> format, Args&&... args) {
  fmt::print(stderr, "pgo: {}\n", fmt::format(format, std::forward<Args>(args)...));
}

Problem load_robots(const ProblemOptions& options) {
  pgo::Restriction own = pgo::keep_robots_with_odometry(pgo::read_robot_csv(options.graph));
  if (own.dropped_edges > 0) {
    warn("{}: {} edges to robots whose files are not there are left out", options.graph.string(),
         own.dropped_edges);
  }
  const auto& poses = own.graph.poses_per_robot;
  const auto robots = std::count_if(poses.begin(), poses.end(), [](int n) { return n > 0; });
  if (options.robots != 0 && options.robots != robots) {
    throw_input_error("{}: holds {} robots, so --robots {} cannot be had; only g2o graphs are cut",
                      options.graph.string(), robots, options.robots);
  }
  if (!options.true_loops.empty())
    throw_input_error("--true-loops: {} is no g2o file, whose vertices it could name",
                      options.graph.string());
  Problem problem;
  problem.graph = std::move(own.graph);
  return problem;
}

Problem load_g2o(const ProblemOptions& options) {
  const pgo::G2oFile file = pgo::read_g2o(options.graph);
  for (const auto& [tag, count] : file.unknown_tags) {
    warn("{}: {} lines of the unknown tag {} are left out", options.graph.string(), count, tag);
  }
  const int robots = std::max(1, options.robots);
  if (robots > file.graph.poses()) {
    throw_input_error("{}: {} poses cannot be cut for --robots {}", options.graph.string(),
                      file.graph.poses(), robots);
  }
  Problem problem;
  problem.graph = pgo::cut_into_robots(file.graph, robots);
  if (!options.true_loops.empty()) problem.is_true = pgo::read_true_loops(options.true_loops, file);
  return problem;
}

Problem make_world(const ProblemOptions& options) {
  if (options.world != "stata") throw_input_error("--world: there is no '{}', only stata", options.world);
  if (options.robots != 0 || options.outliers > 0.0 || !options.true_loops.empty())
    throw_input_error(
        "--world {}: brings its own robots and outliers; take --robots, --outliers, --true-loops away",
        options.world);
  pgo::StataWorld world = pgo::stata_like({.seed = options.seed});
  Problem problem;
  problem.graph = std::move(world.graph);
  problem.is_true = std::move(world.is_true);
  problem.reference = to_trajectory(world.truth);
  return problem;
}

void check_connected(const pgo::PoseGraph& graph, const std::string& name) {
  const std::vector<int> parts = pgo::connected_parts(graph);
  const auto apart = std::find_if(parts.begin(), parts.end(), [](int part) { return part != 0; });
  if (apart == parts.end()) return;
  const auto offsets = graph.offsets();
  const auto flat = static_cast<int>(apart - parts.begin());
  const auto robot =
      static_cast<int>(std::upper_bound(offsets.begin(), offsets.end(), flat) - offsets.begin()) - 1;
  throw_input_error("{}: pose {} of robot {} is not connected to the first pose by any edges", name,
                    flat - offsets[robot], robot);
}

bool is_g2o(const std::filesystem::path& file) {
  const std::string name = file.string();
  return name.ends_with(".g2o") || name.ends_with(".g2o.gz");
}

Trajectory load_reference(const std::filesystem::path& file, const pgo::PoseGraph& graph) {
  if (!is_g2o(file)) return read_tum(file);
  const pgo::Poses poses = pgo::read_truth(file);
  if (static_cast<int>(poses.size()) != graph.poses())
    throw_input_error("{}: has {} poses where the graph has {}", file.string(), poses.size(), graph.poses());
  return to_trajectory(poses);
}

pgo::PoseGraph true_part(const pgo::PoseGraph& graph, const std::vector<bool>& is_true) {
  pgo::PoseGraph part{graph.dimension, graph.poses_per_robot, {}};
  for (std::size_t e = 0; e < graph.edges.size(); ++e) {
    if (is_true[e]) part.edges.push_back(graph.edges[e]);
  }
  return part;
}

void add_outliers(const ProblemOptions& options, Problem& problem) {
  if (problem.graph.poses() < 3)
    throw_input_error("{}: --outliers wants a graph of at least three poses", options.graph.string());
  pgo::Injection injection = pgo::inject_outliers(problem.graph, options.outliers, options.seed);
  for (std::size_t e = 0; e < problem.is_true.size(); ++e) injection.is_true[e] = problem.is_true[e];
  problem.graph = std::move(injection.graph);
  problem.is_true = std::move(injection.is_true);
}

}  // namespace

Problem load_problem(const ProblemOptions& options) {
  if (options.graph.empty() == options.world.empty())
    throw_input_error("exactly one of --graph and --world says what to solve");
  const bool robot_files =
      std::filesystem::is_directory(options.graph) || options.graph.extension() == ".csv";
  Problem problem = !options.world.empty() ? make_world(options)
                    : robot_files          ? load_robots(options)
                                           : load_g2o(options);
  check_connected(problem.graph, options.graph.empty() ? options.world : options.graph.string());
  if (options.outliers > 0.0) add_outliers(options, problem);
  problem.truth_known = !problem.is_true.empty();
  if (!problem.truth_known) problem.is_true.assign(problem.graph.edges.size(), true);
  problem.without_outliers = true_part(problem.graph, problem.is_true);
  if (!options.reference.empty()) problem.reference = load_reference(options.reference, problem.graph);
  return problem;
}

Trajectory to_trajectory(const pgo::Poses& poses) {
  Trajectory trajectory;
  for (const SE3& T : poses) {
    trajectory.push_back({static_cast<Utime>(trajectory.size() + 1) * kUsPerSecond, T});
  }
  return trajectory;
}

}  // namespace covey
