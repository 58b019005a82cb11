// SPDX-License-Identifier: BSD-3-Clause
#include "core/geometry/trajectory.h"

#include <unistd.h>

#include <catch2/catch.hpp>
#include <fstream>

#include "core/base/error.h"
#include "tests/core/geometry/random.h"

using namespace covey;
using Catch::Matchers::Contains;

namespace {

class TemporaryFile {
 public:
  explicit TemporaryFile(const std::string& name)
      : path_(std::filesystem::temp_directory_path() / fmt::format("covey_{}_{}", getpid(), name)) {}
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  ~TemporaryFile() { std::filesystem::remove(path_); }

  const std::filesystem::path& path() const { return path_; }
  void write(const std::string& text) const { std::ofstream(path_) << text; }

 private:
  std::filesystem::path path_;
};

}  // namespace

TEST_CASE("TUM: what is written is read back") {
  testing::RandomGeometry random;
  Trajectory written;
  Utime utime = 1403636579763555LL;
  for (int k = 0; k < testing::kTrials; ++k) {
    utime += 1 + random.index(1000000);
    written.push_back({utime, random.pose()});
  }
  const TemporaryFile file("round_trip.tum");
  write_tum(file.path(), written);
  const Trajectory read = read_tum(file.path());
  REQUIRE(read.size() == written.size());
  for (std::size_t k = 0; k < read.size(); ++k) {
    REQUIRE(read[k].utime == written[k].utime);
    REQUIRE((read[k].pose.matrix() - written[k].pose.matrix()).norm() < 1e-8);
  }
}

TEST_CASE("TUM: comments and empty lines are skipped, negative stamps kept") {
  const TemporaryFile file("comments.tum");
  file.write("# t tx ty tz qx qy qz qw\n\n  \r\n-1.5 1 2 3 0 0 0 2\n0.000001 1 2 3 0 0 0 1\r\n");
  const Trajectory read = read_tum(file.path());
  REQUIRE(read.size() == 2);
  REQUIRE(read[0].utime == -1500000);
  REQUIRE(read[0].pose.rotation.quaternion().w() == 1.0);
  REQUIRE(read[1].utime == 1);
  write_tum(file.path(), read);
  REQUIRE(read_tum(file.path())[0].utime == -1500000);
}

TEST_CASE("TUM: a bad line is refused with file and line") {
  const TemporaryFile file("bad.tum");
  const std::string good = "1 0 0 0 0 0 0 1\n";
  const std::pair<const char*, const char*> cases[] = {
      {"2 0 0 0 0 0 0\n", "expected eight numbers"}, {"2 0 0 zero 0 0 0 1\n", "expected eight numbers"},
      {"2 0 0 0 0 0 0 1 9\n", "'9' after"},          {"2 0 0 0 0 0 0 0\n", "quaternion is zero"},
      {"1 0 0 0 0 0 0 1\n", "does not come after"},  {"1e300 0 0 0 0 0 0 1\n", "not in seconds"}};
  for (const auto& [line, reason] : cases) {
    file.write(good + line);
    REQUIRE_THROWS_WITH(read_tum(file.path()), Contains(file.path().string() + ":2: ") && Contains(reason));
  }
  REQUIRE_THROWS_AS(read_tum("/nowhere/at.tum"), InputError);
  REQUIRE_THROWS_AS(write_tum("/nowhere/at.tum", {}), InputError);
}
