// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/schur.h"

#include <catch2/catch.hpp>
#include <limits>

#include "core/pgo/central.h"
#include "core/pgo/chi_square.h"
#include "core/pgo/cost.h"
#include "core/pgo/experiment.h"
#include "core/pgo/solve_schur.h"
#include "core/pgo/start.h"
#include "core/pgo/tls.h"
#include "tests/core/pgo/worlds.h"

using namespace covey;
using namespace covey::pgo;

namespace {

PoseGraph make_team(int robots, int dimension = 3) {
  return cut_into_robots(make_walk({.dimension = dimension, .poses = 240, .rotation_sigma = 0.03}).graph,
                         robots);
}

std::vector<dpgo_reduced_t> reduce(std::vector<SchurMember>& members) {
  std::vector<dpgo_reduced_t> reduced;
  for (SchurMember& member : members) reduced.push_back(member.block.reduce());
  return reduced;
}

dpgo_move_t round(std::vector<SchurMember>& members, SchurTeam& team) {
  const dpgo_move_t step = team.solve(reduce(members));
  for (SchurMember& member : members) REQUIRE(member.block.step(step));
  return step;
}

// The robots that hold each edge.
std::vector<std::vector<int>> holders(const PoseGraph& graph, const std::vector<SchurMember>& members) {
  std::vector<std::vector<int>> holders(graph.edges.size());
  for (const SchurMember& member : members) {
    for (std::size_t id = 0; id < member.edges.size(); ++id) {
      if (member.block.holds(id)) holders[member.edges[id]].push_back(member.block.robot());
    }
  }
  return holders;
}

bool separates(const SchurBlock& block, graph::Key key) {
  return std::binary_search(block.separating().begin(), block.separating().end(), key);
}

}  // namespace

TEST_CASE(
    "each loop is held by one robot, to which its far end is a separating pose, as it is to its owner") {
  for (const int robots : {1, 2, 5}) {
    const PoseGraph graph = make_team(robots);
    const std::vector<SchurMember> members = schur_members(graph, chordal_start(graph));
    const auto of_edge = holders(graph, members);
    for (std::size_t e = 0; e < graph.edges.size(); ++e) {
      const Edge& edge = graph.edges[e];
      REQUIRE(of_edge[e].size() == 1);
      const int holder = of_edge[e].front();
      CHECK((holder == edge.from.robot || holder == edge.to.robot));
      if (!edge.between_robots()) continue;
      const PoseId far = holder == edge.from.robot ? edge.to : edge.from;
      CHECK(separates(members[holder].block, schur_key(far.robot, far.index)));
      CHECK(separates(members[far.robot].block, schur_key(far.robot, far.index)));
    }
  }
}

TEST_CASE("all robots hold the same separating poses to the last bit") {
  const PoseGraph graph = make_team(4);
  std::vector<SchurMember> members = schur_members(graph, chordal_start(graph));
  SchurTeam team;
  for (int k = 0; k < 4; ++k) round(members, team);
  int shared = 0;
  for (const SchurMember& member : members) {
    for (const graph::Key key : member.block.separating()) {
      const graph::Values& owner = members[robot_of(key)].block.poses();
      CHECK(std::equal(owner.data(key), owner.data(key) + 7, member.block.poses().data(key)));
      if (robot_of(key) != member.block.robot()) ++shared;
    }
  }
  CHECK(shared > 0);
}

TEST_CASE("weights count, and may change between two steps") {
  PoseGraph graph = make_team(3);
  const Poses start = chordal_start(graph);
  std::vector<SchurMember> members = schur_members(graph, start);
  SchurTeam team;
  round(members, team);
  const auto weight_of = [&](std::size_t e) { return graph.edges[e].known_inlier ? 1.0 : 0.25 * (e % 4); };
  for (SchurMember& member : members) {
    for (std::size_t id = 0; id < member.edges.size(); ++id) {
      if (member.block.holds(id)) member.block.set_weight(id, weight_of(member.edges[id]));
    }
  }
  for (int k = 0; k < 8; ++k) CHECK(round(members, team).taken);
  const Poses poses = gather_poses(graph, members);
  const std::vector<double> r2 = squared_residuals(graph, poses);
  for (const SchurMember& member : members) {
    for (std::size_t id = 0; id < member.edges.size(); ++id) {
      if (member.block.holds(id))
        CHECK(member.block.squared_residual(id) == Approx(r2[member.edges[id]]).margin(1e-9));
    }
  }
  double weighted = 0.0;
  for (std::size_t e = 0; e < graph.edges.size(); ++e) {
    weighted += weight_of(e) * r2[e];
    graph.edges[e].kappa *= std::max(weight_of(e), 1e-12);
    graph.edges[e].tau *= std::max(weight_of(e), 1e-12);
  }
  CHECK(team.cost() == Approx(weighted).epsilon(1e-9));
  CHECK(weighted == Approx(solve_least_squares(graph, start).cost).epsilon(1e-7));
}

TEST_CASE("a step that raises the cost is taken back by all, with its weights") {
  const PoseGraph graph = make_team(3);
  std::vector<SchurMember> members = schur_members(graph, chordal_start(graph));
  SchurTeam team;
  round(members, team);
  round(members, team);
  const Poses before = gather_poses(graph, members);
  const std::vector<dpgo_reduced_t> system = reduce(members);
  dpgo_move_t wrong = team.solve(system);
  for (float& value : wrong.values) value += 1.0F;
  for (SchurMember& member : members) {
    REQUIRE(member.block.step(wrong));
    member.block.set_weight(0, 0.5);
  }
  const dpgo_move_t back = round(members, team);
  CHECK_FALSE(back.taken);
  CHECK(back.refresh);
  const Poses after = gather_poses(graph, members);
  for (std::size_t k = 0; k < before.size(); ++k) CHECK(after[k].matrix() == before[k].matrix());
  CHECK(members[0].block.weight(0) == 1.0);
  for (int k = 0; k < 8; ++k) round(members, team);
  CHECK(team.cost() == Approx(solve_least_squares(graph, before).cost).epsilon(1e-9));
}

TEST_CASE("a message that does not hold together is seen") {
  const PoseGraph graph = make_team(2);
  std::vector<SchurMember> members = schur_members(graph, chordal_start(graph));
  const std::vector<dpgo_reduced_t> good = reduce(members);
  REQUIRE(SchurTeam::fits(good[1]));
  const auto spoilt = [&](auto&& spoil) {
    dpgo_reduced_t m = good[1];
    spoil(m);
    return !SchurTeam::fits(m);
  };
  CHECK(spoilt([](auto& m) { m.b.pop_back(); }));
  CHECK(spoilt([](auto& m) { m.root.pop_back(); }));
  CHECK(spoilt([](auto& m) { m.n = -1; }));
  CHECK(spoilt([](auto& m) { m.n = 0; }));
  CHECK(spoilt([](auto& m) { m.b[0] = std::numeric_limits<double>::quiet_NaN(); }));
  CHECK(spoilt([](auto& m) { m.root[0] = std::numeric_limits<float>::infinity(); }));
  CHECK(spoilt([](auto& m) { std::swap(m.places[0], m.places[1]); }));
  CHECK(spoilt([](auto& m) { m.robots[0] = -3; }));
  CHECK(spoilt([](auto& m) { m.cost = std::numeric_limits<double>::quiet_NaN(); }));

  SchurTeam team;
  const dpgo_move_t step = team.solve(good);
  const auto refused = [&](auto&& spoil) {
    dpgo_move_t m = step;
    spoil(m);
    return !members[1].block.step(m);
  };
  CHECK(refused([](auto& m) { m.values.pop_back(); }));
  CHECK(refused([](auto& m) { m.n_values -= 6; }));
  CHECK(refused([](auto& m) { m.values[0] = std::numeric_limits<float>::quiet_NaN(); }));
  CHECK(refused([](auto& m) { m.places.back() = 1000; }));
  CHECK(members[1].block.step(step));
}
