// SPDX-License-Identifier: BSD-3-Clause
#include "procs/radio_bridge/options.h"

#include <catch2/catch.hpp>
#include <filesystem>

#include "procs/radio_bridge/network_namespace.h"
#include "procs/radio_bridge/radio_socket.h"

namespace covey {
namespace {

using Catch::Matchers::Contains;

RadioBridgeOptions read(Config config) {
  RadioBridgeOptions options;
  read_config(config.root().section("radio_bridge"), options);
  config.check_all_read();
  return options;
}

TEST_CASE("a radio's URL names group, port and ttl, a wrong one is refused in words") {
  const RadioUrl url = parse_radio_url("udpm://239.1.2.3:7801?ttl=2");
  REQUIRE(url.group == "239.1.2.3");
  REQUIRE(url.port == 7801);
  REQUIRE(url.ttl == 2);
  REQUIRE(parse_radio_url("udpm://239.1.2.3:7801").ttl == -1);
  REQUIRE_THROWS_WITH(parse_radio_url("tcp://239.1.2.3:7801"), Contains("udpm://GROUP:PORT"));
  REQUIRE_THROWS_WITH(parse_radio_url("udpm://239.1.2.3"), Contains("port is missing"));
  REQUIRE_THROWS_WITH(parse_radio_url("udpm://10.0.0.1:7801"), Contains("not a multicast address"));
  REQUIRE_THROWS_WITH(parse_radio_url("udpm://239.1.2.3:78010"), Contains("'78010'"));
  REQUIRE_THROWS_WITH(parse_radio_url("udpm://239.1.2.3:7801?ttl=x"), Contains("'x'"));
  REQUIRE_THROWS_WITH(parse_radio_url("udpm://239.1.2.3:7801?recv_buf_size=5"), Contains("unknown option"));
}

TEST_CASE("every radio configuration that comes with Covey can be read") {
  int files = 0;
  for (const auto& entry :
       std::filesystem::directory_iterator(std::filesystem::path(COVEY_SOURCE_DIR) / "configs/radio")) {
    INFO(entry.path());
    REQUIRE_NOTHROW(read(Config::load(entry.path())));
    ++files;
  }
  REQUIRE(files >= 3);
  const std::filesystem::path folder = std::filesystem::path(COVEY_SOURCE_DIR) / "configs/radio";
  const RadioBridgeOptions lossy = read(Config::load(folder / "lossy.yaml"));
  REQUIRE(lossy.model.loss == 0.2);
  REQUIRE(lossy.model.delay_ms == 100.0);
  REQUIRE(read(Config::load(folder / "contacts.yaml")).model.contacts->size() == 5);
}

TEST_CASE("ideal.yaml writes the defaults down") {
  const RadioBridgeOptions ideal =
      read(Config::load(std::filesystem::path(COVEY_SOURCE_DIR) / "configs/radio/ideal.yaml"));
  const RadioBridgeOptions defaults;
  REQUIRE(ideal.ttl == defaults.ttl);
  REQUIRE(ideal.interface == defaults.interface);
  REQUIRE(ideal.model.loss == defaults.model.loss);
  REQUIRE(ideal.model.delay_ms == defaults.model.delay_ms);
  REQUIRE(ideal.model.rate_bytes_per_s == defaults.model.rate_bytes_per_s);
  REQUIRE(ideal.model.burst_bytes == defaults.model.burst_bytes);
  REQUIRE(ideal.model.seed == defaults.model.seed);
  REQUIRE_FALSE(ideal.model.contacts);
}

TEST_CASE("a namespace that is not there is refused with its path") {
  REQUIRE_THROWS_WITH(enter_network_namespace("/proc/0/ns/net"), Contains("--netns /proc/0/ns/net"));
}

}  // namespace
}  // namespace covey
