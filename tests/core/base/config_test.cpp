// SPDX-License-Identifier: BSD-3-Clause
#include "core/base/config.h"

#include <catch2/catch.hpp>

namespace covey {
namespace {

using Catch::Matchers::Contains;

struct Link {
  double loss = 0.25;
  int delay_ms = 0;
};

Link read_link(ConfigSection& section) {
  Link link;
  section.read("loss", link.loss, 0.0, 1.0);
  section.read("delay_ms", link.delay_ms, 0, 60000);
  return link;
}

TEST_CASE("a file overrides the defaults key by key") {
  Config config = Config::parse("link:\n  delay_ms: 100\n", "radio.yaml");
  const Link link = read_link(config.root().section("link"));
  REQUIRE(link.loss == 0.25);
  REQUIRE(link.delay_ms == 100);
  REQUIRE_NOTHROW(config.check_all_read());
}

TEST_CASE("an absent section leaves every default") {
  Config config = Config::parse("", "radio.yaml");
  REQUIRE(read_link(config.root().section("link")).loss == 0.25);
  REQUIRE_NOTHROW(config.check_all_read());
}

TEST_CASE("an unknown key is refused with file, line, key and the known keys") {
  Config config = Config::parse("link:\n  delay_ms: 100\n  los: 0.1\n", "radio.yaml");
  read_link(config.root().section("link"));
  REQUIRE_THROWS_WITH(config.check_all_read(),
                      Contains("radio.yaml:3: unknown key 'link.los'") && Contains("loss"));
}

TEST_CASE("a value out of range or of the wrong kind is refused with its place") {
  Config range = Config::parse("loss: 1.5\n", "a.yaml");
  REQUIRE_THROWS_WITH(read_link(range.root()), Contains("a.yaml:1: key 'loss': 1.5 is outside [0, 1]"));
  Config kind = Config::parse("delay_ms: soon\n", "b.yaml");
  REQUIRE_THROWS_WITH(read_link(kind.root()), Contains("b.yaml:1: key 'delay_ms': 'soon'"));
  Config nan = Config::parse("loss: .nan\n", "c.yaml");
  REQUIRE_THROWS_AS(read_link(nan.root()), InputError);
}

TEST_CASE("lists of maps are read in order, each with its own place") {
  Config config = Config::parse("links:\n  - loss: 0.1\n  - loss: 0.2\n    extra: 1\n", "radio.yaml");
  std::vector<double> losses;
  for (ConfigSection* link : config.root().list("links")) losses.push_back(read_link(*link).loss);
  REQUIRE(losses == std::vector<double>{0.1, 0.2});
  REQUIRE_THROWS_WITH(config.check_all_read(), Contains("radio.yaml:4: unknown key 'links[1].extra'"));
}

TEST_CASE("text that is not YAML, or not a map, and a missing file are refused") {
  REQUIRE_THROWS_WITH(Config::parse("a: [1, 2\n", "x.yaml"), Contains("x.yaml:") && Contains("not YAML"));
  REQUIRE_THROWS_WITH(Config::parse("- 1\n", "x.yaml"), Contains("x.yaml:1: expected a map"));
  REQUIRE_THROWS_WITH(Config::load("no/such.yaml"), Contains("no/such.yaml: cannot be read"));
  REQUIRE_THROWS_WITH(Config::load("/tmp"), Contains("/tmp: cannot be read"));
  REQUIRE_THROWS_WITH(Config::parse("[a, b]: 1\n", "x.yaml").check_all_read(),
                      Contains("x.yaml:1: a key must"));
}

}  // namespace
}  // namespace covey
