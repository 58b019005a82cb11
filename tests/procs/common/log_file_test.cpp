// SPDX-License-Identifier: BSD-3-Clause
#include "procs/common/log_file.h"

#include <unistd.h>

#include <catch2/catch.hpp>
#include <filesystem>
#include <limits>

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

}  // namespace
}  // namespace covey
