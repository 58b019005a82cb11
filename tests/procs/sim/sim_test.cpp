// SPDX-License-Identifier: BSD-3-Clause
// sim as a process: what it writes can be read, is the same each time, and is not left half done.
#include <signal.h>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <sstream>
#include <thread>

#include "core/geometry/trajectory.h"
#include "core/imu/propagate.h"
#include "core/sim/euroc_files.h"
#include "procs/common/bus.h"
#include "procs/common/log_file.h"
#include "procs/player/asl_folder.h"
#include "tests/child_process.h"
#include "tests/core/pgo/scratch.h"
#include "tests/data.h"
#include "viewer_offscreen/ply.h"

using namespace covey;
using Catch::Matchers::Contains;
using Catch::Matchers::EndsWith;
using Catch::Matchers::StartsWith;

namespace {

constexpr Utime kBegin = 1'600'000'000'000'000;
using Arguments = std::vector<std::string>;

struct Ended {
  int code = -1;
  std::string said;
};

Ended run_sim(const Arguments& arguments) {
  const ScratchFile said;
  ChildProcess sim("sim", arguments, said.path);
  const std::optional<int> code = sim.wait(100.0);
  return {code.value_or(-999), sim.output()};
}

// A second or two of one robot in a town.
Arguments town(const Arguments& more) {
  Arguments arguments = {"--world", "town", "--robots", "2", "--robot", "1", "--seed", "3", "--seconds", "2"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

struct Heard {
  std::vector<imu_t> imu;
  std::vector<stereo_t> stereo;
  std::vector<depth_t> depth;
};

Heard hear(const std::filesystem::path& log) {
  EventLoop loop;
  Status counts;
  Heard heard;
  Bus bus({.url = "file://" + log.string(), .faults = {}, .recorder = nullptr}, loop, counts);
  bus.subscribe(kImu, [&heard](const imu_t& message) { heard.imu.push_back(message); });
  bus.subscribe(kStereo, [&heard](const stereo_t& message) { heard.stereo.push_back(message); }, {});
  bus.subscribe(kDepth, [&heard](const depth_t& message) { heard.depth.push_back(message); }, {});
  loop.run();
  CHECK(counts.counter("dropped/STEREO/impossible") == 0);
  return heard;
}

TEST_CASE("a log has all of a robot's sensors in order of time, and the same bytes each time") {
  const ScratchFile first;
  const ScratchFile second;
  REQUIRE(run_sim(town({"--log", first.path})).code == 0);
  REQUIRE(run_sim(town({"--log", second.path})).code == 0);
  CHECK(read_text(first.path) == read_text(second.path));
  CHECK_FALSE(std::filesystem::exists(first.path.string() + ".part"));

  Utime last = 0;
  LogReader log(first.path, [](const std::string&, const Bytes&) {});
  for (; const auto time = log.next_time(); log.deliver()) {
    CHECK(*time >= last);
    last = *time;
  }
  const Heard heard = hear(first.path);
  REQUIRE(heard.imu.size() == 401);
  REQUIRE(heard.stereo.size() == 41);
  REQUIRE(heard.depth.size() == 11);
  CHECK(heard.imu.front().utime == kBegin);
  CHECK(heard.imu.back().utime == kBegin + 2'000'000);
  for (std::size_t k = 0; k < heard.stereo.size(); ++k) {
    const stereo_t& stereo = heard.stereo[k];
    CHECK(stereo.utime == kBegin + 50'000 * static_cast<Utime>(k));
    CHECK((stereo.width == 752 && stereo.height == 480));
    CHECK(stereo.left.size() == 752 * 480);
    CHECK(stereo.right.size() == 752 * 480);
    CHECK(stereo.left != stereo.right);
  }
  for (const depth_t& depth : heard.depth) {
    CHECK((depth.utime - kBegin) % 200'000 == 0);
    CHECK(depth.labels.size() == depth.depth_mm.size());
    CHECK(depth.colours.size() == 3 * depth.depth_mm.size());
  }
}

TEST_CASE("the same drive can have another IMU, and needs no pictures then") {
  const ScratchFile own;
  const ScratchFile same;
  const ScratchFile other;
  REQUIRE(run_sim(town({"--imu-only", "--log", own.path})).code == 0);
  REQUIRE(run_sim(town({"--imu-only", "--imu-seed", "3", "--log", same.path})).code == 0);
  REQUIRE(run_sim(town({"--imu-only", "--imu-seed", "2", "--log", other.path})).code == 0);
  CHECK((read_text(own.path) == read_text(same.path)));
  const Heard a = hear(own.path);
  const Heard b = hear(other.path);
  CHECK(a.stereo.empty());
  CHECK(a.depth.empty());
  REQUIRE(a.imu.size() == 401);
  REQUIRE(b.imu.size() == a.imu.size());
  // Another bias and other noise, on the same motion.
  double bias = 0.0;
  for (std::size_t k = 0; k < a.imu.size(); ++k)
    bias += (b.imu[k].gyro[0] - a.imu[k].gyro[0]) / static_cast<double>(a.imu.size());
  CHECK(std::abs(bias) > 1e-3);
  for (std::size_t k = 0; k < a.imu.size(); ++k)
    CHECK(std::abs(b.imu[k].gyro[0] - a.imu[k].gyro[0] - bias) < 0.03);
}

TEST_CASE("a folder in EuRoC's layout has what the log has, and the truth with velocities and biases") {
  const ScratchFile log;
  const ScratchFile folder;
  const ScratchFile truth;
  REQUIRE(run_sim(town({"--log", log.path, "--truth", truth.path})).code == 0);
  REQUIRE(run_sim(town({"--asl", folder.path})).code == 0);
  const Heard heard = hear(log.path);
  const AslFolder asl = read_asl(folder.path);
  REQUIRE(asl.imu.size() == heard.imu.size());
  for (std::size_t k = 0; k < asl.imu.size(); ++k) {
    CHECK(asl.imu[k].utime == heard.imu[k].utime);
    CHECK(std::equal(asl.imu[k].gyro, asl.imu[k].gyro + 3, heard.imu[k].gyro));
    CHECK(std::equal(asl.imu[k].accel, asl.imu[k].accel + 3, heard.imu[k].accel));
  }
  REQUIRE(asl.pictures.size() == heard.stereo.size());
  for (const std::size_t k : {std::size_t{0}, std::size_t{40}}) {
    const stereo_t stereo = load_stereo(asl.pictures[k]);
    CHECK(stereo.utime == heard.stereo[k].utime);
    CHECK(stereo.left == heard.stereo[k].left);
    CHECK(stereo.right == heard.stereo[k].right);
  }
  const std::filesystem::path mav = folder.path / "mav0";
  for (const char* sensor : {"cam0", "cam1", "imu0", "state_groundtruth_estimate0"})
    CHECK_THAT(read_text(mav / sensor / "sensor.yaml"), StartsWith("%YAML:1.0\n"));
  CHECK(read_text(mav / "state_groundtruth_estimate0/data.csv") == read_text(truth.path / "robot1.csv"));

  // 17 columns; from one state the samples, without the biases that stand beside it, lead to the next.
  std::istringstream rows(read_text(truth.path / "robot1.csv"));
  std::string row;
  std::getline(rows, row);
  CHECK(std::count(row.begin(), row.end(), ',') == 16);
  std::vector<NavState> states;
  while (std::getline(rows, row)) {
    REQUIRE(std::count(row.begin(), row.end(), ',') == 16);
    std::replace(row.begin(), row.end(), ',', ' ');
    std::istringstream numbers(row);
    std::int64_t stamp = 0;
    std::array<double, 16> x{};
    numbers >> stamp;
    for (double& number : x) numbers >> number;
    CHECK(stamp == 1000 * heard.imu[states.size()].utime);
    states.push_back({{SO3::from_quaternion({x[3], x[4], x[5], x[6]}), {x[0], x[1], x[2]}},
                      {x[7], x[8], x[9]},
                      {{x[10], x[11], x[12]}, {x[13], x[14], x[15]}}});
  }
  REQUIRE(states.size() == heard.imu.size());
  std::vector<ImuSample> samples;
  for (std::size_t k = 300; k < 401; ++k) {
    const imu_t& imu = heard.imu[k];
    samples.push_back({imu.utime, Eigen::Vector3d(imu.gyro), Eigen::Vector3d(imu.accel)});
  }
  const NavState end = propagate(states[300], {}, samples);
  CHECK((end.T_W_B.translation - states[400].T_W_B.translation).norm() < 5e-3);
  CHECK((end.v_W - states[400].v_W).norm() < 0.02);
}

TEST_CASE("The truth has world, labels, contacts and every robot's way") {
  const ScratchFile folder;
  REQUIRE(run_sim({"--world", "town", "--robots", "2", "--seconds", "10", "--truth", folder.path}).code == 0);
  const viewer::Mesh world = viewer::read_ply(folder.path / "world.ply");
  CHECK(world.faces.size() > 1000);
  CHECK(world.labels.size() == world.vertices.size());
  CHECK(world.colours.size() == world.vertices.size());
  const auto labels = nlohmann::json::parse(read_text(folder.path / "labels.json"));
  for (const std::uint16_t label : world.labels) CHECK(labels.contains(std::to_string(label)));
  CHECK_THAT(read_text(folder.path / "contacts.yaml"), Contains("{a: 0, b: 1, from_s: "));
  const auto summary = nlohmann::json::parse(read_text(folder.path / "sim.json"));
  for (int r = 0; r < 2; ++r) {
    const Trajectory trajectory = read_tum(folder.path / ("robot" + std::to_string(r) + ".tum"));
    REQUIRE(trajectory.size() == 2001);
    CHECK(trajectory.front().utime == kBegin);
    CHECK(summary["rides"][r]["length_m"].get<double>() > 8.0);
  }
}

TEST_CASE("an interrupted run leaves nothing half done") {
  for (const char* output : {"--log", "--asl"}) {
    const ScratchFile target;
    const ScratchFile said;
    ChildProcess sim("sim", {"--world", "town", "--robot", "0", "--seconds", "300", output, target.path},
                     said.path);
    const std::filesystem::path part = output == std::string("--log")
                                           ? std::filesystem::path(target.path.string() + ".part")
                                           : target.path / "mav0.part/cam0/data";
    for (int k = 0; k < 3000 && !std::filesystem::exists(part); ++k)
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    REQUIRE(std::filesystem::exists(part));
    sim.kill(SIGINT);
    CHECK(sim.wait(30.0) == 1);
    CHECK_THAT(sim.output(), EndsWith("sim: interrupted; nothing was written\n"));
    CHECK_FALSE(std::filesystem::exists(part));
    CHECK_FALSE(std::filesystem::is_regular_file(target.path));
    CHECK_FALSE(std::filesystem::exists(target.path / "mav0"));
  }
}

TEST_CASE("what sim cannot do it refuses with one sentence and exit code 2") {
  const auto refused = [](const Arguments& arguments, const std::string& why) {
    const Ended ended = run_sim(arguments);
    CHECK(ended.code == 2);
    CHECK_THAT(ended.said, StartsWith("sim: ") && Contains(why) && EndsWith("\n"));
    CHECK(std::count(ended.said.begin(), ended.said.end(), '\n') == 1);
  };
  const ScratchFile target;
  refused({}, "say what to make");
  refused({"--log", target.path}, "--robot is needed");
  refused({"--robot", "3", "--log", target.path}, "only robots 0 to 2");
  refused({"--robot", "0", "--log", target.path, "--asl", target.path}, "one of --log, --asl and --url");
  refused({"--robot", "0", "--log", "/no/such/folder/x.lcm"}, "/no/such/folder/x.lcm");
  refused({"--world", "grid", "--truth", target.path}, "--graph DIR");
  refused({"--world", "town", "--graph", target.path}, "for --world grid");
  refused({"--world", "euroc-v1", "--robots", "4", "--truth", target.path}, "3 sequences");
  refused({"--world", "euroc-v1", "--data", "/nowhere", "--truth", target.path},
          "/nowhere/euroc/motion/V1_01_easy");
  refused({"--motion", "/nowhere", "--truth", target.path}, "/nowhere: no such folder");
  refused({"--motion", "/nowhere", "--world", "town", "--truth", target.path}, "--motion is for");
  std::filesystem::create_directories(target.path / "mav0");
  refused({"--robot", "0", "--seconds", "2", "--asl", target.path}, "exists already");
}

TEST_CASE("euroc-v1 flies the real IMU's samples, all robots from one begin") {
  const auto data = test_data("euroc/motion/V1_02_medium");
  if (!data) return;
  const std::string folder = data->parent_path().parent_path().parent_path();
  const ScratchFile log;
  const Ended ended =
      run_sim({"--world", "euroc-v1", "--robot", "1", "--seconds", "2", "--data", folder, "--log", log.path});
  REQUIRE(ended.code == 0);
  const Heard heard = hear(log.path);
  REQUIRE(heard.imu.size() >= 400);
  CHECK(heard.imu.front().utime == 1'403'715'273'262'143);
  CHECK(heard.stereo.size() >= 40);
  const auto recorded = sim::read_euroc_imu(*data / "imu0.csv.gz");
  const Eigen::Vector3d gyro(heard.imu.front().gyro);
  CHECK(std::any_of(recorded.begin(), recorded.end(),
                    [&](const ImuSample& sample) { return sample.gyro == gyro; }));
}

TEST_CASE("a recorded flight is flown alone, in the world that it fits, and no longer than it was") {
  for (const auto& [sequence, world] :
       {std::pair{"V1_02_medium", "euroc-v1"}, std::pair{"MH_04_difficult", "euroc-mh"}}) {
    const auto data = test_data(std::string("euroc/motion/") + sequence);
    if (!data) return;
    const ScratchFile truth;
    REQUIRE(run_sim({"--motion", data->string() + "/", "--seconds", "1000", "--truth", truth.path}).code ==
            0);
    const auto summary = nlohmann::json::parse(read_text(truth.path / "sim.json"));
    CHECK(summary["world"] == world);
    REQUIRE(summary["rides"].size() == 1);
    CHECK(summary["rides"][0]["sequence"] == sequence);
    CHECK(summary["rides"][0]["length_m"].get<double>() > 50.0);
  }
}

TEST_CASE("a recorded flight's sensors go without depth where nobody wants it") {
  const auto data = test_data("euroc/motion/V1_02_medium");
  if (!data) return;
  const ScratchFile log;
  REQUIRE(run_sim({"--motion", *data, "--seconds", "2", "--no-depth", "--log", log.path}).code == 0);
  const Heard heard = hear(log.path);
  CHECK(heard.imu.size() >= 400);
  CHECK(heard.stereo.size() >= 40);
  CHECK(heard.depth.empty());
}

}  // namespace
