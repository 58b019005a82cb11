// SPDX-License-Identifier: BSD-3-Clause
// Bytes until the robust cost is within a gap of central graduated non-convexity's: the distributed solver (dgnc) beside the one
// where a robot gathers the graph (elected). Graphs are those of the data folder: intel cut in three, without and with random
// loops between robots, tunnels, and sphere2500 cut in five and in three. JSON on stdout.
//
//   bench_pgo_bytes [--graphs intel tunnels ...] [--seeds 1 2] [--gap 1e-3] [--mu-step 1.4]
//
// "ratio": dgnc_bytes over elected_bytes. "whole_": of the run that goes on to its end, its gap among them.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <iostream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/pgo/central.h"
#include "core/pgo/chi_square.h"
#include "core/pgo/cost.h"
#include "core/pgo/experiment.h"
#include "core/pgo/g2o.h"
#include "core/pgo/robot_csv.h"
#include "core/pgo/solve_distributed.h"
#include "core/pgo/start.h"
#include "procs/common/tool.h"
#include "tests/data.h"

namespace covey {
namespace {

struct Case {
  std::string graph;
  int robots = 0;  // 0: as many as there are files
  double outliers = 0.0;
  double barc2 = 0.0;  // 0: the 99 % quantile
};

const std::vector<Case> kCases = {
    {"intel", 3},      {"intel", 3, 0.3}, {"intel", 3, 0.7},     {"tunnels", 0, 0.0, 100.0},
    {"sphere2500", 5}, {"sphere2500", 3}, {"sphere2500", 3, 0.3}};

std::optional<pgo::PoseGraph> load(const Case& one, std::uint64_t seed) {
  const auto file = test_data("pose_graphs/" + one.graph + (one.robots == 0 ? "" : ".g2o"));
  if (!file) return std::nullopt;
  if (one.robots == 0) return pgo::keep_robots_with_odometry(pgo::read_robot_csv(*file)).graph;
  const pgo::PoseGraph cut = pgo::cut_into_robots(pgo::read_g2o(*file).graph, one.robots);
  return one.outliers > 0.0 ? pgo::inject_outliers(cut, one.outliers, seed).graph : cut;
}

std::int64_t sum_of(const std::map<std::string, std::int64_t>& bytes) {
  std::int64_t sum = 0;
  for (const auto& [kind, count] : bytes) sum += count;
  return sum;
}

struct Bench {
  std::vector<std::string> graphs = {"intel", "tunnels", "sphere2500"};
  std::vector<std::uint64_t> seeds = {1};
  double gap = 1e-3;
  double mu_step = 0.0;

  int run() const {
    nlohmann::ordered_json rows = nlohmann::ordered_json::array();
    for (const Case& one : kCases) {
      if (std::find(graphs.begin(), graphs.end(), one.graph) == graphs.end()) continue;
      for (const std::uint64_t seed : seeds) {
        if (seed != seeds.front() && one.outliers == 0.0) continue;
        if (const auto graph = load(one, seed)) rows.push_back(measure(one, seed, *graph));
      }
    }
    std::cout << rows.dump(1) << "\n";
    return 0;
  }

  nlohmann::ordered_json measure(const Case& one, std::uint64_t seed, const pgo::PoseGraph& graph) const {
    const double barc2 = one.barc2 > 0.0
                             ? one.barc2
                             : pgo::chi_square_quantile(0.99, pgo::pose_degrees_of_freedom(graph.dimension));
    const auto cost = [&](const pgo::Poses& poses) { return pgo::robust_cost(graph, poses, barc2).cost; };
    const pgo::Poses start = pgo::robust_start(graph, {.min_inliers = 1}).poses;
    const double central = cost(pgo::solve_robust(graph, start, {.barc2 = barc2}).poses);

    const pgo::PoseGraph form = pgo::robust_form(graph);
    pgo::DistributedOptions options;
    options.dgnc.barc2 = barc2;
    options.dgnc.dimension = options.dgnc.alignment.dimension = graph.dimension;
    options.dgnc.mu_step = mu_step;
    const pgo::DistributedResult whole = pgo::solve_distributed(form, options);
    options.stop = [&](const pgo::DistributedProgress& progress) {
      return cost(progress.poses()) <= central * (1.0 + gap);
    };
    const pgo::DistributedResult dgnc = pgo::solve_distributed(form, options);
    options.stop = {};
    options.dgnc.solver = pgo::RoundSolver::kElected;
    const pgo::DistributedResult elected = pgo::solve_distributed(form, options);

    const nlohmann::ordered_json row = {
        {"graph", one.graph},
        {"robots", std::count_if(graph.poses_per_robot.begin(), graph.poses_per_robot.end(),
                                 [](int n) { return n > 0; })},
        {"outliers", one.outliers},
        {"seed", seed},
        {"central_cost", central},
        {"reached", cost(dgnc.poses) <= central * (1.0 + gap)},
        {"dgnc_bytes", sum_of(dgnc.bytes)},
        {"elected_bytes", sum_of(elected.bytes)},
        {"ratio", static_cast<double>(sum_of(dgnc.bytes)) / static_cast<double>(sum_of(elected.bytes))},
        {"updates", dgnc.updates},
        {"by_kind", dgnc.bytes},
        {"elected_gap", cost(elected.poses) / central - 1.0},
        {"whole_bytes", sum_of(whole.bytes)},
        {"whole_updates", whole.updates},
        {"whole_gap", cost(whole.poses) / central - 1.0}};
    std::cerr << row.dump() << "\n";
    return row;
  }
};

}  // namespace
}  // namespace covey

int main(int argc, char** argv) {
  covey::Bench bench;
  CLI::App app("Bytes to the cost of central graduated non-convexity: dgnc beside elected",
               "bench_pgo_bytes");
  app.add_option("--graphs", bench.graphs, "intel, tunnels, sphere2500")->capture_default_str();
  app.add_option("--seeds", bench.seeds, "of the outliers")->capture_default_str();
  app.add_option("--gap", bench.gap, "relative, to central GNC's robust cost")
      ->capture_default_str()
      ->check(CLI::PositiveNumber);
  app.add_option("--mu-step", bench.mu_step, "a fixed factor between stages instead of their schedule")
      ->check(CLI::Range(1.01, 100.0));
  return covey::run_tool(argc, argv, app, [&bench] { return bench.run(); });
}
