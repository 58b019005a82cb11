// SPDX-License-Identifier: BSD-3-Clause
#include "core/place/row_matcher.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <opencv2/core/hal/intrin.hpp>
#include <optional>

namespace covey::place {
namespace {

constexpr int kWidth = 16;  // of the patch; constant, so that a row is one instruction
constexpr int kHalfWidth = kWidth / 2;
constexpr int kHalfHeight = 5;
constexpr int kPixels = kWidth * (2 * kHalfHeight + 1);

// Of the patches round (x, y) and (u, y); only some of it where that is more than `most` already.
int difference(const cv::Mat& left, const cv::Mat& right, int x, int u, int y, int most) {
  int sum = 0;
  const std::uint8_t* a = left.ptr<std::uint8_t>(y - kHalfHeight) + x - kHalfWidth;
  const std::uint8_t* b = right.ptr<std::uint8_t>(y - kHalfHeight) + u - kHalfWidth;
  for (int row = 0; row <= 2 * kHalfHeight && sum <= most; ++row, a += left.step[0], b += right.step[0])
    sum += static_cast<int>(cv::v_reduce_sad(cv::v_load(a), cv::v_load(b)));
  return sum;
}

struct Range {
  int least;
  int most;
};

// cost(d, most): as above. Nothing where the best is not good and alone; what is worse than `hopeless` is neither the best nor near it, whatever
// comes after it.
template <typename Cost>
std::optional<double> best_disparity(const Cost& cost, Range range, const RowMatchOptions& options,
                                     std::vector<int>& costs) {
  int hopeless = static_cast<int>(options.most_difference * kPixels / options.uniqueness);
  costs.clear();
  for (int d = range.least; d <= range.most; ++d) {
    costs.push_back(cost(d, hopeless));
    hopeless = std::min(hopeless, static_cast<int>(costs.back() / options.uniqueness));
  }
  if (costs.size() < 3) return std::nullopt;
  const auto best = static_cast<std::size_t>(std::min_element(costs.begin(), costs.end()) - costs.begin());
  if (best == 0 || best + 1 == costs.size()) return std::nullopt;
  if (costs[best] > options.most_difference * kPixels) return std::nullopt;
  for (std::size_t k = 0; k < costs.size(); ++k) {
    const std::size_t away = k > best ? k - best : best - k;
    if (away > 2 && costs[best] > options.uniqueness * costs[k]) return std::nullopt;
  }
  const int there = range.least + static_cast<int>(best);
  const double before = cost(there - 1, std::numeric_limits<int>::max());
  const double after = cost(there + 1, std::numeric_limits<int>::max());
  const double rise = std::max(before, after) - costs[best];
  const double fraction = rise > 0.0 ? 0.5 * (before - after) / rise : 0.0;
  return there + fraction;
}

}  // namespace

std::vector<float> match_rows(const cv::Mat& left, const cv::Mat& right,
                              const std::vector<cv::Point2f>& points, const RowMatchOptions& options) {
  std::vector<float> disparities(points.size(), 0.0F);
  std::vector<int> costs;
  for (std::size_t k = 0; k < points.size(); ++k) {
    const int x = static_cast<int>(std::lround(points[k].x));
    const int y = static_cast<int>(std::lround(points[k].y));
    if (y < kHalfHeight || y + kHalfHeight >= left.rows) continue;
    if (x < kHalfWidth || x + kHalfWidth > left.cols) continue;
    const Range range{static_cast<int>(std::floor(options.least_px)) - 1,
                      std::min(x - kHalfWidth, static_cast<int>(std::ceil(options.most_px)))};
    if (x - range.least + kHalfWidth > left.cols) continue;
    const auto forth = [&](int d, int most) { return difference(left, right, x, x - d, y, most); };
    const auto there = best_disparity(forth, range, options, costs);
    if (!there || *there < options.least_px) continue;

    const int u = x - static_cast<int>(std::lround(*there));
    const Range back{range.least, std::min(range.most, left.cols - kHalfWidth - u)};
    if (u + back.least < kHalfWidth) continue;
    const auto found_again = [&](int d, int most) { return difference(left, right, u + d, u, y, most); };
    const auto again = best_disparity(found_again, back, options, costs);
    if (again && std::abs(*again - *there) < 1.5) disparities[k] = static_cast<float>(*there);
  }
  return disparities;
}

}  // namespace covey::place
