// SPDX-License-Identifier: BSD-3-Clause
#include "core/imu/imu_buffer.h"

#include <catch2/catch.hpp>
#include <limits>
#include <string>

using namespace covey;

namespace {

ImuSample sample_at(Utime utime) {
  const double t = static_cast<double>(utime);
  return {utime, {t, 2.0 * t, 0.0}, {0.0, 1.0, -t}};
}

ImuBuffer make_buffer(Utime until) {
  ImuBuffer buffer;
  for (Utime t = 0; t <= until; t += 10) REQUIRE(buffer.add(sample_at(t)) == nullptr);
  return buffer;
}

}  // namespace

TEST_CASE("ImuBuffer: a stretch has its ends interpolated and every sample between them") {
  const ImuBuffer buffer = make_buffer(100);
  const auto samples = buffer.between(13, 38);
  REQUIRE(samples.size() == 4);
  for (std::size_t k = 0; k < samples.size(); ++k) {
    const Utime expected[] = {13, 20, 30, 38};
    REQUIRE(samples[k].utime == expected[k]);
    REQUIRE(samples[k].gyro.isApprox(sample_at(expected[k]).gyro));
    REQUIRE(samples[k].accel.isApprox(sample_at(expected[k]).accel));
  }
  REQUIRE(longest_gap(samples) == 10);
}

TEST_CASE("ImuBuffer: ends that are samples stand once, and a stretch may lie between two samples") {
  const ImuBuffer buffer = make_buffer(100);
  REQUIRE(buffer.between(20, 40).size() == 3);
  REQUIRE(buffer.between(0, 100).size() == 11);
  REQUIRE(buffer.between(50, 50).size() == 1);
  const auto inside = buffer.between(52, 57);
  REQUIRE(inside.size() == 2);
  REQUIRE(inside[0].utime == 52);
  REQUIRE(inside[1].utime == 57);
}

TEST_CASE("ImuBuffer: what is not covered is empty") {
  const ImuBuffer buffer = make_buffer(100);
  REQUIRE(buffer.between(-1, 50).empty());
  REQUIRE(buffer.between(50, 101).empty());
  REQUIRE(buffer.between(60, 50).empty());
  REQUIRE(ImuBuffer().between(0, 0).empty());
  REQUIRE(longest_gap({}) == 0);
}

TEST_CASE("ImuBuffer: late, doubled and infinite samples are refused, old ones go") {
  ImuBuffer buffer(5);
  for (Utime t = 0; t <= 90; t += 10) REQUIRE(buffer.add(sample_at(t)) == nullptr);
  REQUIRE(buffer.size() == 5);
  REQUIRE(buffer.front().utime == 50);
  REQUIRE(std::string(buffer.add(sample_at(90))) == "late");
  REQUIRE(std::string(buffer.add(sample_at(85))) == "late");
  ImuSample bad = sample_at(100);
  bad.accel.y() = std::numeric_limits<double>::quiet_NaN();
  REQUIRE(std::string(buffer.add(bad)) == "not_finite");
  REQUIRE(buffer.back().utime == 90);
  buffer.drop_before(75);
  REQUIRE(buffer.front().utime == 70);
  REQUIRE(buffer.covers(75, 90));
  buffer.drop_before(1000);
  REQUIRE(buffer.size() == 1);
}
