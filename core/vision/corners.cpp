// SPDX-License-Identifier: BSD-3-Clause
#include "core/vision/corners.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>

namespace covey {
namespace {

constexpr int kBlock = 5;  // pixels over which gradients are summed

struct Corner {
  cv::Point2f pixel;
  float response = 0.0F;
};

bool is_free(const cv::Point2f& pixel, const std::vector<cv::Point2f>& taken, double distance) {
  return std::all_of(taken.begin(), taken.end(), [&](const cv::Point2f& other) {
    const cv::Point2f d = pixel - other;
    return d.dot(d) >= distance * distance;
  });
}

// Local maxima of the response within a cell, strongest first.
std::vector<Corner> corners_in(const cv::Mat& image, const cv::Rect& cell, double min_response) {
  constexpr int kMargin = kBlock / 2 + 2;
  const cv::Rect wide =
      cv::Rect(cell.x - kMargin, cell.y - kMargin, cell.width + 2 * kMargin, cell.height + 2 * kMargin) &
      cv::Rect(0, 0, image.cols, image.rows);
  cv::Mat response;
  cv::cornerMinEigenVal(image(wide), response, kBlock, 3);
  std::vector<Corner> corners;
  const cv::Point offset = cell.tl() - wide.tl();
  for (int y = 0; y < cell.height; ++y) {
    const int row = y + offset.y;
    if (row < 1 || row + 1 >= response.rows) continue;
    const auto* above = response.ptr<float>(row - 1);
    const auto* here = response.ptr<float>(row);
    const auto* below = response.ptr<float>(row + 1);
    for (int x = 0; x < cell.width; ++x) {
      const int c = x + offset.x;
      if (c < 1 || c + 1 >= response.cols) continue;
      const float value = here[c];
      if (value < min_response || value < here[c - 1] || value <= here[c + 1]) continue;
      if (value < *std::max_element(above + c - 1, above + c + 2)) continue;
      if (value <= *std::max_element(below + c - 1, below + c + 2)) continue;
      corners.push_back({cv::Point2f(static_cast<float>(cell.x + x), static_cast<float>(cell.y + y)), value});
    }
  }
  std::stable_sort(corners.begin(), corners.end(),
                   [](const Corner& a, const Corner& b) { return a.response > b.response; });
  return corners;
}

}  // namespace

std::vector<cv::Point2f> detect_corners(const cv::Mat& image, const std::vector<cv::Point2f>& present,
                                        const CornerOptions& options) {
  const cv::Rect inner(options.border_px, options.border_px, image.cols - 2 * options.border_px,
                       image.rows - 2 * options.border_px);
  if (inner.width < options.columns || inner.height < options.rows) return {};
  std::vector<cv::Point2f> taken = present;
  std::vector<Corner> found;
  for (int row = 0; row < options.rows; ++row) {
    for (int column = 0; column < options.columns; ++column) {
      const cv::Point from(inner.x + column * inner.width / options.columns,
                           inner.y + row * inner.height / options.rows);
      const cv::Point to(inner.x + (column + 1) * inner.width / options.columns,
                         inner.y + (row + 1) * inner.height / options.rows);
      const cv::Rect cell(from, to);
      const auto inside = [&](const cv::Point2f& p) { return cell.contains(cv::Point(p)); };
      auto wanted = options.per_cell - std::count_if(present.begin(), present.end(), inside);
      if (wanted <= 0) continue;
      for (const Corner& corner : corners_in(image, cell, options.min_response)) {
        if (!is_free(corner.pixel, taken, options.min_distance_px)) continue;
        taken.push_back(corner.pixel);
        found.push_back(corner);
        if (--wanted == 0) break;
      }
    }
  }
  std::stable_sort(found.begin(), found.end(),
                   [](const Corner& a, const Corner& b) { return a.response > b.response; });
  found.resize(std::min(found.size(), static_cast<std::size_t>(options.most)));
  std::vector<cv::Point2f> corners;
  for (const Corner& corner : found) corners.push_back(corner.pixel);
  return corners;
}

}  // namespace covey
