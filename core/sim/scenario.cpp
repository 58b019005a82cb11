// SPDX-License-Identifier: BSD-3-Clause
#include "core/sim/scenario.h"

#include <algorithm>

#include "core/base/error.h"
#include "core/sim/random.h"
#include "core/sim/routes.h"

namespace covey::sim {
namespace {

constexpr Utime kDriveBegin = 1'600'000'000 * kUsPerSecond;

enum class Purpose : std::uint64_t { kRoutes = 1, kSpeed, kSuspension, kImu };

std::uint64_t seed_for(std::uint64_t seed, Purpose purpose, int robot = 0) {
  return mix_seeds(mix_seeds(seed, static_cast<std::uint64_t>(purpose)), static_cast<std::uint64_t>(robot));
}

// Rooms are narrow: slow, and round corners within the lane.
DriveOptions drive_in(const ScenarioOptions& options, int robot) {
  Random random(seed_for(options.seed, Purpose::kSpeed, robot));
  if (options.world == "town") return {.speed = random.uniform(1.4, 1.5)};
  return {.speed = random.uniform(0.7, 0.8), .acceleration = 0.5, .corner_m = 0.8};
}

Scenario make_drives(const ScenarioOptions& options) {
  Scenario scenario;
  scenario.world =
      options.world == "town" ? make_town({.seed = options.seed}) : make_rooms({.seed = options.seed});
  scenario.robots = options.robots;

  std::vector<DriveOptions> drives;
  RouteOptions routes{.lengths_m = {}, .seed = seed_for(options.seed, Purpose::kRoutes)};
  for (int r = 0; r < options.robots; ++r) {
    drives.push_back(drive_in(options, r));
    routes.lengths_m.push_back(driven_length(drives.back(), options.seconds));
  }
  scenario.ride = [options, drives, paths = choose_routes(scenario.world.roads, routes)](int robot) {
    Ride ride;
    ride.motion = drive(paths[robot], drives[robot], kDriveBegin, options.seconds,
                        seed_for(options.seed, Purpose::kSuspension, robot));
    ride.imu = simulate_imu(ride.motion, {.noise = options.imu},
                            seed_for(options.imu_seed.value_or(options.seed), Purpose::kImu, robot));
    return ride;
  };
  return scenario;
}

// EuRoC's own stamp, of the first sample of V1_01's ground truth, for all.
constexpr Utime kFlightBegin = 1'403'715'273'262'143;

std::vector<std::string> sequences(const std::string& world) {
  if (world == "euroc-v1") return {"V1_01_easy", "V1_02_medium", "V1_03_difficult"};
  return {"MH_01_easy", "MH_03_medium", "MH_04_difficult", "MH_05_difficult"};
}

Utime nearest_before(const std::vector<ImuSample>& samples, Utime utime) {
  const auto after = std::upper_bound(samples.begin(), samples.end(), utime,
                                      [](Utime t, const ImuSample& sample) { return t < sample.utime; });
  return after == samples.begin() ? after->utime : (after - 1)->utime;
}

// The whole sequence is smoothed, not only what is flown: a stretch of 15 s does not tell tilt from the accelerometer's bias (0.45 deg
// where 80 s say 0.17), and the truth does not hang on how long one flies.
Ride fly(const std::filesystem::path& folder, const ScenarioOptions& options) {
  constexpr Utime kStandingUs = 2'000'000;
  const std::string name = folder.filename().string();
  const EurocSequence sequence = read_euroc_sequence(folder);
  const Utime first = std::max(sequence.imu.front().utime, sequence.truth.front().utime);
  const Utime last = std::min(sequence.imu.back().utime, sequence.truth.back().utime);
  const EurocMotion whole = smooth_euroc(sequence, first, last, euroc_options(name, options.imu));
  const Utime from =
      nearest_before(whole.imu.samples, std::max(first, take_off(sequence.truth) - kStandingUs));
  const Utime wanted = from + from_seconds(options.seconds);
  const Utime end = options.motion.empty() ? wanted : std::min(wanted, whole.motion.end);
  if (end > whole.motion.end) {
    throw_input_error("--seconds {}: {} flies {:.1f} s; ask for less", options.seconds, name,
                      to_seconds(whole.motion.end - from));
  }
  const EurocMotion flown = cut(whole, from, nearest_before(whole.imu.samples, end), kFlightBegin);
  return {.name = name, .motion = flown.motion, .imu = flown.imu, .evidence = flown.evidence};
}

void check_folder(const std::filesystem::path& folder) {
  if (!std::filesystem::is_directory(folder))
    throw_input_error("{}: no such folder; EuRoC's IMU and ground truth are needed there", folder.string());
}

// What the robots of the world fly, each a folder.
std::vector<std::filesystem::path> flights(const ScenarioOptions& options) {
  std::vector<std::filesystem::path> folders{options.motion};
  if (options.motion.empty()) {
    folders.clear();
    for (const std::string& name : sequences(options.world))
      folders.push_back(options.data / "euroc/motion" / name);
  }
  const auto robots = static_cast<std::size_t>(options.robots);
  if (robots > folders.size())
    throw_input_error("--robots {}: {} has {} sequences to fly", options.robots, options.world,
                      folders.size());
  if (options.motion.empty() && options.data.empty()) {
    throw_input_error(
        "--world {} flies recorded motion: give --data DIR or set COVEY_DATA to the folder that has "
        "euroc/motion/{}",
        options.world, folders.front().filename().string());
  }
  for (std::size_t r = 0; r < robots; ++r) check_folder(folders[r]);
  return folders;
}

// Of every flight that is there, so that the hall does not depend on how many fly.
std::vector<Eigen::Vector3d> flown_places(const std::vector<std::filesystem::path>& folders) {
  std::vector<Eigen::Vector3d> places;
  for (const std::filesystem::path& folder : folders) {
    if (!std::filesystem::is_directory(folder)) continue;
    for (const StampedPose& pose : read_euroc_truth(folder / "groundtruth.csv.gz"))
      places.push_back(pose.pose.translation);
  }
  return places;
}

bool fits_room(const std::vector<Eigen::Vector3d>& places) {
  constexpr double kMargin = 0.25;  // of the half metre of air around the volume
  const Eigen::AlignedBox3d volume = room_flight_volume();
  return std::all_of(places.begin(), places.end(),
                     [&](const Eigen::Vector3d& place) { return volume.exteriorDistance(place) < kMargin; });
}

Scenario make_euroc_scenario(const ScenarioOptions& options) {
  const std::vector<std::filesystem::path> folders = flights(options);
  Scenario scenario;
  if (options.world == "euroc-v1") {
    if (!options.motion.empty() && !fits_room(flown_places(folders)))
      throw_input_error("{}: does not fit the room of euroc-v1; take --world euroc-mh",
                        options.motion.string());
    RoomOptions room;
    room.seed = options.seed;
    scenario.world = make_room(room);
  } else {
    HallOptions hall;
    hall.seed = options.seed;
    hall.flown_W = flown_places(folders);
    scenario.world = make_hall(hall);
  }
  scenario.robots = options.robots;
  scenario.ride = [options, folders](int robot) {
    return fly(folders[static_cast<std::size_t>(robot)], options);
  };
  return scenario;
}

}  // namespace

std::string world_for(const std::filesystem::path& motion) {
  check_folder(motion);
  return fits_room(flown_places({motion})) ? "euroc-v1" : "euroc-mh";
}

Scenario make_scenario(const ScenarioOptions& options) {
  if (options.world.starts_with("euroc")) return make_euroc_scenario(options);
  COVEY_CHECK(options.world == "town" || options.world == "rooms");
  return make_drives(options);
}

}  // namespace covey::sim
