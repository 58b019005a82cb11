// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "core/geometry/trajectory.h"
#include "core/pgo/experiment.h"
#include "core/pgo/g2o.h"
#include "core/pgo/robot_csv.h"
#include "tests/child_process.h"
#include "tests/core/pgo/scratch.h"
#include "tests/core/pgo/worlds.h"

using namespace covey;
using namespace covey::pgo;

namespace {

struct Run {
  int code;
  std::string output;
};

Run run_pgo(const std::vector<std::string>& arguments) {
  const ScratchFile log;
  ChildProcess child("pgo", arguments, log.path);
  const auto code = child.wait(60.0);
  REQUIRE(code);
  return {*code, child.output()};
}

nlohmann::json report_of(std::vector<std::string> arguments) {
  const ScratchFile json;
  arguments.insert(arguments.end(), {"--json", json.path.string()});
  const Run run = run_pgo(arguments);
  INFO(run.output);
  REQUIRE(run.code == 0);
  return nlohmann::json::parse(std::ifstream(json.path));
}

}  // namespace

TEST_CASE("pgo reports what it solved and writes the poses") {
  const Walk walk = make_walk({.poses = 120});
  const ScratchFile graph;
  const ScratchFile tum;
  write_g2o(graph.path, walk.graph);
  const auto report =
      report_of({"--graph", graph.path, "--solver", "l2", "--tum", tum.path, "--optimum", "1"});
  CHECK(report["solver"] == "l2");
  CHECK(report["poses"] == 120);
  CHECK(report["edges"] == walk.graph.edges.size());
  CHECK(report["robots"] == 1);
  CHECK(report["gap"] == Approx(report["cost"].get<double>() - 1.0));
  CHECK(report["seconds"].get<double>() >= 0.0);
  CHECK(!report.contains("ate_m"));
  const Trajectory poses = read_tum(tum.path);
  REQUIRE(poses.size() == 120);
  CHECK(poses.front().utime == 1'000'000);
  // The poses it wrote are a reference like any other, and so are the vertices of a graph.
  CHECK(report_of({"--graph", graph.path, "--solver", "l2", "--reference", tum.path})["ate_m"].get<double>() <
        1e-6);
  const ScratchFile truth(ScratchFile::Extension{".g2o"});
  write_g2o(truth.path, walk.graph, walk.truth);
  const double ate = report_of({"--graph", graph.path, "--solver", "l2", "--reference", truth.path})["ate_m"];
  CHECK(ate > 1e-4);
  CHECK(ate < 0.5);
}

TEST_CASE("pgo tells outliers from loops on a graph cut for a team, the same way every time") {
  const Walk walk =
      make_walk({.dimension = 2, .poses = 300, .rotation_sigma = 0.002, .translation_sigma = 0.01});
  const ScratchFile graph;
  write_g2o(graph.path, walk.graph);
  const std::vector<std::string> arguments = {"--graph",    graph.path, "--robots",      "3",
                                              "--outliers", "0.5",      "--seed",        "7",
                                              "--solver",   "gnc",      "--probability", "0.999999"};
  const auto report = report_of(arguments);
  CHECK(report["robots"] == 3);
  CHECK(report["precision"] == 1.0);
  CHECK(report["recall"] == 1.0);
  CHECK(report["ate_m"].get<double>() < 1e-3);
  CHECK(report["kept_loops"] == walk.graph.loops() + 2);
  CHECK_FALSE(report.contains("decisions"));
  CHECK(report_of(arguments)["cost"] == report["cost"]);
}

TEST_CASE("pgo says of each loop whether it was kept, where that is asked for") {
  const Walk walk = make_walk({.dimension = 2, .poses = 300});
  const ScratchFile graph;
  write_g2o(graph.path, walk.graph);
  const auto report = report_of(
      {"--graph", graph.path, "--robots", "3", "--outliers", "0.5", "--solver", "gnc", "--decisions"});
  const std::string decisions = report["decisions"];
  REQUIRE(static_cast<int>(decisions.size()) == report["loops"]);
  REQUIRE(std::count(decisions.begin(), decisions.end(), '1') == report["kept_loops"]);
  REQUIRE(std::count(decisions.begin(), decisions.end(), '0') > 0);
}

TEST_CASE("pgo runs a team of solvers in one process") {
  const Walk walk = make_walk({.poses = 150, .rotation_sigma = 0.01, .grid = 4});
  const ScratchFile graph;
  write_g2o(graph.path, walk.graph);
  const double optimum = report_of({"--graph", graph.path, "--solver", "l2"})["cost"];
  const auto rbcd = report_of({"--graph", graph.path, "--robots", "3", "--solver", "rbcd", "--optimum",
                               std::to_string(optimum), "--gap", "1e-4"});
  CHECK(rbcd["gap"].get<double>() <= 1e-4);
  CHECK(rbcd["block_updates"].get<int>() > 0);
  CHECK(rbcd["bytes_sent"].get<int>() > 0);
  std::vector<std::string> arguments = {"--graph",    graph.path, "--robots", "3",
                                        "--outliers", "0.3",      "--solver", "gnc"};
  const auto gnc = report_of(arguments);
  arguments.back() = "dgnc";
  const auto dgnc = report_of(arguments);
  CHECK(dgnc["cost"].get<double>() < 1.05 * gnc["cost"].get<double>());
  CHECK(dgnc["precision"] == 1.0);
  CHECK(!dgnc.contains("converged"));
}

TEST_CASE("pgo certifies what it ends with, centrally or as the team that solved it") {
  const Walk walk = make_walk({.poses = 150, .rotation_sigma = 0.01, .grid = 4});
  const ScratchFile graph;
  write_g2o(graph.path, walk.graph);
  const auto l2 = report_of({"--graph", graph.path, "--solver", "l2", "--certify"});
  CHECK(l2["certified_gap"].get<double>() <= 1e-7);
  CHECK(l2["certified_lower_bound"].get<double>() <= l2["cost"].get<double>());
  CHECK(!l2.contains("certificate_bytes"));
  const auto rbcd = report_of({"--graph", graph.path, "--robots", "3", "--solver", "rbcd", "--certify"});
  CHECK(rbcd["certified_gap"].get<double>() <= 1e-3);
  CHECK(rbcd["certified_lower_bound"].get<double>() <= l2["cost"].get<double>());
  CHECK(rbcd["certificate_bytes"].get<int>() > 0);
  // What GNC left out is left out here: the outliers would make the bound worthless.
  for (const char* solver : {"gnc", "dgnc"}) {
    const auto robust = report_of(
        {"--graph", graph.path, "--robots", "3", "--outliers", "0.3", "--solver", solver, "--certify"});
    CHECK(robust["certified_gap"].get<double>() <= 1e-2);
  }
}

TEST_CASE("pgo takes lists of true loops, and what PCM keeps counts as kept") {
  const Walk walk =
      make_walk({.dimension = 2, .poses = 300, .rotation_sigma = 0.002, .translation_sigma = 0.01});
  const Injection injection = inject_outliers(walk.graph, 0.4, 3);
  const ScratchFile graph(ScratchFile::Extension{".g2o"});
  write_g2o(graph.path, injection.graph);
  std::string list;
  for (std::size_t e = 0; e < injection.graph.edges.size(); ++e) {
    const Edge& edge = injection.graph.edges[e];
    if (edge.kind == EdgeKind::kLoop && injection.is_true[e])
      list += std::to_string(edge.from.index) + " " + std::to_string(edge.to.index) + "\n";
  }
  const ScratchFile true_loops(list);
  for (const std::string solver : {"pcm", "gnc", "pcm+gnc", "pcm+dgnc"}) {
    INFO(solver);
    const auto report = report_of({"--graph", graph.path, "--true-loops", true_loops.path, "--robots", "2",
                                   "--solver", solver, "--probability", "0.999999"});
    CHECK(report["precision"].get<double>() > 0.98);
    CHECK(report["recall"].get<double>() > 0.98);
    CHECK(report["kept_loops"].get<int>() >= report["kept_shared_loops"].get<int>());
    CHECK(report["shared_loops"].get<int>() > 0);
    CHECK(report.contains("ate_m"));
  }
}

TEST_CASE("pgo begins where it is told to") {
  const Walk walk = make_walk({.poses = 150, .rotation_sigma = 0.005});
  const ScratchFile graph;
  write_g2o(graph.path, walk.graph);
  for (const std::string solver : {"l2", "gnc"}) {
    std::vector<std::string> arguments = {"--graph", graph.path, "--solver", solver};
    const double usual = report_of(arguments)["cost"];
    arguments.insert(arguments.end(), {"--start", ""});
    for (const std::string start : {"chordal", "robust", "odometry"}) {
      arguments.back() = start;
      CHECK(report_of(arguments)["cost"].get<double>() == Approx(usual));
    }
  }
}

TEST_CASE("pgo reads a folder of robots, and one robot of it") {
  const PoseGraph team = cut_into_robots(make_walk({.poses = 90}).graph, 3);
  const ScratchFile folder;
  write_robot_csv(folder.path, team);
  const auto report = report_of({"--graph", folder.path, "--solver", "gnc", "--barc2", "50"});
  CHECK(report["robots"] == 3);
  CHECK(report["poses"] == 90);
  CHECK(report["barc2"] == 50.0);
  const auto one = report_of({"--graph", folder.path / "robot1.csv", "--solver", "l2"});
  CHECK(one["poses"] == 30);
  CHECK(one["robots"] == 1);
}

TEST_CASE("pgo says that every loop was rejected") {
  PoseGraph graph{3, {3}, {}};
  const SE3 step{SO3{}, {1, 0, 0}};
  graph.edges = {{{0, 0}, {0, 1}, step, 1, 1, EdgeKind::kOdometry, true},
                 {{0, 1}, {0, 2}, step, 1, 1, EdgeKind::kOdometry, true},
                 {{0, 2}, {0, 0}, {SO3{}, {30, 0, 0}}, 1, 1, EdgeKind::kLoop, false}};
  const ScratchFile file;
  write_g2o(file.path, graph);
  const Run run = run_pgo({"--graph", file.path, "--solver", "gnc", "--barc2", "0.5"});
  CHECK(run.code == 0);
  CHECK_THAT(run.output, Catch::Contains("every one of 1 loops was rejected"));
}

TEST_CASE("pgo refuses bad usage and bad input with exit code 2 and a sentence, a missed gap with 1") {
  const ScratchFile file(ScratchFile::Extension{".g2o"});
  write_g2o(file.path, make_walk({.poses = 60, .grid = 2}).graph);
  const std::string graph = file.path.string();
  const auto refused = [](const std::vector<std::string>& arguments, const std::string& sentence) {
    const Run run = run_pgo(arguments);
    CHECK(run.code == 2);
    CHECK_THAT(run.output, Catch::Contains(sentence));
  };
  refused({"--graph", "/none.g2o", "--solver", "l2"}, "pgo: /none.g2o: cannot be read");
  refused({"--graph", graph, "--solver", "magic"},
          "pgo: --solver: 'magic' is not a solver; there are l2, pcm, gnc");
  refused({"--graph", graph}, "--solver is required");
  refused({"--solver", "l2"}, "exactly one of --graph and --world");
  refused({"--graph", graph, "--world", "stata", "--solver", "l2"}, "exactly one of --graph and --world");
  refused({"--world", "moon", "--solver", "l2"}, "--world: there is no 'moon', only stata");
  refused({"--world", "stata", "--robots", "2", "--solver", "l2"}, "brings its own robots and outliers");
  refused({"--graph", graph, "--true-loops", "/none.txt", "--solver", "l2"}, "/none.txt: cannot be read");
  refused({"--graph", graph, "--solver", "l2", "--gap", "0.1"}, "--gap requires --optimum");
  refused({"--graph", graph, "--solver", "gnc", "--barc2", "-3"}, "-3 is not a positive number");
  refused({"--graph", graph, "--solver", "gnc", "--barc2", "3", "--probability", "0.5"}, "excludes");
  refused({"--graph", graph, "--solver", "rbcd", "--start", "robust"}, "rbcd has a start of its own");
  refused({"--graph", graph, "--solver", "l2", "--start", "here"}, "--start");
  refused({"--graph", graph, "--solver", "l2", "--robots", "61"}, "60 poses cannot be cut for --robots 61");
  refused({"--graph", graph, "--solver", "l2", "--reference", graph}, "has no VERTEX line");
  const ScratchFile bad("EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\nEDGE_SE2 0 1 1 0 nan 1 0 0 1 0 1\n");
  refused({"--graph", bad.path, "--solver", "l2"},
          bad.path.string() + ":2: field 6 is 'nan', not a finite number");
  const ScratchFile apart("EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\nEDGE_SE2 2 3 1 0 0 1 0 0 1 0 1\n");
  refused({"--graph", apart.path, "--solver", "l2"}, "pose 2 of robot 0 is not connected to the first pose");

  const Run missed = run_pgo({"--graph", graph, "--solver", "l2", "--optimum", "1e-9", "--gap", "0.1"});
  CHECK(missed.code == 1);
  CHECK_THAT(missed.output, Catch::Contains("is not within 0.1 of --optimum"));
  CHECK(run_pgo({"--help"}).code == 0);
}
