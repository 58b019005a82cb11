// SPDX-License-Identifier: BSD-3-Clause
#include "core/mesh/simplify.h"

#include <catch2/catch.hpp>
#include <set>

#include "tests/core/mesh/corridor.h"

using namespace covey;
using namespace covey::mesh;

namespace {

SE3 no_drift(double) { return {}; }

// Every vertex at a mean of its node's, and every edge joins what faces join.
void check_nodes(const MeasuredMesh& mesh, const SimplifiedMesh& simple) {
  std::vector<Eigen::Vector3d> sums(simple.nodes.size(), Eigen::Vector3d::Zero());
  std::vector<int> counts(simple.nodes.size(), 0);
  for (std::size_t v = 0; v < mesh.p_O.size(); ++v) {
    sums[simple.node_of[v]] += mesh.p_O[v].cast<double>();
    ++counts[simple.node_of[v]];
    REQUIRE((mesh.p_O[v].cast<double>() - simple.nodes[simple.node_of[v]].g_O).norm() <=
            std::sqrt(3.0) * simple.cell_m);
  }
  for (std::size_t k = 0; k < sums.size(); ++k) {
    REQUIRE(counts[k] > 0);
    REQUIRE((sums[k] / counts[k] - simple.nodes[k].g_O).norm() < 1e-9);
  }
  std::set<std::pair<int, int>> joined;
  for (const Face& face : mesh.faces) {
    for (int i = 0; i < 3; ++i) {
      joined.insert(std::minmax({simple.node_of[face[i]], simple.node_of[face[(i + 1) % 3]]}));
    }
  }
  for (const NodeEdge& edge : simple.edges) {
    REQUIRE(edge.a < edge.b);
    REQUIRE(joined.contains({edge.a, edge.b}));
  }
}

}  // namespace

TEST_CASE("simplify: nodes are means of cells, edges join cells that share a face") {
  const testing::Corridor corridor = testing::make_corridor(no_drift);
  const SimplifiedMesh simple = simplify(corridor.mesh, corridor.keyframes, {.min_cell_m = 0.5});
  REQUIRE(simple.cell_m == 0.5);
  // The corridor's surface is 30 m x 7 m, a node for each 0.25 m^2 and somewhat more along the edges.
  REQUIRE(simple.nodes.size() > 800);
  REQUIRE(simple.nodes.size() < 1300);
  REQUIRE(simple.edges.size() > 2 * simple.nodes.size());
  check_nodes(corridor.mesh, simple);
  for (const Node& node : simple.nodes) {
    REQUIRE(node.seen_by.size() <= 4);
    REQUIRE(node.last_us - node.first_us <= from_seconds(1.0));
  }
}

TEST_CASE("simplify: cells grow until there are few enough of them") {
  const testing::Corridor corridor = testing::make_corridor(no_drift);
  const SimplifiedMesh simple = simplify(corridor.mesh, corridor.keyframes, {.max_nodes = 200});
  REQUIRE(simple.nodes.size() <= 200);
  REQUIRE(simple.nodes.size() > 60);
  REQUIRE(simple.cell_m > 0.3);
  check_nodes(corridor.mesh, simple);
}

TEST_CASE("simplify: passes and segments share no node and no edge") {
  testing::Corridor corridor = testing::make_corridor(no_drift, {.length_m = 10.0});
  testing::add_passage(corridor, no_drift, {.length_m = 10.0, .start_s = 40.0});                // again
  testing::add_passage(corridor, no_drift, {.length_m = 10.0, .start_s = 41.0, .segment = 8});  // restarted
  const std::size_t vertices = corridor.p_W.size() / 3;
  // A face across two passes, as where the surface of one ends in that of the other.
  corridor.mesh.faces.push_back({0, 1, static_cast<std::uint32_t>(vertices + 500)});
  const SimplifiedMesh simple = simplify(corridor.mesh, corridor.keyframes, {.min_cell_m = 0.5});
  std::set<int> nodes[3];
  for (std::size_t v = 0; v < corridor.p_W.size(); ++v) nodes[v / vertices].insert(simple.node_of[v]);
  REQUIRE(nodes[0].size() + nodes[1].size() + nodes[2].size() == simple.nodes.size());
  for (const NodeEdge& edge : simple.edges) {
    REQUIRE(nodes[0].contains(edge.a) == nodes[0].contains(edge.b));
    REQUIRE(nodes[1].contains(edge.a) == nodes[1].contains(edge.b));
  }
}

TEST_CASE("simplify: nothing gives nothing") {
  const SimplifiedMesh simple = simplify({}, {});
  REQUIRE(simple.nodes.empty());
  REQUIRE(simple.edges.empty());
}
