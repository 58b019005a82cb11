// SPDX-License-Identifier: BSD-3-Clause
#include "procs/common/sensor_log.h"

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <vector>

#include "core/base/bands.h"

using namespace covey;

namespace {

struct Written {
  Utime time = 0;
  std::string channel;
  Bytes bytes;
};

stereo_t make_stereo(Utime utime) {
  stereo_t stereo{};
  stereo.utime = utime;
  stereo.width = 400;
  stereo.height = 200;
  stereo.n_left = 80'000;
  stereo.left.assign(80'000, static_cast<std::uint8_t>(utime / 1000));
  stereo.n_right = 80'000;
  stereo.right.assign(80'000, 7);
  return stereo;
}

std::string write_log(const std::string& name) {
  const std::string file = (std::filesystem::temp_directory_path() / name).string();
  SensorLogWriter writer(file);
  for (Utime utime = 1'000'000; utime < 1'010'000; utime += 500) {
    imu_t imu{};
    imu.utime = utime;
    writer.write(kImu, imu);
    if (utime % 5'000 == 0) writer.write(kStereo, make_stereo(utime));
  }
  REQUIRE(writer.finish());
  return file;
}

std::string bytes_of(const std::string& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

}  // namespace

TEST_CASE("a log of sensors has everything in order of time, and image sets in bands") {
  const std::string file = write_log("covey_sensor_log_a.lcm");
  std::vector<Written> events;
  LogReader reader(file, [&](const std::string& channel, const Bytes& bytes) {
    events.push_back({0, channel, bytes});
  });
  std::vector<Utime> times;
  while (const auto time = reader.next_time()) {
    times.push_back(*time);
    reader.deliver();
    events.back().time = *time;
  }
  CHECK(std::is_sorted(times.begin(), times.end()));

  BandAssembler assembler;
  std::vector<Utime> image_sets;
  int imu = 0;
  for (const Written& event : events) {
    if (event.channel == kImu.name) {
      imu_t message{};
      REQUIRE(decode(event.bytes, message));
      CHECK(message.utime == event.time);
      ++imu;
      continue;
    }
    REQUIRE(event.channel == kStereo.name);
    band_t band{};
    REQUIRE(decode(event.bytes, band));
    CHECK(event.time == band.utime + band.band * kBandSpacingUs);
    const auto result = assembler.add(band);
    if (!result.message) continue;
    stereo_t stereo{};
    REQUIRE(decode(*result.message, stereo));
    CHECK(stereo.left == make_stereo(stereo.utime).left);
    image_sets.push_back(stereo.utime);
  }
  CHECK(imu == 20);
  CHECK(image_sets == std::vector<Utime>{1'000'000, 1'005'000});
}

TEST_CASE("the same sensors give the same log") {
  CHECK(bytes_of(write_log("covey_sensor_log_b.lcm")) == bytes_of(write_log("covey_sensor_log_c.lcm")));
}
