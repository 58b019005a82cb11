// SPDX-License-Identifier: BSD-3-Clause
#include "core/sim/euroc_files.h"

#include <zlib.h>

#include <catch2/catch.hpp>

#include "tests/core/pgo/scratch.h"

namespace covey::sim {
namespace {

using Catch::Matchers::Contains;

Trajectory truth_of(const std::string& text) { return read_euroc_truth(ScratchFile(text).path); }
std::vector<ImuSample> imu_of(const std::string& text) { return read_euroc_imu(ScratchFile(text).path); }

TEST_CASE("EuRoC's columns: stamps in ns, quaternions w first, more columns than are read") {
  const Trajectory truth = truth_of(
      "#timestamp, p, q, v, b\r\n"
      "1403638128940097024,4.5,-1.5,0.25,0.5,-0.5,0.5,-0.5,0.002,-0.005,-0.002,0,0,0,0,0,0\r\n"
      "1403638128945096960,4.5,-1.5,0.25,1,0,0,0,0.002,-0.005,-0.002,0,0,0,0,0,0");
  REQUIRE(truth.size() == 2);
  CHECK(truth[0].utime == 1'403'638'128'940'097);
  CHECK(truth[0].pose.translation == Eigen::Vector3d(4.5, -1.5, 0.25));
  CHECK(truth[0].pose.rotation.quaternion().coeffs() == Eigen::Vector4d(-0.5, 0.5, -0.5, 0.5));
}

TEST_CASE("TUM's text: stamps in s, quaternions w last") {
  const Trajectory truth = truth_of(
      "# timestamp(s) tx ty tz qx qy qz qw\n"
      "1403636580.83856 4.5 -1.5 0.75 -0.5 0.5 -0.5 0.5\n");
  REQUIRE(truth.size() == 1);
  CHECK(truth[0].utime == 1'403'636'580'838'560);
  CHECK(truth[0].pose.rotation.quaternion().coeffs() == Eigen::Vector4d(-0.5, 0.5, -0.5, 0.5));
}

TEST_CASE("an IMU's samples, gzipped") {
  const ScratchFile file;
  gzFile out = gzopen(file.path.c_str(), "wb");
  gzputs(out, "#timestamp [ns],w,w,w,a,a,a\n1403636579758555392,-0.1,0.2,0.3,8.1,-0.4,-2.4\n");
  gzclose(out);
  const auto samples = read_euroc_imu(file.path);
  REQUIRE(samples.size() == 1);
  CHECK(samples[0].utime == 1'403'636'579'758'555);
  CHECK(samples[0].gyro == Eigen::Vector3d(-0.1, 0.2, 0.3));
  CHECK(samples[0].accel == Eigen::Vector3d(8.1, -0.4, -2.4));
}

TEST_CASE("what cannot be read is named with file and line") {
  CHECK_THROWS_WITH(read_euroc_imu("/no/such/file.gz"), Contains("/no/such/file.gz"));
  CHECK_THROWS_WITH(imu_of("# only a comment\n"), Contains("has no measurement"));
  CHECK_THROWS_WITH(imu_of("100000,1,2,3,4,5\n"), Contains(":1: expected"));
  CHECK_THROWS_WITH(imu_of("# x\n100000,1,2,3,4,5,abc\n"), Contains(":2: 'abc' is not a number"));
  CHECK_THROWS_WITH(imu_of("100000,1,2,3,4,5,nan\n"), Contains("is not a number"));
  CHECK_THROWS_WITH(imu_of("1.5,1,2,3,4,5,6\n"), Contains("'1.5' is not in nanoseconds"));
  CHECK_THROWS_WITH(imu_of("200000,1,2,3,4,5,6\n100000,1,2,3,4,5,6\n"), Contains(":2: its stamp"));
  CHECK_THROWS_WITH(truth_of("100000,1,2,3,0.5,0,0,0\n"), Contains("unit length"));
  CHECK_THROWS_WITH(truth_of("1403638128940097024 1 2 3 1 0 0 0\n"), Contains("is not in seconds"));
}

TEST_CASE("a torn gzip is told from a short one") {
  const ScratchFile file;
  gzFile out = gzopen(file.path.c_str(), "wb");
  for (int k = 0; k < 10000; ++k)
    gzprintf(out, "%d,0.1,0.2,0.3,%d,0.5,0.6\n", 100000 + k * 5000, k * 7919 % 1000);
  gzclose(out);
  std::filesystem::resize_file(file.path, std::filesystem::file_size(file.path) / 2);
  CHECK_THROWS_WITH(read_euroc_imu(file.path), Contains("damaged after line"));
}

}  // namespace
}  // namespace covey::sim
