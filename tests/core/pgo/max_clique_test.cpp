// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/max_clique.h"

#include <algorithm>
#include <bit>
#include <catch2/catch.hpp>
#include <random>

using namespace covey::pgo;

namespace {

BitGraph random_graph(int size, double density, std::mt19937_64& random) {
  std::bernoulli_distribution joined(density);
  BitGraph graph;
  for (int v = 0; v < size; ++v) {
    graph.add_vertex();
    for (int other = 0; other < v; ++other) {
      if (joined(random)) graph.join(other, v);
    }
  }
  return graph;
}

bool is_clique(const BitGraph& graph, const std::vector<int>& vertices) {
  for (const int a : vertices) {
    for (const int b : vertices) {
      if (a != b && !graph.joined(a, b)) return false;
    }
  }
  return std::is_sorted(vertices.begin(), vertices.end());
}

// Of all subsets of at most 20 vertices.
std::size_t clique_number(const BitGraph& graph) {
  std::size_t best = 0;
  for (unsigned subset = 0; subset < 1u << graph.size(); ++subset) {
    const auto size = static_cast<std::size_t>(std::popcount(subset));
    if (size <= best) continue;
    std::vector<int> vertices;
    for (int v = 0; v < graph.size(); ++v) {
      if (subset >> v & 1) vertices.push_back(v);
    }
    if (is_clique(graph, vertices)) best = size;
  }
  return best;
}

}  // namespace

TEST_CASE("the exact clique is as large as the largest of all subsets") {
  std::mt19937_64 random(1);
  for (int trial = 0; trial < 60; ++trial) {
    const int size = static_cast<int>(random() % 15);
    const BitGraph graph = random_graph(size, 0.1 + 0.2 * (trial % 5), random);
    const Clique clique = maximum_clique(graph);
    REQUIRE(is_clique(graph, clique.vertices));
    REQUIRE(clique.vertices.size() == clique_number(graph));
    REQUIRE(clique.exact);
    const Clique greedy = greedy_clique(graph);
    REQUIRE(is_clique(graph, greedy.vertices));
    REQUIRE(greedy.vertices.size() <= clique.vertices.size());
    REQUIRE(greedy.vertices.empty() == (size == 0));
  }
}

TEST_CASE("a planted clique is found in a graph of several words, where greedy search misses it") {
  std::mt19937_64 random(2);
  BitGraph graph = random_graph(200, 0.5, random);
  std::vector<int> planted;
  for (int v = 3; v < 200; v += 11) planted.push_back(v);
  for (const int a : planted) {
    for (const int b : planted) {
      if (a < b) graph.join(a, b);
    }
  }
  const Clique clique = maximum_clique(graph);
  CHECK(clique.exact);
  CHECK(is_clique(graph, clique.vertices));
  CHECK(clique.vertices.size() >= planted.size());
  CHECK(clique.branches > 0);
  CHECK(maximum_clique(graph).vertices == clique.vertices);
  CHECK(!greedy_clique(graph).exact);
}

TEST_CASE("an exact search that its time limit ends says so, and returns what it has") {
  std::mt19937_64 random(3);
  const BitGraph graph = random_graph(300, 0.9, random);
  double now = 0.0;
  const auto clock = [&now] { return now += 1.0; };  // 1 s at each look
  const Clique clique = maximum_clique(graph, {.clock = clock, .time_limit_s = 3.0});
  CHECK(!clique.exact);
  CHECK(is_clique(graph, clique.vertices));
  CHECK(clique.vertices.size() >= greedy_clique(graph).vertices.size());
  CHECK(now < 10.0);
}
