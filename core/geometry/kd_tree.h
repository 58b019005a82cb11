// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The points nearest to a place: a k-d tree over points that are given once.
//
//   const KdTree tree(points);
//   std::vector<KdTree::Neighbour> near;
//   tree.nearest(p, 4, near);                                         // nearest first; fewer where there are fewer
//   tree.nearest(p, 4, near, [&](int index) { return used[index]; });  // among those that the filter accepts

#include <Eigen/Core>
#include <functional>
#include <memory>
#include <vector>

namespace covey {

class KdTree {
 public:
  struct Neighbour {
    int index = -1;
    double distance = 0.0;
  };
  using Filter = std::function<bool(int index)>;

  explicit KdTree(std::vector<Eigen::Vector3f> points);
  ~KdTree();
  KdTree(KdTree&&) noexcept;
  KdTree& operator=(KdTree&&) noexcept;

  std::size_t size() const;
  const Eigen::Vector3f& point(int index) const;

  void nearest(const Eigen::Vector3f& p, int k, std::vector<Neighbour>& neighbours,
               const Filter& accepts = {}) const;
  Neighbour nearest(const Eigen::Vector3f& p) const;  // index -1 where there are no points

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace covey
