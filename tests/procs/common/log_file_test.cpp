// SPDX-License-Identifier: BSD-3-Clause
#include "procs/common/log_file.h"

#include <unistd.h>

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <limits>
#include <sstream>

namespace covey {
namespace {

TEST_CASE("Events at impossible times are left out, and what is flushed can be read at once") {
  const auto file =
      std::filesystem::temp_directory_path() / ("covey_log_" + std::to_string(getpid()) + ".lcm");
  LogRecorder log(file.string());
  const Utime extremes[] = {std::numeric_limits<Utime>::min(), -1, 5, std::numeric_limits<Utime>::max(), 7};
  for (const Utime time : extremes) log.write(time, "X", {1, 2, 3});
  log.flush();
  REQUIRE(log.good());
  std::vector<Utime> times;
  int delivered = 0;
  LogReader reader(file.string(), [&](const std::string&, const Bytes&) { ++delivered; });
  while (const auto time = reader.next_time()) {
    times.push_back(*time);
    reader.deliver();
  }
  std::filesystem::remove(file);
  CHECK(times == std::vector<Utime>{5, 7});
  CHECK(delivered == 2);
}

TEST_CASE("A log that was torn and then appended to is read on after the tear") {
  const auto file =
      std::filesystem::temp_directory_path() / ("covey_torn_" + std::to_string(getpid()) + ".lcm");
  const auto content = [&](Utime first) {
    {
      LogRecorder log(file.string());
      for (Utime time = first; time < first + 5; ++time) log.write(time, "X", Bytes(100));
    }
    std::ostringstream bytes;
    bytes << std::ifstream(file, std::ios::binary).rdbuf();
    return bytes.str();
  };
  const std::string before = content(10);
  const std::string after = content(20);
  std::ofstream(file, std::ios::binary) << before.substr(0, before.size() - 50) << after;
  std::vector<Utime> times;
  LogReader reader(file.string(), [](const std::string&, const Bytes&) {});
  while (const auto time = reader.next_time()) {
    times.push_back(*time);
    reader.deliver();
  }
  std::filesystem::remove(file);
  REQUIRE(times.size() >= 8);  // the torn one is lost, and perhaps the one that it runs into
  CHECK(times[3] == 13);
  CHECK(times.back() == 24);
}

}  // namespace
}  // namespace covey
