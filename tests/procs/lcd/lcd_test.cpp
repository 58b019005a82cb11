// SPDX-License-Identifier: BSD-3-Clause
// A real lcd process over a log: a robot that sees one wall, drives on along another, and comes back.

#include <catch2/catch.hpp>
#include <covey/stereo_t.hpp>
#include <fstream>
#include <map>

#include "core/place/lcd_messages.h"
#include "core/place/vocabulary.h"
#include "procs/common/log_file.h"
#include "procs/common/sensor_log.h"
#include "tests/child_process.h"
#include "tests/core/pgo/scratch.h"
#include "tests/core/place/wall.h"

namespace covey {
namespace {

constexpr Utime kStart = 1'000'000'000;

// Where the body is in front of which wall, second by second.
struct Stop {
  int wall;
  double along_m;
};
constexpr Stop kStops[] = {{0, 0.0}, {0, 0.3}, {1, 0.0}, {1, 0.3}, {1, 0.6}, {0, 0.1}, {0, 0.35}};
constexpr int kUnseen = 3;  // its images are lost

SE3 body_at(const Stop& stop, const Rig& rig) {
  SE3 T_W_C;  // the left camera looks at the wall
  T_W_C.translation.x() = stop.along_m;
  return T_W_C * rig.left.T_B_C.inverse();
}

void write_log(const std::filesystem::path& file, const Rig& rig) {
  const place::testing::Wall walls[] = {
      {Eigen::Vector3d::UnitZ(), 3.0, place::testing::make_texture(1200, 900, 1)},
      {Eigen::Vector3d::UnitZ(), 3.0, place::testing::make_texture(1200, 900, 2)}};
  SensorLogWriter log(file.string());
  int id = 0;
  for (const Stop& stop : kStops) {
    const Utime utime = kStart + 4 * id * kUsPerSecond;
    const SE3 T_W_B = body_at(stop, rig);
    if (id != kUnseen) {
      stereo_t stereo{};
      stereo.utime = utime;
      stereo.width = rig.left.camera.width;
      stereo.height = rig.left.camera.height;
      const auto take = [&](const MountedCamera& camera) {
        const cv::Mat picture = take_picture(walls[stop.wall], camera.camera, T_W_B * camera.T_B_C);
        return std::vector<std::uint8_t>(picture.datastart, picture.dataend);
      };
      stereo.left = take(rig.left);
      stereo.right = take(*rig.right);
      stereo.n_left = static_cast<std::int32_t>(stereo.left.size());
      stereo.n_right = static_cast<std::int32_t>(stereo.right.size());
      log.write(kStereo, stereo);
    }
    keyframe_t keyframe{};
    keyframe.utime = utime;
    keyframe.robot = 2;
    keyframe.segment = kStart;
    keyframe.id = id++;
    keyframe.q_O_K[0] = keyframe.q_P_K[0] = 1.0;
    log.write(kKeyframe, keyframe);
  }
  // In the end a robot comes into range that has nothing yet.
  const auto words =
      place::Vocabulary::load(std::filesystem::path(COVEY_SOURCE_DIR) / "configs/place/vocabulary.bin")
          .hash();
  log.write(kLcdInventory.in(), place::inventory_message(1, kStart + (4 * id - 3) * kUsPerSecond,
                                                         static_cast<std::int64_t>(words), {}));
  REQUIRE(log.finish());
}

struct Output {
  std::vector<loop_t> loops;
  std::map<std::string, std::int64_t> counters;
  std::map<std::string, int> messages;
};

// All there is to see here is a wall, which lcd refuses as a plane unless it is told not to.
std::string write_config(const ScratchFolder& folder) {
  const std::filesystem::path configs = std::filesystem::path(COVEY_SOURCE_DIR) / "configs";
  const std::filesystem::path file = folder.path / "robot.yaml";
  std::ofstream(file) << "sensors: " << (configs / "sensors/rover.yaml").string()
                      << "\nlcd:\n  vocabulary: " << (configs / "place/vocabulary.bin").string()
                      << "\n  least_thickness: 0\n";
  return file.string();
}

Output run_lcd(const ScratchFolder& folder, const std::string& name, bool with_state) {
  const std::string out = (folder.path / (name + ".lcm")).string();
  std::vector<std::string> arguments{"--robot",  "2",
                                     "--config", write_config(folder),
                                     "--url",    "file://" + (folder.path / "in.lcm").string(),
                                     "--out",    out};
  if (with_state) arguments.insert(arguments.end(), {"--state", (folder.path / "state").string()});
  ChildProcess lcd("lcd", arguments, (folder.path / (name + ".log")).string());
  const auto code = lcd.wait(60.0);
  INFO(read_text((folder.path / (name + ".log")).string()));
  REQUIRE(code == 0);
  Output output;
  LogReader reader(out, [&](const std::string& channel, const Bytes& bytes) {
    ++output.messages[channel];
    loop_t loop{};
    status_t status{};
    if (channel == kLoop.name && decode(bytes, loop)) output.loops.push_back(loop);
    if (channel != kStatus.name || !decode(bytes, status)) return;
    for (int k = 0; k < status.n_counters; ++k)
      output.counters[status.counter_names[k]] = status.counter_values[k];
  });
  while (reader.next_time()) reader.deliver();
  return output;
}

TEST_CASE(
    "a log with a way back gives closures with the past, their numbers right, and again from the disk") {
  const ScratchFolder folder;
  const Rig rig = read_rig(std::filesystem::path(COVEY_SOURCE_DIR) / "configs/sensors/rover.yaml");
  write_log(folder.path / "in.lcm", rig);
  const Output output = run_lcd(folder, "first", true);
  REQUIRE(output.messages.at("OUT_LCD_BAG") == 6);
  REQUIRE(output.counters.at("dropped/KEYFRAME/no_images") == 1);
  REQUIRE(output.counters.at("funnel/2/accepted") == static_cast<int>(output.loops.size()));
  REQUIRE(output.loops.size() >= 1);
  int number = 0;
  for (const loop_t& loop : output.loops) {
    REQUIRE(loop.number == number++);
    REQUIRE(loop.stream == output.loops[0].stream);
    REQUIRE(loop.robot_a == 2);
    REQUIRE(loop.robot_b == 2);
    REQUIRE(loop.id_a < 2);
    REQUIRE(loop.id_b >= 5);
    const SE3 T_A_B{SO3::from_quaternion({loop.q_A_B[0], loop.q_A_B[1], loop.q_A_B[2], loop.q_A_B[3]}),
                    {loop.t_A_B[0], loop.t_A_B[1], loop.t_A_B[2]}};
    const SE3 truth = body_at(kStops[loop.id_a], rig).inverse() * body_at(kStops[loop.id_b], rig);
    REQUIRE((T_A_B.inverse() * truth).log().norm() < 0.05);
  }
  // What was found is said again; the keyframes are known already, and there for who lacks them.
  const Output again = run_lcd(folder, "again", true);
  REQUIRE(again.loops.size() == output.loops.size());
  REQUIRE(again.loops[0].stream == output.loops[0].stream);
  REQUIRE(again.loops[0].t_A_B[0] == output.loops[0].t_A_B[0]);
  REQUIRE(again.messages.at("OUT_LCD_BAG") == 6);
}

}  // namespace
}  // namespace covey
