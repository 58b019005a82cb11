// SPDX-License-Identifier: BSD-3-Clause
// vio as a process, from logs.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>

#include "core/base/bands.h"
#include "core/eval/ate.h"
#include "core/geometry/trajectory.h"
#include "procs/common/bus.h"
#include "procs/common/log_file.h"
#include "procs/common/sensor_log.h"
#include "tests/child_process.h"
#include "tests/core/pgo/scratch.h"
#include "tests/data.h"

using namespace covey;
using Catch::Matchers::Contains;
using Catch::Matchers::StartsWith;

namespace {

const std::string kConfig = (std::filesystem::path(COVEY_SOURCE_DIR) / "configs/robots/euroc.yaml").string();

struct Said {
  std::vector<state_t> states;
  std::vector<keyframe_t> keyframes;
  std::map<std::string, std::int64_t> counters;  // of the last STATUS
};

Said read_said(const std::filesystem::path& file) {
  EventLoop loop;
  Status counts;
  Said said;
  Bus bus({"file://" + file.string(), {}, nullptr}, loop, counts);
  bus.subscribe(kState, [&](const state_t& message) { said.states.push_back(message); });
  bus.subscribe(kKeyframe, [&](const keyframe_t& message) { said.keyframes.push_back(message); });
  bus.subscribe(kStatus, [&](const status_t& message) {
    for (int i = 0; i < message.n_counters; ++i)
      said.counters[message.counter_names[i]] = message.counter_values[i];
  });
  loop.run();
  return said;
}

// Positions and rotations of EuRoC's ground truth: stamp in ns, p, q as w x y z.
Trajectory read_truth(const std::filesystem::path& clip) {
  std::ifstream stream(clip / "mav0/state_groundtruth_estimate0/data.csv");
  Trajectory truth;
  for (std::string line; std::getline(stream, line);) {
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream fields(line);
    std::int64_t stamp_ns = 0;
    double px = 0.0, py = 0.0, pz = 0.0, qw = 0.0, qx = 0.0, qy = 0.0, qz = 0.0;
    if (!(fields >> stamp_ns >> px >> py >> pz >> qw >> qx >> qy >> qz)) continue;
    truth.push_back({(stamp_ns + 500) / 1000, {SO3::from_quaternion({qw, qx, qy, qz}), {px, py, pz}}});
  }
  REQUIRE(truth.size() > 1000);
  return truth;
}

// Grey images and an IMU at rest, in the order in which they come, whatever their stamps.
class DisorderedLog {
 public:
  explicit DisorderedLog(const std::filesystem::path& file) : log_(file.string()) {}

  void image(Utime utime) {
    stereo_t message{};
    message.utime = utime;
    message.width = 752;
    message.height = 480;
    message.left.assign(752 * 480, 128);
    message.right = message.left;
    message.n_left = message.n_right = 752 * 480;
    for (const band_t& band : split_bands(encode(message), utime, 1, images_))
      log_.write(now_, kStereo.name, encode(band));
    ++images_;
  }
  // At 200 Hz, an image with every tenth sample where wanted.
  void rest(Utime begin, Utime length, bool with_images) {
    for (Utime utime = begin; utime < begin + length; utime += 5'000) {
      if (with_images && (utime - begin) % 50'000 == 0) image(utime);
      imu_t message{};
      message.utime = utime;
      message.accel[2] = 9.81;
      log_.write(now_, kImu.name, encode(message));
      now_ += 5'000;
    }
  }
  void finish() { log_.flush(); }

 private:
  LogRecorder log_;
  Utime now_ = kUsPerSecond;
  std::int32_t images_ = 0;
};

}  // namespace

TEST_CASE("vio goes on after an image with a false stamp, and after the sensors' clock went back") {
  const ScratchFile log;
  const ScratchFile out;
  const ScratchFile frames;
  const ScratchFile said_by;
  DisorderedLog writer(log.path);
  writer.rest(100'000'000, 200'000, true);
  writer.image(3'700'000'000);
  writer.rest(100'200'000, 200'000, true);
  writer.rest(1'000'000, 1'100'000, false);
  writer.rest(2'100'000, 200'000, true);
  writer.finish();
  ChildProcess vio("vio",
                   {"--robot", "0", "--config", kConfig, "--url", "file://" + log.path.string(), "--out",
                    out.path, "--frames", frames.path},
                   said_by.path);
  REQUIRE(vio.wait(60.0) == 0);
  const Said said = read_said(out.path);
  CHECK(said.counters.at("frames") == 12);
  CHECK(said.counters.at("dropped/STEREO/disorder") == 1);
  CHECK(said.counters.at("dropped/IMU/late") == 200);

  // Every picture set has its line in the --frames file.
  const std::string rows = read_text(frames.path);
  CHECK_THAT(rows, StartsWith("utime_us,front_end_ms,frame_ms,tracks,stereo,used,fate\n"));
  CHECK(std::count(rows.begin(), rows.end(), '\n') == 1 + 12 + 1);
  CHECK_THAT(rows, Contains("\n3700000000,0.000,0.000,0,0,0,disorder\n"));
  CHECK_THAT(rows, Contains(",initialising\n"));
}

TEST_CASE("a --frames file that cannot be written is refused with a sentence") {
  const ScratchFile log;
  const ScratchFile said_by;
  DisorderedLog writer(log.path);
  writer.rest(100'000'000, 100'000, true);
  writer.finish();
  ChildProcess vio("vio",
                   {"--robot", "0", "--config", kConfig, "--url", "file://" + log.path.string(), "--frames",
                    "/no/such/folder/frames.csv"},
                   said_by.path);
  CHECK(vio.wait(60.0) == 2);
  CHECK_THAT(vio.output(), Contains("--frames /no/such/folder/frames.csv: cannot be written"));
}

TEST_CASE("vio cuts the same keyframes and states from somebody else's odometry") {
  const ScratchFile log;
  const ScratchFile out;
  const ScratchFile tum;
  const ScratchFile said_by;
  const ScratchFile config(std::string("vio: {source: odometry}\n"));
  SensorLogWriter writer(log.path);
  for (int k = 0; k < 200; ++k) {
    odometry_t message{};
    message.utime = 1'000'000 + 20'000 * k;
    message.q_O_B[0] = 1.0;
    message.t_O_B[0] = 0.02 * k;
    if (k == 100) message.t_O_B[1] = std::nan("");
    writer.write(kOdometry, message);
  }
  REQUIRE(writer.finish());
  ChildProcess vio("vio",
                   {"--robot", "1", "--config", config.path, "--url", "file://" + log.path.string(), "--out",
                    out.path, "--tum", tum.path},
                   said_by.path);
  REQUIRE(vio.wait(60.0) == 0);
  const Said said = read_said(out.path);
  CHECK(said.states.size() == 199);
  CHECK(said.counters.at("dropped/ODOMETRY/values") == 1);
  REQUIRE(said.keyframes.size() == 8);  // 0.52 m apart
  CHECK(said.keyframes[3].robot == 1);
  CHECK(said.keyframes[3].segment == 1'000'000);
  CHECK(said.keyframes[3].t_P_K[0] == Approx(0.52));
  CHECK(read_tum(tum.path).size() == 199);
}

TEST_CASE("vio follows EuRoC's clip, which begins in motion, to three centimetres") {
  const auto clip = test_data("euroc/mh01_clip");
  if (!clip) return;
  const ScratchFile log;
  const ScratchFile out;
  const ScratchFile tum;
  const ScratchFile said_by;
  ChildProcess player("player", {"--asl", *clip, "--out", log.path}, said_by.path);
  REQUIRE(player.wait(60.0) == 0);
  ChildProcess vio("vio",
                   {"--robot", "0", "--config", kConfig, "--url", "file://" + log.path.string(), "--out",
                    out.path, "--tum", tum.path},
                   said_by.path);
  REQUIRE(vio.wait(100.0) == 0);
  INFO(vio.output());
  const Trajectory estimate = read_tum(tum.path);
  CHECK(estimate.size() >= 216);  // of 240 frames
  const TrajectoryError error = trajectory_error({estimate, read_truth(*clip)});
  CHECK(error.matched == static_cast<int>(estimate.size()));
  CHECK(error.rmse_m <= 0.03);

  const Said said = read_said(out.path);
  CHECK(said.counters.at("frames") == 240);
  CHECK(said.counters.count("frames_dropped") == 0);
  CHECK(said.states.size() > 2000);  // 200 Hz from the start of the segment
  REQUIRE(said.keyframes.size() > 10);
  for (std::size_t i = 0; i < said.keyframes.size(); ++i) {
    const keyframe_t& keyframe = said.keyframes[i];
    CHECK(keyframe.segment == said.keyframes.front().segment);
    CHECK(keyframe.id == static_cast<int>(i));
    const Eigen::Quaterniond q(keyframe.q_O_K[0], keyframe.q_O_K[1], keyframe.q_O_K[2], keyframe.q_O_K[3]);
    CHECK((q * Eigen::Vector3d(keyframe.gravity_K) - Eigen::Vector3d(0.0, 0.0, -1.0)).norm() < 0.02);
  }
  // The reference's z axis points up too.
  const Eigen::Vector3d up = error.T_reference_estimate.rotation * Eigen::Vector3d::UnitZ();
  CHECK(up.head<2>().norm() < 0.03);
}
