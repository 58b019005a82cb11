// SPDX-License-Identifier: BSD-3-Clause
#include "core/place/row_matcher.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <optional>

namespace covey::place {
namespace {

constexpr int kWidth = 16;  // of the patch; constant, so that a row is one instruction
constexpr int kHalfWidth = kWidth / 2;
constexpr int kHalfHeight = 5;
constexpr int kPixels = kWidth * (2 * kHalfHeight + 1);

// Of the patches round (x, y) and (u, y).
int difference(const cv::Mat& left, const cv::Mat& right, int x, int u, int y) {
  int sum = 0;
  for (int row = y - kHalfHeight; row <= y + kHalfHeight; ++row) {
    const std::uint8_t* a = left.ptr<std::uint8_t>(row) + x - kHalfWidth;
    const std::uint8_t* b = right.ptr<std::uint8_t>(row) + u - kHalfWidth;
    for (int k = 0; k < kWidth; ++k) sum += std::abs(a[k] - b[k]);
  }
  return sum;
}

struct Range {
  int least;
  int most;
};

// costs[d - range.least] at disparity d: nothing where the best is not good and alone.
std::optional<double> best_disparity(const std::vector<int>& costs, Range range,
                                     const RowMatchOptions& options) {
  if (costs.size() < 3) return std::nullopt;
  const auto best = static_cast<std::size_t>(std::min_element(costs.begin(), costs.end()) - costs.begin());
  if (best == 0 || best + 1 == costs.size()) return std::nullopt;
  if (costs[best] > options.most_difference * kPixels) return std::nullopt;
  for (std::size_t k = 0; k < costs.size(); ++k) {
    const std::size_t away = k > best ? k - best : best - k;
    if (away > 2 && costs[best] > options.uniqueness * costs[k]) return std::nullopt;
  }
  const double before = costs[best - 1];
  const double after = costs[best + 1];
  const double rise = std::max(before, after) - costs[best];
  const double fraction = rise > 0.0 ? 0.5 * (before - after) / rise : 0.0;
  return range.least + static_cast<double>(best) + fraction;
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
    costs.clear();
    for (int d = range.least; d <= range.most; ++d) costs.push_back(difference(left, right, x, x - d, y));
    const auto there = best_disparity(costs, range, options);
    if (!there || *there < options.least_px) continue;

    const int u = x - static_cast<int>(std::lround(*there));
    const Range back{range.least, std::min(range.most, left.cols - kHalfWidth - u)};
    if (u + back.least < kHalfWidth) continue;
    costs.clear();
    for (int d = back.least; d <= back.most; ++d) costs.push_back(difference(left, right, u + d, u, y));
    const auto again = best_disparity(costs, back, options);
    if (again && std::abs(*again - *there) < 1.5) disparities[k] = static_cast<float>(*there);
  }
  return disparities;
}

}  // namespace covey::place
