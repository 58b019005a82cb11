// SPDX-License-Identifier: BSD-3-Clause
#include "core/geometry/kd_tree.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <nanoflann.hpp>
#include <utility>

namespace covey {
namespace {

// What nanoflann asks of a set of points.
struct Cloud {
  std::vector<Eigen::Vector3f> points;

  std::size_t kdtree_get_point_count() const { return points.size(); }
  float kdtree_get_pt(std::size_t index, std::size_t axis) const {
    return points[index][static_cast<int>(axis)];
  }
  template <typename Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};

using Index =
    nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<float, Cloud>, Cloud, 3, std::uint32_t>;

// The k nearest so far among those that the filter accepts, in the form that nanoflann fills.
class FilteredResult {
 public:
  using DistanceType = float;
  using IndexType = std::uint32_t;

  FilteredResult(std::size_t k, std::vector<KdTree::Neighbour>& neighbours, const KdTree::Filter& accepts)
      : k_(k), neighbours_(neighbours), accepts_(accepts) {
    neighbours_.clear();
  }

  std::size_t size() const { return neighbours_.size(); }
  bool full() const { return neighbours_.size() == k_; }
  float worstDist() const {  // NOLINT(readability-identifier-naming): nanoflann's name
    return full() ? worst_ : std::numeric_limits<float>::max();
  }
  bool addPoint(float squared, std::uint32_t index) {  // NOLINT(readability-identifier-naming)
    const KdTree::Neighbour neighbour{static_cast<int>(index), squared};
    if (full() && !is_nearer(neighbour, neighbours_.back())) return true;
    if (accepts_ && !accepts_(neighbour.index)) return true;
    if (full()) neighbours_.pop_back();
    neighbours_.insert(std::upper_bound(neighbours_.begin(), neighbours_.end(), neighbour, is_nearer),
                       neighbour);
    worst_ = static_cast<float>(neighbours_.back().distance);
    return true;
  }

 private:
  static bool is_nearer(const KdTree::Neighbour& a, const KdTree::Neighbour& b) {
    return a.distance < b.distance || (a.distance == b.distance && a.index < b.index);
  }

  std::size_t k_;
  std::vector<KdTree::Neighbour>& neighbours_;  // distance holds the square until the search has ended
  const KdTree::Filter& accepts_;
  float worst_ = 0.0F;
};

}  // namespace

struct KdTree::Impl {
  explicit Impl(std::vector<Eigen::Vector3f> points)
      : cloud{std::move(points)}, index(3, cloud, nanoflann::KDTreeSingleIndexAdaptorParams(10)) {
    index.buildIndex();
  }

  Cloud cloud;
  Index index;
};

KdTree::KdTree(std::vector<Eigen::Vector3f> points) : impl_(std::make_unique<Impl>(std::move(points))) {}
KdTree::~KdTree() = default;
KdTree::KdTree(KdTree&&) noexcept = default;
KdTree& KdTree::operator=(KdTree&&) noexcept = default;

std::size_t KdTree::size() const { return impl_->cloud.points.size(); }

const Eigen::Vector3f& KdTree::point(int index) const { return impl_->cloud.points[index]; }

void KdTree::nearest(const Eigen::Vector3f& p, int k, std::vector<Neighbour>& neighbours,
                     const Filter& accepts) const {
  FilteredResult result(static_cast<std::size_t>(k), neighbours, accepts);
  if (k <= 0 || size() == 0) return;
  impl_->index.findNeighbors(result, p.data(), nanoflann::SearchParams());
  for (Neighbour& neighbour : neighbours) neighbour.distance = std::sqrt(neighbour.distance);
}

KdTree::Neighbour KdTree::nearest(const Eigen::Vector3f& p) const {
  if (size() == 0) return {};
  nanoflann::KNNResultSet<float, std::uint32_t> result(1);
  std::uint32_t index = 0;
  float squared = 0.0F;
  result.init(&index, &squared);
  impl_->index.findNeighbors(result, p.data(), nanoflann::SearchParams());
  return {static_cast<int>(index), std::sqrt(static_cast<double>(squared))};
}

}  // namespace covey
