// SPDX-License-Identifier: BSD-3-Clause
#include "core/sim/furnished_world.h"

#include "core/sim/surfaces.h"

namespace covey::sim {

using Eigen::Isometry3d;
using Eigen::Vector3d;

void FurnishedWorld::paint_furniture() {
  for (int& layer : wood_) layer = paint(paint_wood);
  for (int& layer : carton_) layer = paint(paint_carton);
  for (int& layer : books_) layer = paint(paint_books);
}

void FurnishedWorld::shelf(const Isometry3d& T_W_F, double width) {
  const Material wood = any(wood_, Label::kShelf, 1.0);
  const double height = random().uniform(1.3, 2.2);
  box(T_W_F, {0.0, -0.38, 0.0}, {width, -0.01, height}, wood);
  const auto at = [&](double x, double z) { return Vector3d(T_W_F * Vector3d(x, -0.385, z)); };
  builder().quad(
      {at(0.03, height - 0.03), at(0.03, 0.06), at(width - 0.03, 0.06), at(width - 0.03, height - 0.03)},
      {0.0, 0.0, 1.0, height / 1.2}, any(books_, Label::kShelf, 1.2));
}

void FurnishedWorld::desk(const Isometry3d& T_W_F, double width) {
  const Material wood = any(wood_, Label::kTable, 1.0);
  box(T_W_F, {0.0, -kTableDepth, 0.70}, {width, -0.05, 0.75}, wood);
  for (const double x : {0.03, width - 0.09}) {
    for (const double y : {-kTableDepth + 0.03, -0.11})
      box(T_W_F, {x, y, 0.0}, {x + 0.06, y + 0.06, 0.70}, wood);
  }
}

void FurnishedWorld::lay_things(const Isometry3d& T_W_F, double width) {
  for (double x = 0.08; x < width - 0.4;) {
    const double size = random().uniform(0.18, 0.34);
    box(T_W_F, {x, -0.65, 0.75},
        {x + size, -0.65 + random().uniform(0.2, 0.5), 0.75 + random().uniform(0.12, 0.4)}, carton(size));
    x += size + random().uniform(0.05, 0.3);
  }
}

void FurnishedWorld::pull_up_chair(const Isometry3d& T_W_F, double width) {
  chair(T_W_F * Eigen::Translation3d(0.5 * width, -kTableDepth - 0.1, 0.0) *
        Eigen::AngleAxisd(random().uniform(-0.4, 0.4), Vector3d::UnitZ()));
}

void FurnishedWorld::table(const Isometry3d& T_W_F, double width) {
  desk(T_W_F, width);
  lay_things(T_W_F, width);
  pull_up_chair(T_W_F, width);
}

// Low, since the vehicles pass above it.
void FurnishedWorld::chair(const Isometry3d& T_W_F) {
  const Material wood = any(wood_, Label::kChair, 1.0);
  const double half = 0.19;
  box(T_W_F, {-half, -half, 0.40}, {half, half, 0.44}, wood);
  box(T_W_F, {-half, -half, 0.44}, {half, -half + 0.03, 0.85}, any(books_, Label::kChair, 0.8));
  for (const double x : {-half, half - 0.04}) {
    for (const double y : {-half, half - 0.04}) box(T_W_F, {x, y, 0.0}, {x + 0.04, y + 0.04, 0.40}, wood);
  }
}

void FurnishedWorld::stack(const Isometry3d& T_W_F, double width) {
  double z = 0.0;
  const int boxes = 2 + random().below(3);
  for (int i = 0; i < boxes; ++i) {
    const double height = random().uniform(0.3, 0.5);
    const double half = 0.5 * width - random().uniform(0.02, 0.14);
    const Isometry3d T_W_X = T_W_F * Eigen::Translation3d(0.5 * width, -0.55, z) *
                             Eigen::AngleAxisd(random().uniform(-0.2, 0.2), Vector3d::UnitZ());
    box(T_W_X, {-half, -half, 0.0}, {half, half, height}, carton(2.0 * half));
    z += height;
  }
}

}  // namespace covey::sim
