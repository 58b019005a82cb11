// SPDX-License-Identifier: BSD-3-Clause
#include "core/vision/optical_flow.h"

#include <cmath>
#include <opencv2/imgproc.hpp>
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

// Of the windows around two points, whatever their brightness and contrast.
double correlation(const cv::Mat& a, cv::Point2f at_a, const cv::Mat& b, cv::Point2f at_b, int window_px) {
  cv::Mat u;
  cv::Mat v;
  cv::getRectSubPix(a, {window_px, window_px}, at_a, u, CV_32F);
  cv::getRectSubPix(b, {window_px, window_px}, at_b, v, CV_32F);
  u -= cv::mean(u);
  v -= cv::mean(v);
  const double power = u.dot(u) * v.dot(v);
  return power > 0.0 ? u.dot(v) / std::sqrt(power) : 0.0;
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
    if (miss.dot(miss) > options.return_px * options.return_px) continue;
    if (correlation(from.picture(0), points[i], to.picture(0), there[i], options.window_px) >= options.alike)
      tracked[i] = there[i];
  }
  return tracked;
}

}  // namespace covey
