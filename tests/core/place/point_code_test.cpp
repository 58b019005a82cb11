// SPDX-License-Identifier: BSD-3-Clause
#include "core/place/point_code.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <string>

#include "tests/core/place/places.h"

namespace covey::place {
namespace {

using testing::RandomGeometry;

FrameFeatures some_points(std::uint64_t seed) {
  RandomGeometry random(seed);
  FrameFeatures features =
      see(testing::make_place(300, random), testing::body_behind_camera(), testing::forward_camera(), random);
  return best_of(features, 150);
}

FrameFeatures decoded(const std::vector<std::uint8_t>& code, const FrameFeatures& features) {
  FrameFeatures back;
  back.noise = features.noise;
  back.descriptors = features.descriptors;
  REQUIRE(decode_points(code, static_cast<int>(features.size()), back) == nullptr);
  REQUIRE(back.bearings_C.size() == features.size());
  REQUIRE(back.depths_m.size() == features.size());
  return back;
}

TEST_CASE(
    "points come back within an eighth of their standard deviation, in their order, in some four bytes "
    "each") {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const FrameFeatures features = some_points(seed);
    const auto code = encode_points(features);
    REQUIRE(10 * code.size() < 43 * features.size());
    const FrameFeatures back = decoded(code, features);
    for (std::size_t k = 0; k < features.size(); ++k) {
      const double off = (back.direction(k) - features.direction(k)).cwiseAbs().maxCoeff();
      REQUIRE(off < 0.126 * features.noise.direction);
      REQUIRE(back.has_depth(k) == features.has_depth(k));
      if (!back.has_depth(k)) continue;
      const auto before = static_cast<double>(features.depths_m[k]);
      const auto after = static_cast<double>(back.depths_m[k]);
      REQUIRE(std::abs(1.0 / before - 1.0 / after) < 0.126 * features.noise.inverse_depth);
    }
  }
}

TEST_CASE("what was coded once is coded again to the same bytes") {
  const FrameFeatures features = some_points(3);
  const auto code = encode_points(features);
  REQUIRE(encode_points(decoded(code, features)) == code);
}

TEST_CASE("no points and points at the edge of what a camera sees come back") {
  FrameFeatures features;
  REQUIRE(decoded(encode_points(features), features).size() == 0);
  for (const auto& [x, depth] : {std::pair{-90.0F, 0.0F}, {0.0F, 0.05F}, {90.0F, 1000.0F}}) {
    features.bearings_C.push_back(Eigen::Vector3f(x, 0.0F, 1.0F).normalized());
    features.depths_m.push_back(depth);
    features.descriptors.emplace_back();
  }
  const FrameFeatures back = decoded(encode_points(features), features);
  for (std::size_t k = 0; k < features.size(); ++k) {
    REQUIRE((back.direction(k) - features.direction(k)).norm() < 0.01);
    REQUIRE(back.has_depth(k) == features.has_depth(k));
  }
}

TEST_CASE("any bytes are refused with a reason or are points in front of a camera") {
  RandomGeometry random(5);
  FrameFeatures features = some_points(2);
  const auto good = encode_points(features);
  int taken = 0;
  for (int trial = 0; trial < 5000; ++trial) {
    auto code = good;
    if (trial % 3 == 0)
      code.resize(static_cast<std::size_t>(random.index(static_cast<int>(good.size()) + 20)));
    for (int k = 0; k < 3 && !code.empty(); ++k) {
      code[static_cast<std::size_t>(random.index(static_cast<int>(code.size())))] =
          static_cast<std::uint8_t>(random.index(256));
    }
    FrameFeatures back;
    back.noise = features.noise;
    if (decode_points(code, static_cast<int>(features.size()), back)) continue;
    ++taken;
    for (std::size_t k = 0; k < features.size(); ++k) {
      REQUIRE(back.bearings_C[k].norm() == Approx(1.0F));
      REQUIRE(back.bearings_C[k].z() > 0.0F);
      REQUIRE(back.depths_m[k] >= 0.0F);
      REQUIRE(back.depths_m[k] < 1e4F);
    }
  }
  REQUIRE(taken > 0);
  FrameFeatures back;
  REQUIRE(decode_points({}, 30, back) == std::string("code"));
  REQUIRE(decode_points(good, static_cast<int>(features.size()) - 9, back) == std::string("code"));
}

}  // namespace
}  // namespace covey::place
