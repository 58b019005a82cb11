// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/robot_csv.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <string>

#include "scratch.h"
#include "tests/data.h"

using namespace covey;
using namespace covey::pgo;

namespace {

const std::string kHeader =
    "robot_src,pose_src,robot_dst,pose_dst,qx,qy,qz,qw,tx,ty,tz,kappa,tau,is_known_inlier,weight\n";

std::string csv_refusal(const std::string& text) {
  const ScratchFile file(text);
  const std::string message = input_error_of([&] { read_robot_csv(file.path); });
  REQUIRE(message.starts_with(file.path.string()));
  return message.substr(file.path.string().size());
}

}  // namespace

TEST_CASE("a robot's file gives odometry, loops and the poses of others") {
  const ScratchFile file(kHeader +
                         "1,0,1,1,0,0,0,1,1,2,3,10000,100,1,1\n"
                         "1,1,1,2,0,0,0,1,1,2,3,10000,100,0,0.5\n"  // doubted by its robot: a loop
                         "1,1,4,6,0,0,1,0,1,2,3,1,2,0,0\r\n");
  const PoseGraph graph = read_robot_csv(file.path);
  CHECK(graph.dimension == 3);
  CHECK(graph.poses_per_robot == std::vector<int>{0, 3, 0, 0, 7});
  REQUIRE(graph.edges.size() == 3);
  CHECK(graph.edges[0].kind == EdgeKind::kOdometry);
  CHECK(graph.edges[0].known_inlier);
  CHECK(graph.edges[1].kind == EdgeKind::kLoop);
  CHECK(graph.edges[2].to == PoseId{4, 6});
  CHECK(graph.edges[2].measurement.translation == Eigen::Vector3d(1, 2, 3));
  CHECK(graph.edges[2].kappa == 1.0);
  CHECK(graph.edges[2].tau == 2.0);

  const Restriction own = keep_robots_with_odometry(graph);
  CHECK(own.dropped_edges == 1);
  CHECK(own.graph.poses_per_robot == std::vector<int>{0, 3, 0, 0, 0});
}

TEST_CASE("a loop that stands in two robots' files counts once, one that a file repeats was made twice") {
  const ScratchFile folder;
  std::filesystem::create_directories(folder.path);
  const std::string loop = "0,1,1,0,0,0,0,1,5,0,0,1,2,0,";
  const std::string again = "1,1,0,0,0,0,0,1,5,0,0,1,2,0,1\n";
  std::ofstream(folder.path / "robot0.csv") << kHeader << "0,0,0,1,0,0,0,1,1,0,0,1,2,1,1\n"
                                            << loop << "0.3\n"
                                            << again;
  std::ofstream(folder.path / "robot1.csv") << kHeader << "1,0,1,1,0,0,0,1,1,0,0,1,2,1,1\n"
                                            << loop << "0.7\n"
                                            << again << again;
  std::ofstream(folder.path / "notes.txt") << "not a graph";
  const PoseGraph graph = read_robot_csv(folder.path);
  CHECK(graph.poses_per_robot == std::vector<int>{2, 2});
  CHECK(graph.edges.size() == 5);
  CHECK(graph.loops() == 3);
}

TEST_CASE("what a robot's file may not say is refused with file, line and reason") {
  CHECK(csv_refusal("") == ": is empty");
  CHECK(csv_refusal(kHeader) == ": has no edges");
  CHECK(csv_refusal("robot_src,pose\n") == ":1: column 2 of the header is not 'pose_src'");
  CHECK(csv_refusal(kHeader + "\n0,0,0,1,0,0,0,1,1,0,0,1,2,1\n") == ":3: has 14 fields, not 15");
  CHECK(csv_refusal(kHeader + "0,0,0,1,0,0,0,1,nan,0,0,1,2,1,1\n") ==
        ":2: field 9 is 'nan', not a finite number");
  CHECK(csv_refusal(kHeader + "0,0,0,1,0,0,0,1,,0,0,1,2,1,1\n") == ":2: field 9 is '', not a number");
  CHECK(csv_refusal(kHeader + "0,0,0,1,0,0,0,0,1,0,0,1,2,1,1\n") == ":2: the quaternion has norm 0, not 1");
  CHECK(csv_refusal(kHeader + "0,0,0,1,0,0,0,1,1,0,0,0,2,1,1\n") ==
        ":2: kappa and tau are 0 and 2, not positive");
  CHECK(csv_refusal(kHeader + "0,1,0,1,0,0,0,1,1,0,0,1,2,1,1\n") ==
        ":2: the edge joins pose 1 of robot 0 to itself");
  CHECK(csv_refusal(kHeader + "0,0,0,1,0,0,0,1,1,0,0,1,2,yes,1\n") ==
        ":2: field 14 is 'yes', not a truth value (a whole number from 0 to 1)");
  CHECK(csv_refusal(kHeader + "0,0,0,99999999,0,0,0,1,1,0,0,1,2,1,1\n") ==
        ":2: field 4 is '99999999', not a pose (a whole number from 0 to 9999999)");
  CHECK(csv_refusal(kHeader + "0,0,0,1,0,0,0,1,1,0,0,1,2,1,1\n0,1,3,9999999,0,0,0,1,1,0,0,1,2,0,1\n") ==
        ":3: pose 9999999 of robot 3 makes 10000002 poses in all, too many for 2 edges");
  std::string everyone = kHeader;  // as offsets, these would be past 2^31
  for (int robot = 1; robot < 1000; ++robot)
    everyone += fmt::format("0,0,{},9999999,0,0,0,1,1,0,0,1,2,0,1\n", robot);
  CHECK(csv_refusal(everyone) ==
        ":2: pose 9999999 of robot 1 makes 9990000001 poses in all, too many for 999 edges");
  const ScratchFile folder;
  std::filesystem::create_directories(folder.path);
  CHECK(input_error_of([&] { read_robot_csv(folder.path); }) ==
        folder.said(": the folder has no robot<i>.csv"));
}

TEST_CASE("writing and reading a team's files returns the same graph") {
  PoseGraph graph{3, {2, 0, 3}, {}};
  const SE3 T{SO3::exp({0.1, -0.2, 3.0}), {1.0 / 3.0, -2e-9, 1e5}};
  graph.edges = {{{0, 0}, {0, 1}, T, 1.0 / 3.0, 7.0, EdgeKind::kOdometry, true},
                 {{2, 0}, {2, 1}, T, 3.0, 7.0, EdgeKind::kOdometry, true},
                 {{2, 2}, {0, 0}, T, 3.0, 7.0, EdgeKind::kLoop, false}};
  const ScratchFile folder;
  write_robot_csv(folder.path, graph);
  const PoseGraph back = read_robot_csv(folder.path);
  CHECK(back.poses_per_robot == graph.poses_per_robot);
  REQUIRE(back.edges.size() == 3);
  CHECK(back.edges[0].kappa == 1.0 / 3.0);
  for (const Edge& edge : back.edges) {
    CHECK(edge.measurement.translation == T.translation);
    CHECK((edge.measurement.rotation.inverse() * T.rotation).log().norm() < 1e-15);
  }
}

TEST_CASE("the tunnels graph has the loops that are published") {
  const auto folder = test_data("pose_graphs/tunnels");
  if (!folder) return;
  const PoseGraph graph = read_robot_csv(*folder);
  CHECK(graph.robots() == 8);
  CHECK(graph.poses() == 1255);
  CHECK(graph.edges.size() - graph.loops() == 1247);
  const auto between =
      std::count_if(graph.edges.begin(), graph.edges.end(), [](const Edge& e) { return e.between_robots(); });
  CHECK(between == 3548);
  CHECK(graph.loops() - between == 96);
  CHECK(keep_robots_with_odometry(graph).dropped_edges == 0);
}
