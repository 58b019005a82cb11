// SPDX-License-Identifier: BSD-3-Clause
#include "procs/player/rgbd_folder.h"

#include <catch2/catch.hpp>

#include "procs/player/given_odometry.h"
#include "tests/data.h"
#include "tests/procs/player/rgbd_stage.h"

using namespace covey;

TEST_CASE("frames with poses are read, and what is in their pictures") {
  const RgbdStage stage;
  stage.write_frames(3);
  std::ofstream(stage.path / "frame-000005.pose.txt") << "INF INF";
  const RgbdFolder folder = read_rgbd(stage.path);
  CHECK(folder.without_pose == 1);
  REQUIRE(folder.frames.size() == 2);
  CHECK(folder.frames[0].utime == 1'000'000);
  CHECK(folder.frames[1].utime == 1'333'333);
  CHECK(folder.frames[1].T_D_C.translation.x() == Approx(0.02));
  const depth_t image = load_depth(folder.frames[1], folder.depth_per_m);
  CHECK(image.utime == 1'333'333);
  CHECK(image.width == 64);
  CHECK(image.height == 48);
  CHECK(image.depth_mm == std::vector<std::int16_t>(64 * 48, 2000));
  CHECK(image.labels == std::vector<std::uint8_t>(64 * 48, 3));
  REQUIRE(image.colours.size() == 3 * 64 * 48);
  CHECK(image.colours[0] == 12);
  CHECK(image.colours[1] == 8);
  CHECK(image.colours[2] == 7);
}

TEST_CASE("TUM's lists are put together by stamps") {
  const RgbdStage stage;
  stage.write_tum(3);
  RgbdFolder folder = read_rgbd(stage.path);
  REQUIRE(folder.frames.size() == 3);
  CHECK(folder.without_pose == 0);
  CHECK(folder.frames[1].utime == 100'300'000);
  CHECK(folder.frames[1].T_D_C.translation.x() == Approx(0.015));
  const depth_t image = load_depth(folder.frames[1], folder.depth_per_m);
  CHECK(image.depth_mm[5] == 2000);
  CHECK(image.colours[0] == 11);
  CHECK(image.n_labels == 0);

  std::ofstream(stage.path / "rgb.txt") << "100.125 rgb0.png\n";  // 25 ms from the first image
  std::ofstream(stage.path / "groundtruth.txt")
      << "100.05 0 0 0 0 0 0 1\n100.14 0.09 0 0 0 0 0 1\n100.35 0 0 0 0 0 0 1\n";
  folder = read_rgbd(stage.path);
  REQUIRE(folder.frames.size() == 1);
  CHECK(folder.without_pose == 2);  // one in a gap of 0.21 s, one after the end
  CHECK(folder.frames[0].T_D_C.translation.x() == Approx(0.05));
  CHECK(folder.frames[0].colour.empty());
}

TEST_CASE("what is wrong with an RGB-D folder is named") {
  const auto error = [](const std::filesystem::path& path) {
    return input_error_of([&] {
      for (const RgbdFrame& frame : read_rgbd(path).frames) load_depth(frame, 1000.0);
    });
  };
  const RgbdStage stage;
  CHECK(error("/nowhere") == "--tum-rgbd /nowhere: not a folder");
  std::filesystem::create_directories(stage.path);
  CHECK_THAT(error(stage.path), Catch::Contains("no depth image with a pose"));
  stage.write_frames(1);
  CHECK(error(stage.path).empty());
  const std::string depth = (stage.path / "frame-000000.depth.png").string();
  cv::imwrite(depth, cv::Mat(48, 64, CV_8UC1, cv::Scalar(1)));
  CHECK(error(stage.path) == depth + ": not the kind of picture that is expected here");
  std::ofstream(depth) << "nothing";
  CHECK(error(stage.path) == depth + ": cannot be read as a picture");
  cv::imwrite(depth, cv::Mat(24, 64, CV_16UC1, cv::Scalar(1)));
  CHECK_THAT(error(stage.path), Catch::EndsWith("its size differs from that of the depth image"));
  stage.write_tum(2);
  std::ofstream(stage.path / "depth.txt") << "1.0 a.png\n1.0 b.png\n";
  CHECK(error(stage.path) == (stage.path / "depth.txt").string() + ":2: stamps must increase");
  std::ofstream(stage.path / "depth.txt") << "one a.png\n";
  CHECK(error(stage.path) ==
        (stage.path / "depth.txt").string() + ":1: 'one a.png' is not a stamp and a file's name");
}

TEST_CASE("depth without a value is none") {
  const RgbdStage stage;
  stage.write_frames(1);
  cv::Mat depth = RgbdStage::depth(1000.0);
  depth.at<std::uint16_t>(0, 0) = 0;
  depth.at<std::uint16_t>(0, 1) = 65'535;
  depth.at<std::uint16_t>(0, 2) = 40'000;
  cv::imwrite((stage.path / "frame-000000.depth.png").string(), depth);
  const depth_t image = load_depth(read_rgbd(stage.path).frames[0], 1000.0);
  for (std::size_t i = 0; i < 3; ++i) CHECK(image.depth_mm[i] == 0);
  CHECK(image.depth_mm[3] == 2000);
}

TEST_CASE("given poses are said as odometry would say them") {
  GivenOdometry odometry(2);
  std::vector<keyframe_t> keyframes;
  for (int i = 0; i <= 20; ++i) {  // 2 m in 2 s along x
    const SE3 pose{{}, {0.1 * i, 0.0, 0.0}};
    const GivenOdometry::Said said = odometry.add(5'000'000 + 100'000 * i, pose);
    CHECK(said.state.segment == 5'000'000);
    CHECK(said.state.robot == 2);
    CHECK(said.state.t_O_B[0] == Approx(0.1 * i));
    CHECK(said.state.v_O[0] == Approx(i == 0 ? 0.0 : 1.0));
    if (said.keyframe) keyframes.push_back(*said.keyframe);
  }
  REQUIRE(keyframes.size() >= 4);
  for (std::size_t i = 0; i < keyframes.size(); ++i) {
    CHECK(keyframes[i].id == static_cast<int>(i));
    CHECK(keyframes[i].t_P_K[0] == Approx(i == 0 ? 0.0 : keyframes[i].t_O_K[0] - keyframes[i - 1].t_O_K[0]));
    CHECK((keyframes[i].covariance[35] > 0.0) == (i > 0));
  }
  CHECK(keyframes[1].t_O_K[0] == Approx(0.5).margin(0.101));
  // At rest, every second.
  int at_rest = 0;
  for (int i = 1; i <= 50; ++i)
    at_rest += odometry.add(7'000'000 + 100'000 * i, {{}, {2.0, 0, 0}}).keyframe ? 1 : 0;
  CHECK(at_rest == 5);
}

TEST_CASE("the RGB-D recordings at hand are read") {
  const auto scenes = test_data("rgbd/seven_scenes");
  if (!scenes) return;
  const RgbdFolder folder = read_rgbd(*scenes);
  REQUIRE(folder.frames.size() == 200);
  CHECK(folder.without_pose == 0);
  const depth_t image = load_depth(folder.frames[10], folder.depth_per_m);
  CHECK(image.n_depth == 640 * 480);
  CHECK(image.n_colours == 3 * 640 * 480);
  CHECK(image.n_labels == 0);
  const auto labelled = test_data("rgbd/label_fusion");
  if (!labelled) return;
  CHECK(load_depth(read_rgbd(*labelled).frames[0], 1000.0).n_labels == 640 * 480);
}
