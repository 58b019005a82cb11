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

TEST_CASE("a keyframe's best features cross, as exactly as they are known, in less than 6 kB") {
  RandomGeometry random(2);
  const FrameFeatures all =
      see(testing::make_place(600, random), testing::body_behind_camera(), testing::forward_camera(), random);
  REQUIRE(all.size() > 500);
  const FrameFeatures features = best_of(all, LcdOptions{}.sent_features);
  REQUIRE(static_cast<int>(features.size()) == LcdOptions{}.sent_features);
  const Bytes bytes = encode(frame_message({3, 77, 5}, 9, 1, features));
  REQUIRE(bytes.size() < 5600);
  lcd_frame_t message{};
  REQUIRE(decode(bytes, message));
  REQUIRE(message.from == 3);
  REQUIRE(message.to == 1);
  REQUIRE(message.segment == 77);
  REQUIRE(message.id == 5);
  FrameFeatures back;
  REQUIRE(read_frame(message, back) == nullptr);
  REQUIRE(back.descriptors == features.descriptors);
  REQUIRE((back.T_B_C.inverse() * features.T_B_C).log().norm() < 1e-6);
  REQUIRE(back.noise.direction == Approx(features.noise.direction));
  REQUIRE(back.noise.inverse_depth == Approx(features.noise.inverse_depth));
  for (std::size_t k = 0; k < features.size(); ++k) {
    REQUIRE((back.direction(k) - features.direction(k)).norm() < 0.2 * features.noise.direction);
    REQUIRE(back.has_depth(k) == features.has_depth(k));
  }
  REQUIRE(read_frame(frame_message({3, 77, 5}, 9, 1, {}), back) == nullptr);
  REQUIRE(back.size() == 0);
}

TEST_CASE("the best features are those with a depth, in their order") {
  const FrameFeatures features = some_features();
  const auto depths = static_cast<int>(
      std::count_if(features.depths_m.begin(), features.depths_m.end(), [](float d) { return d > 0.0F; }));
  const FrameFeatures few = best_of(features, depths - 3);
  REQUIRE(static_cast<int>(few.size()) == depths - 3);
  std::size_t at = 0;
  for (std::size_t k = 0; k < few.size(); ++k, ++at) {
    while (!features.has_depth(at)) ++at;
    REQUIRE(few.descriptors[k] == features.descriptors[at]);
    REQUIRE(few.depths_m[k] == features.depths_m[at]);
    REQUIRE(few.bearings_C[k] == features.bearings_C[at]);
  }
  REQUIRE(best_of(features, depths + 2).size() == static_cast<std::size_t>(depths) + 2);
  REQUIRE_FALSE(best_of(features, depths + 2).has_depth(static_cast<std::size_t>(depths)));
  REQUIRE(best_of(features, 10'000).size() == features.size());
  const FrameFeatures rest = best_of(features, 10'000, depths - 3);
  REQUIRE(rest.size() + few.size() == features.size());
  REQUIRE(rest.descriptors.front() == best_of(features, 10'000).descriptors[few.size()]);
  REQUIRE(best_of(features, depths, depths + 1).size() == 0);
}

TEST_CASE("words cross in less than 0.5 kB, and make the sender's bag to the last bit") {
  RandomGeometry random(7);
  std::vector<Descriptor> descriptors;
  for (int k = 0; k < 500; ++k) descriptors.push_back(testing::random_descriptor(random));
  const Vocabulary vocabulary = small_vocabulary();
  const WordCounts counts = vocabulary.counts(descriptors);
  const Bytes bytes = encode(bag_message({3, 77, 5}, 9, counts, vocabulary.hash()));
  REQUIRE(bytes.size() < 500);
  lcd_bag_t message{};
  REQUIRE(decode(bytes, message));
  REQUIRE(message.to == -1);
  WordCounts back;
  REQUIRE(read_bag(message, vocabulary.words(), back) == nullptr);
  const BagOfWords bag = vocabulary.bag(back);
  REQUIRE(bag.words == vocabulary.bag(descriptors).words);
  REQUIRE(bag.weights == vocabulary.bag(descriptors).weights);
  // What cannot be counted from without an overflow.
  lcd_bag_t extreme = message;
  extreme.id = std::numeric_limits<std::int32_t>::max();
  REQUIRE(read_bag(extreme, vocabulary.words(), back) == std::string("id"));
  extreme = message;
  extreme.utime = std::numeric_limits<std::int64_t>::min();
  REQUIRE(read_bag(extreme, vocabulary.words(), back) == std::string("utime"));
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
      encode(bag_message({1, 7, 1}, 9, vocabulary->counts(features.descriptors), vocabulary->hash()));
  const Bytes feature_bytes = encode(frame_message({1, 7, 1}, 9, 0, features));
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
  lcd_more_t more{};
  more.from = 1;
  more.known = 40;
  const Bytes more_bytes = encode(more);
  Inventory inventory;
  inventory.runs.resize(3);
  for (RunInventory& run : inventory.runs) run.ids.add(2, 9);
  inventory.runs[1].ids.add(20, 500);
  const Bytes inventory_bytes =
      encode(inventory_message(1, 9, static_cast<std::int64_t>(vocabulary->hash()), inventory));

  LcdAgent agent(0, 1, vocabulary, {});
  std::mt19937_64 random(5);
  int taken = 0;
  int usable_frames = 0;
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
  const std::size_t after_descriptors = 80 + kDescriptorBytes * features.size();
  const std::vector<std::size_t> in_features{76, after_descriptors};
  for (int trial = 0; trial < 1000; ++trial) {
    feed(damage(words, {48}), lcd_bag_t{});
    feed(damage(feature_bytes, in_features), lcd_frame_t{});
    feed(damage(request_bytes, {24}), lcd_request_t{});
    feed(damage(more_bytes, {}), lcd_more_t{});
    feed(damage(inventory_bytes, {33, 67}), lcd_inventory_t{});
    feed(damage(loop_bytes, {}), lcd_loop_t{});
    lcd_frame_t message{};
    FrameFeatures usable;
    if (decode(damage(feature_bytes, in_features), message) && read_frame(message, usable) == nullptr) {
      ++usable_frames;
      verify(usable, features);
    }
  }
  REQUIRE(taken > 0);
  REQUIRE(usable_frames > 0);
  for (const loop_t& told : agent.take_loops()) REQUIRE(is_good(told));
}

}  // namespace
}  // namespace covey::place
