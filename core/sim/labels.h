// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The semantic classes of the simulated worlds, as they stand in depth_t.labels and in the vertices of world.ply. The numbers are part
// of recorded logs: new classes are added at the end.

#include <array>
#include <cstdint>
#include <string_view>

namespace covey::sim {

enum class Label : std::uint8_t {
  kGround,  // grass, earth
  kRoad,
  kPavement,
  kHouse,
  kTree,
  kCar,
  kPole,
  kFence,
  kFloor,
  kWall,
  kCeiling,
  kTable,
  kShelf,
  kBox,
  kChair,
};
constexpr std::uint8_t kUnknownLabel = 255;

struct LabelClass {
  std::string_view name;
  std::array<std::uint8_t, 3> colour;  // red, green, blue: for pictures by label
};

// By number.
constexpr std::array<LabelClass, 15> kLabelClasses = {{
    {"ground", {120, 170, 80}},
    {"road", {90, 90, 100}},
    {"pavement", {190, 180, 170}},
    {"house", {200, 90, 60}},
    {"tree", {20, 110, 50}},
    {"car", {40, 90, 200}},
    {"pole", {240, 200, 40}},
    {"fence", {150, 100, 50}},
    {"floor", {130, 110, 90}},
    {"wall", {220, 210, 190}},
    {"ceiling", {240, 240, 240}},
    {"table", {180, 120, 40}},
    {"shelf", {110, 60, 140}},
    {"box", {230, 130, 30}},
    {"chair", {40, 160, 170}},
}};

constexpr const LabelClass& label_class(Label label) {
  return kLabelClasses[static_cast<std::size_t>(label)];
}

}  // namespace covey::sim
