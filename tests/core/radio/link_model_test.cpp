// SPDX-License-Identifier: BSD-3-Clause
#include "core/radio/link_model.h"

#include <catch2/catch.hpp>

namespace covey::radio {
namespace {

using Catch::Matchers::Contains;

LinkModelOptions read(const std::string& text) {
  Config config = Config::parse(text, "radio.yaml");
  LinkModelOptions options = read_link_model(config.root());
  config.check_all_read();
  return options;
}

TEST_CASE("a link without faults hears everything at once") {
  LinkModel model(0, {});
  REQUIRE(model.offer(1, Bytes{1, 2}, 10) == nullptr);
  REQUIRE(model.take_due(10) == std::vector<Bytes>{{1, 2}});
  REQUIRE(model.take_due(1000).empty());
}

TEST_CASE("loss, delay and duplicates happen as configured, and repeat with the seed") {
  const auto heard = [](std::int64_t seed, int robot) {
    LinkModel model(robot, {.loss = 0.2, .delay_ms = 100, .jitter_ms = 10, .duplicate = 0.1, .seed = seed});
    std::vector<Bytes> all;
    for (int i = 0; i < 2000; ++i) {
      model.offer(1, Bytes{static_cast<std::uint8_t>(i), static_cast<std::uint8_t>(i >> 8)}, i);
      REQUIRE(model.take_due(i).empty());
    }
    REQUIRE(model.take_due(99'999).empty());
    for (const Bytes& datagram : model.take_due(2000 + 110'000)) all.push_back(datagram);
    return all;
  };
  REQUIRE(static_cast<double>(heard(1, 0).size()) == Approx(2000 * 0.8 * 1.1).epsilon(0.05));
  REQUIRE(heard(1, 0) == heard(1, 0));
  REQUIRE(heard(1, 0) != heard(2, 0));
  REQUIRE(heard(1, 0) != heard(1, 2));
}

TEST_CASE("contacts open and close in both directions, none listed means that nobody hears anybody") {
  const LinkModelOptions options = read(
      "epoch_utime: 1000000\n"
      "contacts:\n"
      "  - {a: 0, b: 1, from_s: 0, until_s: 10}\n"
      "  - {a: 2, b: 0, from_s: 5, until_s: 6}\n");
  const LinkModel model(0, options);
  REQUIRE(model.in_contact(1, 1'000'000));
  REQUIRE(model.in_contact(1, 10'999'999));
  REQUIRE_FALSE(model.in_contact(1, 11'000'000));
  REQUIRE_FALSE(model.in_contact(2, 1'000'000));
  REQUIRE(model.in_contact(2, 6'000'000));
  REQUIRE_FALSE(model.in_contact(3, 1'000'000));
  LinkModel alone(0, read("contacts: []\n"));
  REQUIRE(alone.offer(1, Bytes{1}, 0) == std::string("no_contact"));
  REQUIRE(LinkModel(0, read("loss: 0.5\n")).in_contact(5, 0));
}

TEST_CASE("a wrong file is refused with its place") {
  REQUIRE_THROWS_WITH(read("loss: 1.5\n"), Contains("radio.yaml:1: key 'loss'"));
  REQUIRE_THROWS_WITH(read("contacts:\n  - {a: 0, b: 1, from_s: 5, until_s: 5}\n"), Contains("radio.yaml:2"));
  REQUIRE_THROWS_WITH(read("contacts:\n  - {a: 0, b: 99}\n"), Contains("outside [0, 63]"));
  REQUIRE_THROWS_WITH(read("delay: 1\n"), Contains("unknown key 'delay'"));
}

TEST_CASE("the budget lets its rate through, and a burst after a pause") {
  Budget budget(10'000.0, 2'000.0);
  std::size_t sent = 0;
  for (Utime now = 0; now <= 10 * kUsPerSecond; now += 1000) {
    while (budget.open(now)) {
      budget.spend(1000);
      sent += 1000;
    }
  }
  REQUIRE(sent >= 100'000);
  REQUIRE(sent <= 100'000 + 2'000 + 1'000);
  Budget unlimited(0.0, 0.0);
  unlimited.spend(1'000'000);
  REQUIRE(unlimited.open(0));
}

}  // namespace
}  // namespace covey::radio
