// SPDX-License-Identifier: BSD-3-Clause
// Time of the central solvers' parts: reading, chordal start, least squares, alignment of a pair, and graduated
// non-convexity, on generated graphs and, where the data folder is there, on benchmark graphs. There `l2`, the whole of
// least squares with its start, stands beside what SE-Sync takes for the same graph.
#include <benchmark/benchmark.h>

#include <ctime>
#include <string>

#include "core/pgo/central.h"
#include "core/pgo/experiment.h"
#include "core/pgo/g2o.h"
#include "core/pgo/start.h"
#include "tests/core/pgo/worlds.h"
#include "tests/data.h"

using namespace covey;
using namespace covey::pgo;

namespace {

PoseGraph generated(int poses) {
  return make_walk({.poses = poses, .rotation_sigma = 0.02, .grid = 12}).graph;
}

void least_squares(benchmark::State& state, const PoseGraph& graph) {
  for (auto _ : state) benchmark::DoNotOptimize(solve_least_squares(graph, chordal_start(graph)).cost);
}

void chordal(benchmark::State& state, const PoseGraph& graph) {
  for (auto _ : state) benchmark::DoNotOptimize(chordal_start(graph));
}

void robust(benchmark::State& state, const PoseGraph& graph) {
  for (auto _ : state) {
    benchmark::DoNotOptimize(solve_robust(graph, robust_start(graph).poses, {.barc2 = 16.8}).cost);
  }
}

void align_200(benchmark::State& state) {
  std::vector<SE3> candidates(100);  // that agree, and as many that do not
  const PoseGraph graph = inject_outliers(cut_into_robots(generated(1000), 2), 0.7, 1).graph;
  for (std::size_t k = 1; k <= 100; ++k)
    candidates.push_back(graph.edges[graph.edges.size() - k].measurement);
  for (auto _ : state) benchmark::DoNotOptimize(align_pair(candidates).inliers);
}
BENCHMARK(align_200)->Unit(benchmark::kMillisecond);

// SE-Sync's seconds, whole solve, median on two cores of this class (../shared/reference/pgo.md).
struct Peer {
  const char* graph;
  double se_sync_seconds;
};
constexpr Peer kPeers[] = {{"smallGrid3D", 0.059},   {"intel", 0.035},     {"mit", 0.035},
                           {"parking-garage", 0.47}, {"sphere2500", 0.56}, {"torus3D", 0.93},
                           {"cubicle", 1.36}};

void beside_se_sync(benchmark::State& state, const PoseGraph& graph, double se_sync_seconds) {
  std::clock_t clocks = 0;
  for (auto _ : state) {
    const std::clock_t begin = std::clock();
    benchmark::DoNotOptimize(solve_least_squares(graph, chordal_start(graph)).cost);
    clocks += std::clock() - begin;
  }
  const double seconds =
      static_cast<double>(clocks) / CLOCKS_PER_SEC / static_cast<double>(state.iterations());
  state.counters["cpu_s"] = seconds;
  state.counters["se_sync_s"] = se_sync_seconds;
  state.counters["of_se_sync"] = seconds / se_sync_seconds;
}

void register_graphs() {
  const auto add = [](const std::string& name, auto function, const PoseGraph& graph) {
    benchmark::RegisterBenchmark(name.c_str(), function, graph)->Unit(benchmark::kMillisecond);
  };
  const PoseGraph walk = generated(2000);
  add("chordal_start/generated2000", chordal, walk);
  add("least_squares/generated2000", least_squares, walk);
  add("robust/generated500_half_wrong", robust,
      inject_outliers(cut_into_robots(generated(500), 3), 0.5, 1).graph);
  for (const Peer& peer : kPeers) {
    const std::string name = peer.graph;
    const auto file = test_data("pose_graphs/" + name + ".g2o");
    if (!file) continue;
    const PoseGraph graph = read_g2o(*file).graph;
    add("chordal_start/" + name, chordal, graph);
    benchmark::RegisterBenchmark(("l2/" + name).c_str(), beside_se_sync, graph, peer.se_sync_seconds)
        ->Unit(benchmark::kMillisecond);
    benchmark::RegisterBenchmark(("read_g2o/" + name).c_str(), [path = *file](benchmark::State& state) {
      for (auto _ : state) benchmark::DoNotOptimize(read_g2o(path).graph.edges.size());
    })->Unit(benchmark::kMillisecond);
  }
}

const bool kRegistered = (register_graphs(), true);

}  // namespace
