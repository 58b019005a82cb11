// SPDX-License-Identifier: BSD-3-Clause
#include "core/vision/optical_flow.h"

#include <opencv2/video/tracking.hpp>

namespace covey {
namespace {

std::vector<cv::Point2f> flow(const ImagePyramid& from, const ImagePyramid& to,
                              const std::vector<cv::Point2f>& points, std::vector<cv::Point2f> start,
                              int levels, const FlowOptions& options, std::vector<unsigned char>& found) {
  cv::calcOpticalFlowPyrLK(from.levels, to.levels, points, start, found, cv::noArray(),
                           {options.window_px, options.window_px}, levels - 1,
                           cv::TermCriteria(cv::TermCriteria::COUNT | cv::TermCriteria::EPS,
                                            options.iterations, options.epsilon_px),
                           cv::OPTFLOW_USE_INITIAL_FLOW);
  return start;
}

}  // namespace

ImagePyramid build_pyramid(const cv::Mat& image, const FlowOptions& options) {
  ImagePyramid pyramid;
  cv::buildOpticalFlowPyramid(image, pyramid.levels, {options.window_px, options.window_px},
                              options.levels - 1, true, cv::BORDER_REFLECT_101, cv::BORDER_CONSTANT, false);
  return pyramid;
}

std::vector<std::optional<cv::Point2f>> track_points(const ImagePyramid& from, const ImagePyramid& to,
                                                     const std::vector<cv::Point2f>& points,
                                                     const std::vector<cv::Point2f>& start, int levels,
                                                     const FlowOptions& options) {
  std::vector<std::optional<cv::Point2f>> tracked(points.size());
  if (points.empty()) return tracked;
  std::vector<unsigned char> found;
  std::vector<unsigned char> returned;
  const auto there = flow(from, to, points, start, levels, options, found);
  const auto back = flow(to, from, there, points, 1, options, returned);
  const cv::Rect2f picture(0.0F, 0.0F, static_cast<float>(to.picture(0).cols - 1),
                           static_cast<float>(to.picture(0).rows - 1));
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (found[i] == 0 || returned[i] == 0 || !picture.contains(there[i])) continue;
    const cv::Point2f miss = back[i] - points[i];
    if (miss.dot(miss) <= options.return_px * options.return_px) tracked[i] = there[i];
  }
  return tracked;
}

}  // namespace covey
