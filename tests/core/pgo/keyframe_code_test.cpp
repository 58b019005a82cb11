// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/keyframe_code.h"

#include <catch2/catch.hpp>
#include <random>

namespace covey::pgo {
namespace {

std::vector<PublicKeyframe> keyframe_walk(int n, std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  std::vector<PublicKeyframe> keyframes{{0, 0, {SO3{}, {100.0, 50.0, -3.0}}}};
  while (static_cast<int>(keyframes.size()) < n) {
    PublicKeyframe next = keyframes.back();
    next.id += 1 + static_cast<int>(random() % 4);
    // Once in a while any rotation, half turns too.
    const double spread = random() % 10 == 0 ? 2.0 : 0.1;
    next.T_S_K =
        next.T_S_K * SE3{SO3::exp(spread * Eigen::Vector3d(normal(random), normal(random), normal(random))),
                         {1.0, 0.1 * normal(random), 0.05 * normal(random)}};
    if (random() % 40 == 0) next = {next.segment + 1, 0, {}};
    keyframes.push_back(next);
  }
  return keyframes;
}

TEST_CASE("keyframes are known to within their units after any way, in a third of the bytes of floats") {
  std::mt19937_64 random(1);
  const std::vector<PublicKeyframe> keyframes = keyframe_walk(300, random);
  dpgo_keyframes_t message{};
  encode_keyframes(keyframes, {1e-3, 1e-2}, message);
  REQUIRE(message.n < 300 * 34 / 3);
  const auto decoded = decode_keyframes(message);
  REQUIRE(decoded);
  REQUIRE(decoded->size() == keyframes.size());
  for (std::size_t k = 0; k < keyframes.size(); ++k) {
    REQUIRE((*decoded)[k].segment == keyframes[k].segment);
    REQUIRE((*decoded)[k].id == keyframes[k].id);
    const SE3 error = (*decoded)[k].T_S_K.inverse() * keyframes[k].T_S_K;
    REQUIRE(error.rotation.log().norm() < 2e-3);
    REQUIRE(error.translation.norm() < 1e-2);
  }
}

TEST_CASE("keyframes too far apart for their units are said in coarser ones") {
  const std::vector<PublicKeyframe> keyframes{{0, 0, {}}, {0, 1, {SO3{}, {3e6, 0.0, 0.0}}}};
  dpgo_keyframes_t message{};
  encode_keyframes(keyframes, {0.0, 0.0}, message);
  const auto decoded = decode_keyframes(message);
  REQUIRE(decoded);
  REQUIRE(decoded->back().T_S_K.translation.x() == Approx(3e6).margin(10.0));
}

TEST_CASE("what is no code of keyframes is refused") {
  std::mt19937_64 random(2);
  dpgo_keyframes_t message{};
  encode_keyframes(keyframe_walk(30, random), {1e-3, 1e-2}, message);
  dpgo_keyframes_t bad = message;
  bad.code.pop_back();
  REQUIRE_FALSE(decode_keyframes(bad));
  bad.code.clear();
  REQUIRE_FALSE(decode_keyframes(bad));
  bad = message;
  bad.translation_unit = 1e9F;
  REQUIRE_FALSE(decode_keyframes(bad));
  for (std::size_t k = 0; k < message.code.size(); ++k) {  // whatever comes of it
    bad = message;
    bad.code[k] ^= 0x55;
    const auto decoded = decode_keyframes(bad);
    if (!decoded) continue;
    for (const PublicKeyframe& keyframe : *decoded) REQUIRE(keyframe.T_S_K.translation.allFinite());
  }
}

}  // namespace
}  // namespace covey::pgo
