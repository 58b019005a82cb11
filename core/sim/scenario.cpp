// SPDX-License-Identifier: BSD-3-Clause
#include "core/sim/scenario.h"

#include <algorithm>
#include <array>

#include "core/base/error.h"
#include "core/sim/random.h"
#include "core/sim/routes.h"

namespace covey::sim {
namespace {

constexpr Utime kTownBegin = 1'600'000'000 * kUsPerSecond;

enum class Purpose : std::uint64_t { kRoutes = 1, kSpeed, kSuspension, kImu };

std::uint64_t seed_for(std::uint64_t seed, Purpose purpose, int robot = 0) {
  return mix_seeds(mix_seeds(seed, static_cast<std::uint64_t>(purpose)), static_cast<std::uint64_t>(robot));
}

Scenario make_town_scenario(const ScenarioOptions& options) {
  TownOptions town;
  town.seed = options.seed;
  Scenario scenario;
  scenario.world = make_town(town);
  scenario.robots = options.robots;

  std::vector<DriveOptions> drives;
  RouteOptions routes{.lengths_m = {}, .seed = seed_for(options.seed, Purpose::kRoutes)};
  for (int r = 0; r < options.robots; ++r) {
    DriveOptions drive_options;
    drive_options.speed = Random(seed_for(options.seed, Purpose::kSpeed, r)).uniform(1.4, 1.5);
    drives.push_back(drive_options);
    routes.lengths_m.push_back(driven_length(drive_options, options.seconds));
  }
  scenario.ride = [options, drives, paths = choose_routes(scenario.world.roads, routes)](int robot) {
    Ride ride;
    ride.motion = drive(paths[robot], drives[robot], kTownBegin, options.seconds,
                        seed_for(options.seed, Purpose::kSuspension, robot));
    ride.imu =
        simulate_imu(ride.motion, {.noise = options.imu}, seed_for(options.seed, Purpose::kImu, robot));
    return ride;
  };
  return scenario;
}

constexpr std::array kSequences = {"V1_01_easy", "V1_02_medium", "V1_03_difficult"};

Utime nearest_before(const std::vector<ImuSample>& samples, Utime utime) {
  const auto after = std::upper_bound(samples.begin(), samples.end(), utime,
                                      [](Utime t, const ImuSample& sample) { return t < sample.utime; });
  return after == samples.begin() ? after->utime : (after - 1)->utime;
}

// The whole sequence is smoothed, not only what is flown: a stretch of 15 s does not tell tilt from the accelerometer's bias (0.45 deg
// where 80 s say 0.17), and the truth does not hang on how long one flies.
Ride fly(const std::filesystem::path& folder, const ScenarioOptions& options, const std::string& name,
         Utime begin) {
  constexpr Utime kStandingUs = 2'000'000;
  const EurocSequence sequence = read_euroc_sequence(folder / name);
  const Utime first = std::max(sequence.imu.front().utime, sequence.truth.front().utime);
  const Utime last = std::min(sequence.imu.back().utime, sequence.truth.back().utime);
  const EurocMotion whole = smooth_euroc(sequence, first, last, euroc_options(name, options.imu));
  const Utime from =
      nearest_before(whole.imu.samples, std::max(first, take_off(sequence.truth) - kStandingUs));
  const Utime until = nearest_before(whole.imu.samples, from + from_seconds(options.seconds));
  if (from + from_seconds(options.seconds) > whole.motion.end) {
    throw_input_error("--seconds {}: {} flies {:.1f} s; ask for less", options.seconds, name,
                      to_seconds(whole.motion.end - from));
  }
  const EurocMotion flown = cut(whole, from, until, begin);
  return {.name = name, .motion = flown.motion, .imu = flown.imu, .evidence = flown.evidence};
}

Scenario make_euroc_scenario(const ScenarioOptions& options) {
  if (options.robots > static_cast<int>(kSequences.size()))
    throw_input_error("--robots {}: euroc-v1 has {} sequences to fly", options.robots, kSequences.size());
  if (options.data.empty()) {
    throw_input_error(
        "--world euroc-v1 flies recorded motion: give --data DIR or set COVEY_DATA to the folder "
        "that has euroc/motion/V1_01_easy");
  }
  const std::filesystem::path folder = options.data / "euroc/motion";
  for (int r = 0; r < options.robots; ++r) {
    if (!std::filesystem::is_directory(folder / kSequences[r]))
      throw_input_error("{}: no such folder; --data needs EuRoC's IMU and ground truth there",
                        (folder / kSequences[r]).string());
  }
  // EuRoC's own stamp, of the first sample of V1_01's ground truth, for all.
  constexpr Utime kBegin = 1'403'715'273'262'143;
  Scenario scenario;
  RoomOptions room;
  room.seed = options.seed;
  scenario.world = make_room(room);
  scenario.robots = options.robots;
  scenario.ride = [options, folder](int robot) { return fly(folder, options, kSequences[robot], kBegin); };
  return scenario;
}

}  // namespace

Scenario make_scenario(const ScenarioOptions& options) {
  if (options.world == "euroc-v1") return make_euroc_scenario(options);
  COVEY_CHECK(options.world == "town");
  return make_town_scenario(options);
}

}  // namespace covey::sim
