// SPDX-License-Identifier: BSD-3-Clause
#include "core/geometry/kd_tree.h"

#include <algorithm>
#include <catch2/catch.hpp>

#include "tests/core/geometry/random.h"

using namespace covey;

namespace {

std::vector<double> sorted_distances(const std::vector<Eigen::Vector3f>& points, const Eigen::Vector3f& p,
                                     int step) {
  std::vector<double> distances;
  for (std::size_t k = 0; k < points.size(); k += step)
    distances.push_back((points[k] - p).cast<double>().norm());
  std::sort(distances.begin(), distances.end());
  return distances;
}

}  // namespace

TEST_CASE("KdTree: the nearest points are those that a search through all finds") {
  testing::RandomGeometry random(3);
  std::vector<Eigen::Vector3f> points;
  for (int k = 0; k < 700; ++k) points.push_back(random.vector<3>(4.0).cast<float>());
  const KdTree tree(points);
  std::vector<KdTree::Neighbour> near;
  for (int trial = 0; trial < 200; ++trial) {
    const Eigen::Vector3f p = random.vector<3>(5.0).cast<float>();
    const auto all = sorted_distances(points, p, 1);
    const auto even = sorted_distances(points, p, 2);
    REQUIRE(tree.nearest(p).distance == Approx(all[0]).margin(1e-5));
    tree.nearest(p, 5, near);
    REQUIRE(near.size() == 5);
    for (int k = 0; k < 5; ++k) REQUIRE(near[k].distance == Approx(all[k]).margin(1e-5));
    tree.nearest(p, 5, near, [](int index) { return index % 2 == 0; });
    REQUIRE(near.size() == 5);
    for (int k = 0; k < 5; ++k) {
      REQUIRE(near[k].index % 2 == 0);
      REQUIRE(near[k].distance == Approx(even[k]).margin(1e-5));
    }
  }
}

TEST_CASE("KdTree: fewer points than asked for, and none") {
  const KdTree tree({{0, 0, 0}, {1, 0, 0}, {5, 0, 0}});
  std::vector<KdTree::Neighbour> near;
  tree.nearest({0.9F, 0, 0}, 7, near);
  REQUIRE(near.size() == 3);
  REQUIRE(near[0].index == 1);
  REQUIRE(near[2].distance == Approx(4.1));
  tree.nearest({0, 0, 0}, 2, near, [](int) { return false; });
  REQUIRE(near.empty());
  const KdTree empty({});
  empty.nearest({0, 0, 0}, 2, near);
  REQUIRE(near.empty());
  REQUIRE(empty.nearest({0, 0, 0}).index == -1);
}
