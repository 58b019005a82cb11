// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/vertex_cover.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <random>

using namespace covey;
using namespace covey::pgo;

namespace {

using Edges = std::vector<std::pair<graph::Key, graph::Key>>;

graph::Key left(int k) { return {'l', static_cast<std::uint64_t>(k)}; }
graph::Key right(int k) { return {'r', static_cast<std::uint64_t>(k)}; }

bool covers(const std::set<graph::Key>& cover, const Edges& edges) {
  return std::all_of(edges.begin(), edges.end(), [&](const auto& edge) {
    return cover.contains(edge.first) || cover.contains(edge.second);
  });
}

// By trying all subsets.
int smallest_cover(const Edges& edges, int side) {
  int smallest = 2 * side;
  for (unsigned subset = 0; subset < 1U << (2 * side); ++subset) {
    std::set<graph::Key> cover;
    for (int k = 0; k < side; ++k) {
      if (subset >> k & 1U) cover.insert(left(k));
      if (subset >> (side + k) & 1U) cover.insert(right(k));
    }
    if (static_cast<int>(cover.size()) < smallest && covers(cover, edges))
      smallest = static_cast<int>(cover.size());
  }
  return smallest;
}

}  // namespace

TEST_CASE("a vertex cover touches all edges and is a smallest one") {
  std::mt19937_64 random(1);
  for (int trial = 0; trial < 60; ++trial) {
    constexpr int kSide = 4;
    Edges edges;
    for (int k = 0; k < trial % 12; ++k) {
      edges.emplace_back(left(static_cast<int>(random() % kSide)), right(static_cast<int>(random() % kSide)));
    }
    const std::set<graph::Key> cover = vertex_cover(edges);
    CHECK(covers(cover, edges));
    CHECK(static_cast<int>(cover.size()) == smallest_cover(edges, kSide));
  }
}

TEST_CASE("a vertex cover does not depend on the order of the edges or on doubles") {
  std::mt19937_64 random(2);
  Edges edges;
  for (int k = 0; k < 300; ++k) {
    edges.emplace_back(left(static_cast<int>(random() % 100)), right(static_cast<int>(random() % 80)));
  }
  const std::set<graph::Key> cover = vertex_cover(edges);
  CHECK(covers(cover, edges));
  edges.insert(edges.end(), edges.begin(), edges.begin() + 50);
  for (int trial = 0; trial < 10; ++trial) {
    std::shuffle(edges.begin(), edges.end(), random);
    CHECK(vertex_cover(edges) == cover);
  }
  CHECK(vertex_cover({}).empty());
}
