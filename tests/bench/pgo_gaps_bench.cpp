// SPDX-License-Identifier: BSD-3-Clause
// CPU time and bytes until least squares is within 1e-2, 1e-3, ... 1e-6 of the optimum: the central solver, block-coordinate descent
// (rbcd) and the second-order step (schur) in one run, each from its own chordal start, which is counted. The optimum is where the
// central solver ends. Every solver is run anew for each gap, and comparing with the optimum is not counted. JSON on stdout.
//
//   bench_pgo_gaps [--graphs sphere2500 torus3D ...] [--robots 5] [--limit 60]
//
// "times_central": seconds over the central solver's to the same gap.

#include <CLI/CLI.hpp>
#include <ctime>
#include <functional>
#include <iostream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/pgo/central.h"
#include "core/pgo/cost.h"
#include "core/pgo/experiment.h"
#include "core/pgo/g2o.h"
#include "core/pgo/rbcd.h"
#include "core/pgo/solve_schur.h"
#include "core/pgo/start.h"
#include "procs/common/tool.h"
#include "tests/data.h"

namespace covey {
namespace {

constexpr double kGaps[] = {1e-2, 1e-3, 1e-4, 1e-5, 1e-6};

double cpu_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

// Time of a run without the time spent on watching it.
class Watch {
 public:
  explicit Watch(double limit) : limit_(limit) {}

  // Whether the cost is low enough or the time is up.
  template <typename Cost>
  bool ends(double enough, Cost cost) {
    const double begin = cpu_seconds();
    reached_ = cost() <= enough;
    watching_ += cpu_seconds() - begin;
    return reached_ || seconds() > limit_;
  }
  bool reached() const { return reached_; }
  double seconds() const { return cpu_seconds() - begin_ - watching_; }

 private:
  double limit_;
  double begin_ = cpu_seconds();
  double watching_ = 0.0;
  bool reached_ = false;
};

struct Effort {
  bool reached = false;
  double seconds = 0.0;
  std::int64_t block_updates = 0;
  std::int64_t rounds = 0;
  std::int64_t bytes = 0;
};

std::int64_t sum_of(const std::map<std::string, std::int64_t>& bytes) {
  std::int64_t sum = 0;
  for (const auto& [kind, count] : bytes) sum += count;
  return sum;
}

// With one step more each time, of which the last run counts.
Effort central_effort(const pgo::PoseGraph& graph, double enough, double limit) {
  Effort effort;
  for (int steps = 0; !effort.reached && effort.seconds < limit && steps <= 100; ++steps) {
    Watch watch(limit);
    const pgo::Poses start = pgo::chordal_start(graph);
    const pgo::Poses poses =
        steps == 0 ? start : pgo::solve_least_squares(graph, start, {.max_iterations = steps}).poses;
    effort.seconds = watch.seconds();
    effort.rounds = steps;
    effort.reached = pgo::cost(graph, poses) <= enough;
  }
  return effort;
}

Effort rbcd_effort(const pgo::PoseGraph& graph, double enough, double limit) {
  Watch watch(limit);
  const pgo::Poses start = pgo::chordal_start(graph);
  if (watch.ends(enough, [&] { return pgo::cost(graph, start); })) return {true, watch.seconds(), 0, 0, 0};
  pgo::RbcdOptions options;
  options.stop = [&](const pgo::RbcdProgress& progress) {
    return watch.ends(
        enough, [&] { return progress.cost <= enough ? pgo::cost(graph, progress.poses()) : progress.cost; });
  };
  const pgo::RbcdResult result = pgo::solve_rbcd(graph, start, options);
  return {watch.reached(), watch.seconds(), result.block_updates, result.rounds, sum_of(result.bytes)};
}

Effort schur_effort(const pgo::PoseGraph& graph, double enough, double limit) {
  Watch watch(limit);
  const pgo::Poses start = pgo::chordal_start(graph);
  if (watch.ends(enough, [&] { return pgo::cost(graph, start); })) return {true, watch.seconds(), 0, 0, 0};
  pgo::SolveSchurOptions options;
  options.stop = [&](const std::function<pgo::Poses()>& poses) {
    return watch.ends(enough, [&] { return pgo::cost(graph, poses()); });
  };
  const pgo::SolveSchurResult result = pgo::solve_schur(graph, start, options);
  return {watch.reached(), watch.seconds(), result.block_updates, result.rounds, sum_of(result.bytes)};
}

struct Bench {
  std::vector<std::string> graphs = {"smallGrid3D", "intel",   "sphere2500",
                                     "torus3D",     "cubicle", "parking-garage"};
  int robots = 5;
  double limit = 60.0;

  int run() const {
    nlohmann::ordered_json rows = nlohmann::ordered_json::array();
    for (const std::string& name : graphs) {
      const auto file = test_data("pose_graphs/" + name + ".g2o");
      if (file) measure(name, pgo::read_g2o(*file).graph, rows);
    }
    std::cout << rows.dump(1) << "\n";
    return 0;
  }

  void measure(const std::string& name, const pgo::PoseGraph& graph, nlohmann::ordered_json& rows) const {
    const pgo::PoseGraph team = pgo::cut_into_robots(graph, robots);
    const double optimum = pgo::solve_least_squares(graph, pgo::chordal_start(graph)).cost;
    for (const double gap : kGaps) {
      const double enough = optimum * (1.0 + gap);
      const Effort central = central_effort(graph, enough, limit);
      const auto add = [&](const char* solver, const Effort& effort) {
        rows.push_back({{"graph", name},
                        {"robots", &effort == &central ? 1 : robots},
                        {"solver", solver},
                        {"gap", gap},
                        {"reached", effort.reached},
                        {"seconds", effort.seconds},
                        {"times_central", effort.seconds / central.seconds},
                        {"block_updates", effort.block_updates},
                        {"rounds", effort.rounds},
                        {"bytes", effort.bytes}});
        std::cerr << rows.back().dump() << "\n";
      };
      add("central", central);
      add("rbcd", rbcd_effort(team, enough, limit));
      add("schur", schur_effort(team, enough, limit));
    }
  }
};

}  // namespace
}  // namespace covey

int main(int argc, char** argv) {
  covey::Bench bench;
  CLI::App app("CPU time and bytes to gaps of 1e-2 to 1e-6, by solver", "bench_pgo_gaps");
  app.add_option("--graphs", bench.graphs, "names in the data folder's pose_graphs")->capture_default_str();
  app.add_option("--robots", bench.robots)->capture_default_str()->check(CLI::Range(2, 100));
  app.add_option("--limit", bench.limit, "CPU seconds of one run, after which it is given up")
      ->capture_default_str();
  return covey::run_tool(argc, argv, app, [&bench] { return bench.run(); });
}
