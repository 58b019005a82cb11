// SPDX-License-Identifier: BSD-3-Clause
#include "procs/player/asl_folder.h"

#include <catch2/catch.hpp>

#include "tests/data.h"
#include "tests/procs/player/asl_stage.h"

using namespace covey;

TEST_CASE("a folder in EuRoC's layout is read, with png and webp pictures") {
  for (const std::string extension : {".png", ".webp"}) {
    const AslStage stage(4, extension);
    for (const std::filesystem::path& folder : {stage.path, stage.path / "mav0"}) {
      const AslFolder asl = read_asl(folder);
      REQUIRE(asl.imu.size() == 40);
      CHECK(asl.imu[3].utime == 1'403'636'579'778'556);
      CHECK(asl.imu[3].gyro[0] == 3.0);
      CHECK(asl.imu[3].gyro[2] == 0.25);
      CHECK(asl.imu[3].accel[1] == 9.8);
      CHECK(asl.imu[3].accel[2] == 1e-3);
      REQUIRE(asl.pictures.size() == 4);
      CHECK(asl.unpaired_left + asl.unpaired_right == 0);
      const stereo_t stereo = load_stereo(asl.pictures[2]);
      CHECK(stereo.utime == asl.pictures[2].utime);
      CHECK(stereo.width == 40);
      CHECK(stereo.height == 30);
      CHECK(stereo.n_left == 1200);
      CHECK(stereo.left == std::vector<std::uint8_t>(1200, 12));
      CHECK(stereo.right == std::vector<std::uint8_t>(1200, 112));
    }
  }
}

TEST_CASE("left and right pictures belong together by stamp, never by row") {
  const AslStage stage(4, ".png");
  const auto name = [](int k) { return std::to_string(AslStage::kFirstNs + 50'000'000LL * k); };
  stage.write("cam0", name(0) + "," + name(0) + ".png\n" + name(1) + "," + name(1) + ".png\n" + name(3) +
                          "," + name(3) + ".png\n");
  stage.write("cam1", name(1) + "," + name(1) + ".png\n" + name(2) + "," + name(2) + ".png\n" + name(3) +
                          "," + name(3) + ".png\n");
  const AslFolder asl = read_asl(stage.path);
  REQUIRE(asl.pictures.size() == 3);
  CHECK(asl.pictures[0].right.empty());
  CHECK(asl.unpaired_left == 1);
  CHECK(asl.unpaired_right == 1);
  CHECK(load_stereo(asl.pictures[0]).n_right == 0);
  CHECK(load_stereo(asl.pictures[1]).right.front() == 111);
  CHECK(load_stereo(asl.pictures[2]).right.front() == 113);
}

TEST_CASE("a folder may have one camera, and no IMU") {
  const AslStage stage(3, ".png");
  std::filesystem::remove_all(stage.path / "mav0/cam1");
  std::filesystem::remove_all(stage.path / "mav0/imu0");
  const AslFolder asl = read_asl(stage.path);
  CHECK(asl.imu.empty());
  CHECK(asl.pictures.size() == 3);
  CHECK(load_stereo(asl.pictures[0]).n_right == 0);
}

TEST_CASE("what is wrong with a folder is named by file and line") {
  const AslStage stage(2, ".png");
  const auto error = [&] { return input_error_of([&] { read_asl(stage.path); }); };
  const std::string imu = stage.csv("imu0").string();
  const std::string cam0 = stage.csv("cam0").string();
  const std::string stamp = std::to_string(AslStage::kFirstNs);

  stage.write("imu0", "# stamps\n" + stamp + ",1,2,3,4,5,6\n" + stamp + ",1,2,3,4,5,6\n");
  CHECK(error() == imu + ":3: the stamp is not later than the one before");
  stage.write("imu0", stamp + ",1,2,3,4,5\n");
  CHECK(error() == imu + ":1: 6 columns where 7 are wanted");
  stage.write("imu0", stamp + ",1,2,three,4,5,6\n");
  CHECK(error() == imu + ":1: 'three' is not a number");
  stage.write("imu0", "1.5e9,1,2,3,4,5,6\n");
  CHECK(error() == imu + ":1: '1.5e9' is not a stamp in nanoseconds");
  std::filesystem::remove(stage.csv("imu0"));
  CHECK(error() == imu + ": cannot be opened; an ASL folder has it");
  stage.write("cam0", "#\n\n" + stamp + ",none.png\n");
  CHECK(error() == cam0 + ":3: " + (stage.path / "mav0/cam0/data/none.png").string() + " is not there");
  CHECK(input_error_of([&] { read_asl(stage.path / "elsewhere"); }) ==
        "--asl " + (stage.path / "elsewhere").string() + ": has neither mav0/cam0 nor cam0");
}

TEST_CASE("a picture that cannot be decoded is named with where it is listed") {
  const AslStage stage(2, ".png");
  const AslFolder asl = read_asl(stage.path);
  std::ofstream(asl.pictures[1].left) << "not a picture";
  CHECK(input_error_of([&] { load_stereo(asl.pictures[1]); }) ==
        stage.csv("cam0").string() + ":3: " + asl.pictures[1].left.string() + " cannot be read as a picture");
}

TEST_CASE("EuRoC's clip is read") {
  const auto folder = test_data("euroc/mh01_clip");
  if (!folder) return;
  const AslFolder asl = read_asl(*folder);
  CHECK(asl.pictures.size() == 240);
  CHECK(asl.imu.size() == 2900);
  CHECK(asl.unpaired_left + asl.unpaired_right == 0);
  CHECK(load_stereo(asl.pictures.back()).n_right == 752 * 480);
}
