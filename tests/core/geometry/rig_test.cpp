// SPDX-License-Identifier: BSD-3-Clause
#include "core/geometry/rig.h"

#include <unistd.h>

#include <catch2/catch.hpp>
#include <fstream>

#include "core/base/error.h"

namespace covey {
namespace {

using Catch::Matchers::Contains;

// A rig file that lives as long as the test.
struct RigFile {
  explicit RigFile(const std::string& text)
      : path(std::filesystem::temp_directory_path() / ("covey_rig_" + std::to_string(getpid()) + ".yaml")) {
    std::ofstream(path) << text;
  }
  ~RigFile() { std::filesystem::remove(path); }
  std::filesystem::path path;
};

const std::string kPose = "T_B_C: [1, 0, 0, 0.1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]";

TEST_CASE("The rigs that are shipped can be read and have what the processes need") {
  for (const char* name : {"euroc.yaml", "rover.yaml"}) {
    const Rig rig = read_rig(std::filesystem::path(COVEY_SOURCE_DIR) / "configs/sensors" / name);
    CHECK(rig.left.camera.width == 752);
    CHECK(rig.left.camera.is_distorted());
    REQUIRE(rig.right);
    const SE3 T_L_R = rig.left.T_B_C.inverse() * rig.right->T_B_C;
    CHECK(T_L_R.translation.x() > 0.1);
    REQUIRE(rig.depth);
    CHECK(rig.depth->camera.width == 376);
  }
}

TEST_CASE("A rig of one camera is a rig") {
  const RigFile file("left: {width: 640, height: 480, intrinsics: [500, 500, 320, 240], " + kPose + "}\n");
  const Rig rig = read_rig(file.path);
  CHECK_FALSE(rig.right);
  CHECK_FALSE(rig.depth);
  CHECK(rig.left.T_B_C.translation.x() == Approx(0.1));
}

TEST_CASE("What is wrong in a rig is named") {
  const auto refuses = [](const std::string& text, const std::string& word) {
    const RigFile file(text);
    CHECK_THROWS_WITH(read_rig(file.path), Contains(word));
  };
  refuses("imu: {rate_hz: 200}\n", "left");
  refuses("left: {width: 640, height: 480, intrinsics: [500, 500, 320], " + kPose + "}\n", "intrinsics");
  refuses(
      "left: {width: 640, height: 480, intrinsics: [500, 500, 320, 240], "
      "T_B_C: [2, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]}\n",
      "rigid");
  refuses("left: {width: 640, height: 480, intrinsics: [500, 500, 320, 240], " + kPose + ", colour: red}\n",
          "colour");
}

}  // namespace
}  // namespace covey
