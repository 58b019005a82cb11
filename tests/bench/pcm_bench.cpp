// SPDX-License-Identifier: BSD-3-Clause
// Time of PCM for two robots by the number of loops between them, half of which are wrong: of judging all pairs, and of the
// clique, exact (at most 20 s) and greedy. Arguments: loops, probability of the threshold in percent.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <ctime>
#include <random>

#include "core/pgo/chi_square.h"
#include "core/pgo/experiment.h"
#include "core/pgo/pcm.h"
#include "tests/core/pgo/worlds.h"

using namespace covey;
using namespace covey::pgo;

namespace {

PoseGraph two_robots(int loops) {
  const PoseGraph team =
      cut_into_robots(make_walk({.poses = 1500, .rotation_sigma = 0.005, .grid = 7}).graph, 2);
  PoseGraph graph{team.dimension, team.poses_per_robot, {}};
  std::vector<Edge> between;
  for (const Edge& edge : team.edges) {
    if (edge.kind == EdgeKind::kOdometry) graph.edges.push_back(edge);
    if (edge.between_robots()) between.push_back(edge);
  }
  std::mt19937_64 random(1);
  std::shuffle(between.begin(), between.end(), random);
  between.resize(std::min<std::size_t>(between.size(), loops / 2));
  graph.edges.insert(graph.edges.end(), between.begin(), between.end());
  return inject_outliers(graph, 0.5, 1).graph;
}

double cpu_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

void consistency(benchmark::State& state, bool exact) {
  const PoseGraph graph = two_robots(static_cast<int>(state.range(0)));
  PcmOptions options{.barc2 = chi_square_quantile(static_cast<double>(state.range(1)) / 100.0, 6)};
  options.clique = {.exact = exact, .clock = cpu_seconds, .time_limit_s = 20.0};
  PcmResult result;
  for (auto _ : state) result = consistent_loops(graph, options);
  const PcmGroup& group = result.groups.front();
  state.counters["loops"] = group.loops;
  state.counters["kept"] = group.kept;
  state.counters["agreeing"] =
      2.0 * group.agreeing_pairs / (static_cast<double>(group.loops) * (group.loops - 1));
  state.counters["exact"] = group.exact ? 1.0 : 0.0;
  state.counters["clique_s"] = group.seconds;
}
BENCHMARK_CAPTURE(consistency, exact, true)
    ->ArgsProduct({{100, 200, 400, 700, 1000}, {50, 99}})
    ->Iterations(1)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(consistency, greedy, false)
    ->ArgsProduct({{100, 200, 400, 700, 1000}, {50, 99}})
    ->Iterations(1)
    ->Unit(benchmark::kMillisecond);

}  // namespace
