// SPDX-License-Identifier: BSD-3-Clause
#include "procs/pgo/problem.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>

#include "core/base/error.h"
#include "core/pgo/experiment.h"
#include "core/pgo/g2o.h"
#include "core/pgo/robot_csv.h"

namespace covey {
namespace {

template <typename... Args>
void warn(fmt::format_string<Args...> format, Args&&... args) {
  fmt::print(stderr, "pgo: {}\n", fmt::format(format, std::forward<Args>(args)...));
}

pgo::PoseGraph load_robots(const ProblemOptions& options) {
  const pgo::Restriction own = pgo::keep_robots_with_odometry(pgo::read_robot_csv(options.graph));
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
  return own.graph;
}

pgo::PoseGraph load_g2o(const ProblemOptions& options) {
  const pgo::G2oFile file = pgo::read_g2o(options.graph);
  for (const auto& [tag, count] : file.unknown_tags) {
    warn("{}: {} lines of the unknown tag {} are left out", options.graph.string(), count, tag);
  }
  const int robots = std::max(1, options.robots);
  if (robots > file.graph.poses()) {
    throw_input_error("{}: {} poses cannot be cut for --robots {}", options.graph.string(),
                      file.graph.poses(), robots);
  }
  return pgo::cut_into_robots(file.graph, robots);
}

void check_connected(const pgo::PoseGraph& graph, const std::filesystem::path& file) {
  const std::vector<int> parts = pgo::connected_parts(graph);
  const auto apart = std::find_if(parts.begin(), parts.end(), [](int part) { return part != 0; });
  if (apart == parts.end()) return;
  const auto offsets = graph.offsets();
  const auto flat = static_cast<int>(apart - parts.begin());
  const auto robot =
      static_cast<int>(std::upper_bound(offsets.begin(), offsets.end(), flat) - offsets.begin()) - 1;
  throw_input_error("{}: pose {} of robot {} is not connected to the first pose by any edges", file.string(),
                    flat - offsets[robot], robot);
}

Trajectory load_reference(const std::filesystem::path& file, const pgo::PoseGraph& graph) {
  if (file.extension() != ".g2o") return read_tum(file);
  const pgo::G2oFile g2o = pgo::read_g2o(file);
  if (!g2o.start)
    throw_input_error("{}: has no VERTEX line for each pose, so it is no reference", file.string());
  if (g2o.graph.poses() != graph.poses()) {
    throw_input_error("{}: has {} poses where the graph has {}", file.string(), g2o.graph.poses(),
                      graph.poses());
  }
  return to_trajectory(*g2o.start);
}

}  // namespace

Problem load_problem(const ProblemOptions& options) {
  const bool robot_files =
      std::filesystem::is_directory(options.graph) || options.graph.extension() == ".csv";
  Problem problem;
  problem.without_outliers = robot_files ? load_robots(options) : load_g2o(options);
  check_connected(problem.without_outliers, options.graph);
  if (options.outliers > 0.0 && problem.without_outliers.poses() < 3) {
    throw_input_error("{}: --outliers wants a graph of at least three poses", options.graph.string());
  }
  pgo::Injection injection = pgo::inject_outliers(problem.without_outliers, options.outliers, options.seed);
  problem.graph = std::move(injection.graph);
  problem.is_true = std::move(injection.is_true);
  problem.truth_known = options.outliers > 0.0;
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
