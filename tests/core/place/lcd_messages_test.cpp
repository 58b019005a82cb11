// SPDX-License-Identifier: BSD-3-Clause
#include "core/place/lcd_messages.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <limits>
#include <random>

#include "core/base/bytes.h"
#include "core/place/lcd_agent.h"
#include "core/place/vocabulary_training.h"
#include "tests/core/place/places.h"

namespace covey::place {
namespace {

using testing::RandomGeometry;

FrameFeatures some_features() {
  RandomGeometry random(2);
  return see(testing::make_place(80, random), testing::body_behind_camera(), testing::forward_camera(),
             random);
}

Vocabulary small_vocabulary() {
  RandomGeometry random(1);
  std::vector<std::vector<Descriptor>> images(20);
  for (auto& image : images) {
    for (int k = 0; k < 100; ++k) image.push_back(testing::random_descriptor(random));
  }
  return train_vocabulary(images, {.branching = 6, .depth = 3, .least_to_split = 10});
}

TEST_CASE("features cross as they are, but for the precision of the camera's place") {
  const FrameFeatures features = some_features();
  lcd_features_t message{};
  REQUIRE(decode(encode(features_message({3, 77, 5}, 9, 1, features)), message));
  REQUIRE(message.from == 3);
  REQUIRE(message.to == 1);
  REQUIRE(message.segment == 77);
  REQUIRE(message.id == 5);
  const auto back = features_from(message);
  REQUIRE(back);
  REQUIRE(back->bearings_C == features.bearings_C);
  REQUIRE(back->depths_m == features.depths_m);
  REQUIRE(back->descriptors == features.descriptors);
  REQUIRE((back->T_B_C.inverse() * features.T_B_C).log().norm() < 1e-6);
  REQUIRE(features_from(features_message({3, 77, 5}, 9, 1, {}))->size() == 0);
}

TEST_CASE("words cross as they are") {
  const Vocabulary vocabulary = small_vocabulary();
  const BagOfWords bag = vocabulary.bag(some_features().descriptors);
  lcd_words_t message{};
  REQUIRE(decode(encode(words_message({3, 77, 5}, 9, bag, vocabulary.hash())), message));
  REQUIRE(message.to == -1);
  const auto back = bag_from(message, vocabulary.words());
  REQUIRE(back);
  REQUIRE(back->words == bag.words);
  REQUIRE(back->weights == bag.weights);
  // What cannot be counted from without an overflow.
  lcd_words_t extreme = message;
  extreme.id = std::numeric_limits<std::int32_t>::max();
  REQUIRE_FALSE(bag_from(extreme, vocabulary.words()));
  extreme = message;
  extreme.utime = std::numeric_limits<std::int64_t>::min();
  REQUIRE_FALSE(bag_from(extreme, vocabulary.words()));
}

TEST_CASE("closures are the same only with the same ends and the same numbers") {
  Verification verification;
  verification.covariance.setIdentity();
  const loop_t loop = loop_message({0, 1, 2}, {1, 3, 4}, verification, 2.5);
  REQUIRE(is_good(loop));
  REQUIRE(loop.similarity == 1.0);
  loop_t other = loop;
  other.stream = 5;
  other.number = 6;
  REQUIRE(is_same_closure(loop, other));
  other.t_A_B[1] = 1e-300;
  REQUIRE_FALSE(is_same_closure(loop, other));
  other = loop;
  ++other.segment_b;
  REQUIRE_FALSE(is_same_closure(loop, other));
  for (const double bad :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), 1e9}) {
    other = loop;
    other.t_A_B[0] = bad;
    REQUIRE_FALSE(is_good(other));
    other = loop;
    other.q_A_B[0] = bad;
    REQUIRE_FALSE(is_good(other));
  }
}

// Anything in every field but the counts, which the generated decoder believes (procs/common/process.cpp says what guards it): none may
// do harm, and what is taken must be usable.
TEST_CASE("damaged messages are refused or harmless") {
  const auto vocabulary = std::make_shared<const Vocabulary>(small_vocabulary());
  const FrameFeatures features = some_features();
  const Bytes words =
      encode(words_message({1, 7, 1}, 9, vocabulary->bag(features.descriptors), vocabulary->hash()));
  const Bytes feature_bytes = encode(features_message({1, 7, 1}, 9, 0, features));
  lcd_request_t request{};
  request.from = 1;
  request.n = 2;
  request.segments = {7, 7};
  request.ids = {0, 1};
  lcd_loop_t loop{};
  loop.from = 1;
  Verification verification;
  verification.covariance.setIdentity();
  loop.loop = loop_message({0, 7, 0}, {1, 7, 1}, verification, 0.5);
  const Bytes request_bytes = encode(request);
  const Bytes loop_bytes = encode(loop);

  LcdAgent agent(0, 1, vocabulary, {});
  std::mt19937_64 random(5);
  int taken = 0;
  const auto damage = [&random](Bytes bytes, const std::vector<std::size_t>& counts) {
    const int changes = 1 + static_cast<int>(random() % 3);
    for (int k = 0; k < changes; ++k) {
      const std::size_t at = 8 + random() % (bytes.size() - 8);
      const bool is_count =
          std::any_of(counts.begin(), counts.end(), [at](auto c) { return at >= c && at < c + 4; });
      if (!is_count) bytes[at] = static_cast<std::uint8_t>(random());
    }
    if (random() % 8 == 0) bytes.resize(random() % bytes.size());
    return bytes;
  };
  const auto feed = [&](const Bytes& bytes, auto message) {
    if (decode(bytes, message) && agent.receive(message, 1000) == nullptr) ++taken;
    agent.take_outgoing();
    agent.take_records();
    agent.work(1000);
  };
  const std::vector<std::size_t> in_features{36, 40, 44 + 16 * features.size()};
  for (int trial = 0; trial < 1000; ++trial) {
    feed(damage(words, {44}), lcd_words_t{});
    feed(damage(feature_bytes, in_features), lcd_features_t{});
    feed(damage(request_bytes, {24}), lcd_request_t{});
    feed(damage(loop_bytes, {}), lcd_loop_t{});
    lcd_features_t message{};
    if (decode(damage(feature_bytes, in_features), message)) {
      if (const auto usable = features_from(message)) verify(*usable, features);
    }
  }
  REQUIRE(taken > 0);
  for (const loop_t& told : agent.take_loops()) REQUIRE(is_good(told));
}

}  // namespace
}  // namespace covey::place
