// SPDX-License-Identifier: BSD-3-Clause
#include "core/sim/routes.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <utility>

#include "core/sim/drive.h"

namespace covey::sim {
namespace {

RoadGraph grid(int blocks = 4, double block_m = 14.0) {
  RoadGraph roads;
  roads.clear_half_width_m = 1.7;
  const int across = blocks + 1;
  for (int j = 0; j < across; ++j) {
    for (int i = 0; i < across; ++i) {
      roads.junctions_W.emplace_back(i * block_m, j * block_m);
      if (i + 1 < across) roads.roads.push_back({j * across + i, j * across + i + 1});
      if (j + 1 < across) roads.roads.push_back({j * across + i, (j + 1) * across + i});
    }
  }
  return roads;
}

struct Sample {
  Eigen::Vector2d p;
  Eigen::Vector2d heading;
  double t = 0.0;
};

// Seconds of a that are where b was or will be, looking the same way, but not at the same time.
double shared_s(const std::vector<Sample>& a, const std::vector<Sample>& b, double apart_s) {
  int count = 0;
  for (const Sample& x : a) {
    count += std::any_of(b.begin(), b.end(), [&](const Sample& y) {
      return (x.p - y.p).norm() < 1.0 && x.heading.dot(y.heading) > 0.9 && std::abs(x.t - y.t) > apart_s;
    });
  }
  return 0.2 * count;
}

// Robots of different speeds.
DriveOptions drive_of(int robot) {
  DriveOptions options;
  options.speed = 1.4 + 0.1 * (robot % 3) / 2.0;
  return options;
}

std::vector<double> lengths_m(int robots, double seconds) {
  std::vector<double> lengths;
  for (int r = 0; r < robots; ++r) lengths.push_back(driven_length(drive_of(r), seconds));
  return lengths;
}

std::vector<Sample> driven(const std::vector<Eigen::Vector3d>& path, int robot, double seconds) {
  const Motion motion = drive(path, drive_of(robot), 0, seconds, 1);
  std::vector<Sample> samples;
  for (Utime t = 0; t <= motion.end; t += 200'000) {
    const MotionState state = motion.at(t);
    const Eigen::Vector3d ahead = state.T_W_B.rotation * Eigen::Vector3d::UnitX();
    samples.push_back({state.T_W_B.translation.head<2>(), ahead.head<2>(), to_seconds(t)});
  }
  return samples;
}

TEST_CASE("three robots meet in place and direction within 45 s, and each meets itself") {
  for (const std::uint64_t seed : {1, 2, 3, 4, 5}) {
    const auto routes = choose_routes(grid(), {.lengths_m = lengths_m(3, 45.0), .seed = seed});
    std::vector<std::vector<Sample>> rides;
    for (int r = 0; r < 3; ++r) rides.push_back(driven(routes[r], r, 45.0));
    for (int a = 0; a < 3; ++a) {
      CHECK(shared_s(rides[a], rides[a], 15.0) > 3.0);
      for (int b = a + 1; b < 3; ++b) CHECK(shared_s(rides[a], rides[b], 1.0) > 5.0);
    }
  }
}

TEST_CASE("who drives keeps within the clear part of the street") {
  const RoadGraph roads = grid();
  const auto routes = choose_routes(roads, {.lengths_m = lengths_m(4, 120.0), .seed = 3});
  for (int r = 0; r < 4; ++r) {
    for (const Sample& sample : driven(routes[r], r, 120.0)) {
      // From the nearest street, of both directions.
      const Eigen::Vector2d off = sample.p - 14.0 * (sample.p / 14.0).array().round().matrix();
      CHECK(off.cwiseAbs().minCoeff() < roads.clear_half_width_m - 0.3);
    }
  }
}

TEST_CASE("routes exist for one robot and ten, ten seconds and ten minutes") {
  for (const auto& [robots, seconds] : {std::pair(1, 10.0), std::pair(10, 10.0), std::pair(10, 600.0)}) {
    const auto routes = choose_routes(grid(), {.lengths_m = lengths_m(robots, seconds)});
    REQUIRE(static_cast<int>(routes.size()) == robots);
    for (int r = 0; r < robots; ++r) CHECK(driven(routes[r], r, seconds).size() == 5 * seconds + 1);
  }
}

TEST_CASE("routes repeat with their seed and differ with another") {
  const auto lengths = lengths_m(2, 20.0);
  CHECK(choose_routes(grid(), {.lengths_m = lengths, .seed = 1}) ==
        choose_routes(grid(), {.lengths_m = lengths, .seed = 1}));
  CHECK(choose_routes(grid(), {.lengths_m = lengths, .seed = 1}) !=
        choose_routes(grid(), {.lengths_m = lengths, .seed = 2}));
}

}  // namespace
}  // namespace covey::sim
