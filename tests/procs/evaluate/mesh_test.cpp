// SPDX-License-Identifier: BSD-3-Clause
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "core/geometry/trajectory.h"
#include "tests/child_process.h"
#include "tests/core/eval/planes.h"
#include "tests/core/pgo/scratch.h"
#include "viewer_offscreen/ply.h"

namespace covey {
namespace {

using Json = nlohmann::json;

// A floor and a wall as truth has them, and as somebody has them whose frame is another: p_W = T_W_O p_O.
struct Stage : ScratchFile {
  Stage() {
    std::filesystem::create_directories(path);
    const viewer::Mesh truth = testing::joined(
        testing::make_plane(4.0, 3.0, 0.1, [](double u, double v) { return Eigen::Vector3d(u, v, 0.0); }),
        testing::make_plane(
            4.0, 2.0, 0.1, [](double u, double v) { return Eigen::Vector3d(u, 0.0, v); },
            [](double, double) { return 2; }));
    viewer::write_ply(file("truth.ply"), truth);
    viewer::Mesh estimate = truth;
    for (Eigen::Vector3f& p : estimate.vertices) p = (T_W_O.inverse() * p.cast<double>()).cast<float>();
    viewer::write_ply(file("estimate.ply"), estimate);
    Trajectory way;
    Trajectory believed;
    for (int k = 0; k < 20; ++k) {
      const SE3 T_W_B{SO3::exp({0.0, 0.0, 0.05 * k}), {1.0 + 0.1 * k, 1.0, 1.0 + 0.02 * k * k}};
      way.push_back({from_seconds(1.0 + k), T_W_B});
      believed.push_back({from_seconds(1.0 + k), T_W_O.inverse() * T_W_B});
    }
    write_tum(file("truth.tum"), way);
    write_tum(file("estimate.tum"), believed);
  }
  std::string file(const std::string& name) const { return (path / name).string(); }
  std::pair<int, std::string> run(std::vector<std::string> arguments) const {
    std::vector<std::string> all = {"mesh", "--estimate", file("estimate.ply"), "--reference",
                                    file("truth.ply")};
    all.insert(all.end(), arguments.begin(), arguments.end());
    ChildProcess evaluate("evaluate", all, file("out.txt"));
    const int code = evaluate.wait(60.0).value_or(-1);
    return {code, evaluate.output()};
  }
  Json score(const std::vector<std::string>& arguments) const {
    const auto [code, text] = run(arguments);
    INFO(text);
    REQUIRE(code == 0);
    return Json::parse(text);
  }

  SE3 T_W_O{SO3::exp({0.1, -0.2, 1.5}), {3.0, -2.0, 0.5}};
};

TEST_CASE("evaluate mesh: placed by its trajectory, by its first pose or by a file, the mesh is right") {
  const Stage stage;
  REQUIRE(stage.score({})["error_m"] > 0.2);
  const std::vector<std::string> ways = {"--trajectory", stage.file("estimate.tum"), "--truth",
                                         stage.file("truth.tum")};
  for (const std::string align : {"all", "first"}) {
    std::vector<std::string> arguments = ways;
    arguments.insert(arguments.end(), {"--align", align});
    const Json score = stage.score(arguments);
    REQUIRE(score["error_m"] < 1e-4);
    REQUIRE(score["completeness_m"] < 1e-4);
    REQUIRE(score["labels"] > 0.99);
    REQUIRE(score["T_reference_estimate"][4] == Approx(3.0).margin(1e-4));
  }
  const auto q = stage.T_W_O.rotation.canonical_quaternion();
  const Json alignment = {{"T_reference_estimate", {q.w(), q.x(), q.y(), q.z(), 3.0, -2.0, 0.5}}};
  std::ofstream(stage.file("alignment.json")) << alignment.dump();
  std::ofstream(stage.file("alignment.txt"))
      << fmt::format("{} {} {} {} 3 -2 0.5\n", q.w(), q.x(), q.y(), q.z());
  for (const std::string name : {"alignment.json", "alignment.txt"}) {
    const Json score = stage.score(
        {"--alignment", stage.file(name), "--placed", stage.file("placed.ply"), "--samples", "2000"});
    REQUIRE(score["error_m"] < 1e-4);
    REQUIRE(score["error"]["samples"] == Approx(2000).margin(2));
    const viewer::Mesh placed = viewer::read_ply(stage.file("placed.ply"));
    REQUIRE((placed.vertices[7] - viewer::read_ply(stage.file("truth.ply")).vertices[7]).norm() < 1e-5F);
  }
}

TEST_CASE("evaluate mesh: completeness of what was seen") {
  const Stage stage;
  std::ofstream(stage.file("robot.yaml")) << "sensors: sensors.yaml\n";
  const std::string camera =
      "{width: 188, height: 120, intrinsics: [100, 100, 93.5, 59.5], T_B_C: [0, 0, 1, 0, "
      "-1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 0, 1]";
  std::ofstream(stage.file("sensors.yaml"))
      << "left: " << camera << "}\ndepth: " << camera << ", near_m: 0.1, far_m: 8}\n";
  const std::vector<std::string> seen = {"--alignment", stage.file("alignment.txt"),
                                         "--seen-from", stage.file("truth.tum"),
                                         "--config",    stage.file("robot.yaml")};
  const auto q = stage.T_W_O.rotation.canonical_quaternion();
  std::ofstream(stage.file("alignment.txt"))
      << fmt::format("{} {} {} {} 3 -2 0.5\n", q.w(), q.x(), q.y(), q.z());
  const Json score = stage.score(seen);
  REQUIRE(score["seen"] > 0.05);
  REQUIRE(score["seen"] < 0.9);
  REQUIRE(score["completeness_m"] < 1e-4);
}

TEST_CASE("evaluate mesh: what it cannot use it says, with exit code 2") {
  const Stage stage;
  const auto refusal = [&](const std::vector<std::string>& arguments) {
    const auto [code, text] = stage.run(arguments);
    REQUIRE(code == 2);
    return text;
  };
  REQUIRE(refusal({"--trajectory", stage.file("estimate.tum")}).find("--truth") != std::string::npos);
  REQUIRE(refusal({"--alignment", stage.file("none.txt")}).find("none.txt") != std::string::npos);
  std::ofstream(stage.file("bad.txt")) << "1 2 3";
  REQUIRE(refusal({"--alignment", stage.file("bad.txt")}).find("bad.txt") != std::string::npos);
  REQUIRE(refusal({"--seen-from", stage.file("truth.tum")}).find("--config") != std::string::npos);
  std::ofstream(stage.file("later.tum")) << "900 0 0 0 0 0 0 1\n";
  REQUIRE(
      refusal({"--trajectory", stage.file("later.tum"), "--truth", stage.file("truth.tum")}).find("stamps") !=
      std::string::npos);
}

}  // namespace
}  // namespace covey
