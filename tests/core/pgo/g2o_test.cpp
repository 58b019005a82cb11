// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/g2o.h"

#include <catch2/catch.hpp>
#include <random>
#include <string>

#include "scratch.h"
#include "tests/data.h"

using namespace covey;
using namespace covey::pgo;

namespace {

const std::string kInformation3d = " 2 0 0 0 0 0 2 0 0 0 0 2 0 0 0 8 0 0 8 0 8";
const std::string kEdge3d = "EDGE_SE3:QUAT 0 1 1 2 3 0 0 0 1" + kInformation3d + "\n";

std::string g2o_refusal(const std::string& text) {
  const ScratchFile file(text);
  const std::string message = input_error_of([&] { read_g2o(file.path); });
  REQUIRE(message.starts_with(file.path.string()));
  return message.substr(file.path.string().size());
}

}  // namespace

TEST_CASE("a planar graph is read with its precisions, its odometry and its start") {
  const ScratchFile file(
      "# two vertices of 7, 9, 12\n"
      "VERTEX_SE2 7 0 0 0\nVERTEX_SE2 9 1 0 1.5707963267948966\r\n\nVERTEX_SE2 12 1 1 3.1\nFIX 7\nROBOT "
      "x\nROBOT y\n"
      "EDGE_SE2 7 9 1 0 1.5707963267948966 4 0 0 4 0 9\n"
      "EDGE_SE2 9 12 1 0 0 1 0 0 3 0 5\n"
      "EDGE_SE2 7 12 1 1 -0.5 4 0 0 4 0 9\n");
  const G2oFile g2o = read_g2o(file.path);
  CHECK(g2o.graph.dimension == 2);
  CHECK(g2o.graph.poses_per_robot == std::vector<int>{3});
  CHECK(g2o.ids == std::vector<long>{7, 9, 12});
  CHECK(g2o.unknown_tags == std::map<std::string, int>{{"ROBOT", 2}});
  REQUIRE(g2o.graph.edges.size() == 3);
  CHECK(g2o.graph.edges[0].kappa == 9.0);
  CHECK(g2o.graph.edges[0].tau == Approx(4.0));
  CHECK(g2o.graph.edges[1].tau == Approx(2.0 / (1.0 + 1.0 / 3.0)));
  CHECK(g2o.graph.edges[1].known_inlier);
  CHECK(g2o.graph.edges[1].kind == EdgeKind::kOdometry);
  CHECK(g2o.graph.edges[2].kind == EdgeKind::kLoop);
  CHECK(!g2o.graph.edges[2].known_inlier);
  CHECK((g2o.graph.edges[0].measurement * Eigen::Vector3d(1, 0, 0) - Eigen::Vector3d(1, 1, 0)).norm() <
        1e-15);
  REQUIRE(g2o.start);
  CHECK((*g2o.start)[2].translation == Eigen::Vector3d(1, 1, 0));
}

TEST_CASE("a spatial graph is read with its precisions, doubled edges stay") {
  const ScratchFile file(kEdge3d + kEdge3d + "EDGE_SE3:QUAT 1 0 1 2 3 0 0 0 1" + kInformation3d);
  const G2oFile g2o = read_g2o(file.path);
  CHECK(g2o.graph.dimension == 3);
  REQUIRE(g2o.graph.edges.size() == 3);
  CHECK(g2o.graph.edges[0].tau == Approx(2.0));
  CHECK(g2o.graph.edges[0].kappa == Approx(4.0));
  CHECK(g2o.graph.edges[1].kind == EdgeKind::kOdometry);
  CHECK(g2o.graph.edges[2].kind == EdgeKind::kLoop);
  CHECK(!g2o.start);
}

TEST_CASE("what a g2o file may not say is refused with file, line and reason") {
  CHECK(g2o_refusal("") == ": has no edge of a tag that is known (EDGE_SE2, EDGE_SE3:QUAT)");
  CHECK(g2o_refusal("\nEDGE_SE2 0 1 1 0 0 1 0 0 1 0\n") == ":2: EDGE_SE2 has 11 fields, not 12");
  CHECK(g2o_refusal("EDGE_SE2 0 1 1 0 x 1 0 0 1 0 1") == ":1: field 6 is 'x', not a number");
  CHECK(g2o_refusal("EDGE_SE2 0 1 1 0 1.5z 1 0 0 1 0 1") == ":1: field 6 is '1.5z', not a number");
  CHECK(g2o_refusal("EDGE_SE2 0 1 nan 0 0 1 0 0 1 0 1") == ":1: field 4 is 'nan', not a finite number");
  CHECK(g2o_refusal("EDGE_SE2 0 1 1 -inf 0 1 0 0 1 0 1") == ":1: field 5 is '-inf', not a finite number");
  CHECK(g2o_refusal("EDGE_SE2 0 1 1 1e999 0 1 0 0 1 0 1") == ":1: field 5 is '1e999', not a finite number");
  CHECK(g2o_refusal("EDGE_SE2 0 1 1 0 0 1 0 0 1 0 0") ==
        ":1: the information matrix is not positive definite");
  CHECK(g2o_refusal("EDGE_SE2 0 1 1 0 0 1 2 0 1 0 1") ==
        ":1: the information matrix is not positive definite");
  CHECK(g2o_refusal("EDGE_SE2 0 -1 1 0 0 1 0 0 1 0 1") ==
        ":1: field 3 is '-1', not a vertex id (a whole number from 0 to 9223372036854775807)");
  CHECK(g2o_refusal("EDGE_SE2 4 4 1 0 0 1 0 0 1 0 1") == ":1: the edge joins vertex 4 to itself");
  CHECK(g2o_refusal("VERTEX_SE2 0 0 0 0\nVERTEX_SE2 0 1 0 0") == ":2: vertex 0 is declared twice");
  CHECK(g2o_refusal("EDGE_SE2 0 5 1 0 0 1 0 0 1 0 1\nVERTEX_SE2 0 0 0 0") ==
        ":1: the edge names vertex 5, which the file does not declare");
  CHECK(g2o_refusal("VERTEX_SE2 0 0 0 0\n" + kEdge3d) == ":2: EDGE_SE3:QUAT in a graph that is 2D so far");
  CHECK(g2o_refusal("EDGE_SE3:QUAT 0 1 1 2 3 0 0 0 2" + kInformation3d) ==
        ":1: the quaternion has norm 2, not 1");
  CHECK(input_error_of([] { read_g2o("/nonexistent.g2o"); }) == "/nonexistent.g2o: cannot be read");
  CHECK(input_error_of([] { read_g2o("/"); }) == "/: cannot be read");
}

TEST_CASE("a g2o file that was damaged anywhere is read or refused in words") {
  std::mt19937_64 random(1);
  const std::string whole =
      "VERTEX_SE3:QUAT 0 0 0 0 0 0 0 1\nVERTEX_SE3:QUAT 1 0 0 0 0 0 0 1\nFIX 0\n" + kEdge3d + kEdge3d;
  const std::string letters = " \t\r\n,#-+.e019naifEDGX\0\xff";
  int refused = 0;
  for (int trial = 0; trial < 3000; ++trial) {
    std::string text = whole;
    for (int change = 0; change < 3; ++change) {
      const std::size_t at = random() % text.size();
      switch (random() % 3) {
        case 0:
          text[at] = letters[random() % letters.size()];
          break;
        case 1:
          text.erase(at, random() % 20);
          break;
        default:
          text.insert(at, 1, letters[random() % letters.size()]);
      }
    }
    const ScratchFile file(text);
    const std::string message = input_error_of([&] { read_g2o(file.path); });
    if (!message.empty()) {
      ++refused;
      REQUIRE(message.starts_with(file.path.string()));
    }
  }
  CHECK(refused > 500);
}

TEST_CASE("writing and reading a g2o file returns the same graph") {
  std::mt19937_64 random(2);
  std::uniform_real_distribution<double> uniform(-2.0, 2.0);
  for (const int dimension : {2, 3}) {
    PoseGraph graph{dimension, {2, 2}, {}};
    Poses poses(4);
    const auto random_pose = [&] {
      SE3 T{SO3::exp({uniform(random), uniform(random), uniform(random)}),
            {uniform(random), uniform(random), uniform(random)}};
      if (dimension == 2) T = {SO3::exp({0, 0, uniform(random)}), {uniform(random), uniform(random), 0}};
      return T;
    };
    for (SE3& T : poses) T = random_pose();
    graph.edges = {{{0, 0}, {0, 1}, random_pose(), 3.0, 7.0, EdgeKind::kOdometry, true},
                   {{1, 1}, {0, 0}, random_pose(), 0.1, 1e6, EdgeKind::kLoop, false}};
    const ScratchFile file;
    write_g2o(file.path, graph, poses);
    // A vertex needs no edge to be read.
    const G2oFile back = read_g2o(file.path);
    CHECK(back.graph.dimension == dimension);
    CHECK(back.graph.poses_per_robot == std::vector<int>{4});
    REQUIRE(back.graph.edges.size() == 2);
    CHECK(back.graph.edges[1].from == PoseId{0, 3});
    CHECK(back.graph.edges[1].kappa == Approx(0.1).epsilon(1e-12));
    CHECK(back.graph.edges[1].tau == Approx(1e6).epsilon(1e-12));
    CHECK((back.graph.edges[1].measurement.inverse() * graph.edges[1].measurement).log().norm() < 1e-14);
    REQUIRE(back.start);
    CHECK(((*back.start)[3].inverse() * poses[3]).log().norm() < 1e-14);
  }
}

TEST_CASE("the benchmark graphs have the sizes that are published") {
  struct Expected {
    const char* name;
    int dimension;
    int poses;
    int edges;
  };
  const auto folder = test_data("pose_graphs");
  if (!folder) return;
  for (const Expected& expected : std::initializer_list<Expected>{{"intel", 2, 1228, 1483},
                                                                  {"csail", 2, 1045, 1171},
                                                                  {"kitti_00", 2, 4541, 4676},
                                                                  {"sphere2500", 3, 2500, 4949},
                                                                  {"cubicle", 3, 5750, 16869},
                                                                  {"tinyGrid3D", 3, 9, 11}}) {
    const PoseGraph graph = read_g2o(*folder / (std::string(expected.name) + ".g2o")).graph;
    CAPTURE(expected.name);
    CHECK(graph.dimension == expected.dimension);
    CHECK(graph.poses() == expected.poses);
    CHECK(static_cast<int>(graph.edges.size()) == expected.edges);
    const std::vector<int> parts = connected_parts(graph);
    CHECK(*std::max_element(parts.begin(), parts.end()) == 0);
  }
}
