// SPDX-License-Identifier: BSD-3-Clause
#include "core/vision/stereo_matcher.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace covey {
namespace {

constexpr int kPatchRadius = 4;
constexpr int kPatchSide = 2 * kPatchRadius + 1;
constexpr int kSearchLevel = 1;

using Patch = std::array<float, static_cast<std::size_t>(kPatchSide) * kPatchSide>;  // of mean 0 and norm 1

cv::Point at_search_level(const cv::Point2f& pixel) {
  return {static_cast<int>(std::lround(pixel.x / 2.0F)), static_cast<int>(std::lround(pixel.y / 2.0F))};
}

// Nothing at the picture's edge and where it is flat.
bool read_patch(const cv::Mat& picture, const cv::Point& centre, Patch& patch) {
  constexpr float kLeastNorm = 10.0F;  // grey values: about 1 per pixel
  if (centre.x < kPatchRadius || centre.y < kPatchRadius || centre.x + kPatchRadius >= picture.cols ||
      centre.y + kPatchRadius >= picture.rows) {
    return false;
  }
  std::size_t i = 0;
  float sum = 0.0F;
  for (int y = -kPatchRadius; y <= kPatchRadius; ++y) {
    const auto* row = picture.ptr<unsigned char>(centre.y + y) + centre.x - kPatchRadius;
    for (int x = 0; x < kPatchSide; ++x) {
      patch[i] = row[x];
      sum += patch[i++];
    }
  }
  const float mean = sum / static_cast<float>(patch.size());
  float squares = 0.0F;
  for (float& value : patch) {
    value -= mean;
    squares += value * value;
  }
  const float norm = std::sqrt(squares);
  if (norm < kLeastNorm) return false;
  for (float& value : patch) value /= norm;
  return true;
}

float correlation(const Patch& a, const Patch& b) {
  float sum = 0.0F;
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
  return sum;
}

}  // namespace

StereoMatcher::StereoMatcher(const MountedCamera& left, const MountedCamera& right,
                             const StereoOptions& options)
    : right_(right.camera), T_right_left_(right.T_B_C.inverse() * left.T_B_C), options_(options) {}

std::vector<std::optional<StereoMatch>> StereoMatcher::match(const ImagePyramid& left,
                                                             const ImagePyramid& right,
                                                             const std::vector<StereoQuery>& queries,
                                                             const FlowOptions& flow) const {
  std::vector<std::size_t> asked;
  std::vector<cv::Point2f> points;
  std::vector<cv::Point2f> start;
  for (std::size_t i = 0; i < queries.size(); ++i) {
    const StereoQuery& query = queries[i];
    const auto begin =
        query.inverse_depth ? expect(query.m, *query.inverse_depth) : search(left, right, query);
    if (!begin) continue;
    asked.push_back(i);
    points.push_back(query.pixel);
    start.push_back(*begin);
  }
  const auto found = track_points(left, right, points, start, options_.refine_levels, flow);
  std::vector<std::optional<StereoMatch>> matches(queries.size());
  for (std::size_t i = 0; i < asked.size(); ++i) {
    if (found[i]) matches[asked[i]] = accept(left, right, queries[asked[i]], *found[i]);
  }
  return matches;
}

// In pixels of the right picture.
std::optional<cv::Point2f> StereoMatcher::expect(const Eigen::Vector2d& m, double inverse_depth) const {
  const Eigen::Vector3d q =
      T_right_left_.rotation * m.homogeneous() + inverse_depth * T_right_left_.translation;
  const auto pixel = right_.project(q);
  if (!pixel || !right_.contains(*pixel)) return std::nullopt;
  return cv::Point2f(static_cast<float>(pixel->x()), static_cast<float>(pixel->y()));
}

std::optional<cv::Point2f> StereoMatcher::search(const ImagePyramid& left, const ImagePyramid& right,
                                                 const StereoQuery& query) const {
  Patch wanted;
  if (!read_patch(left.picture(kSearchLevel), at_search_level(query.pixel), wanted)) return std::nullopt;
  // One step is one pixel at half resolution, about.
  const double step = 2.0 / (right_.fx * baseline_m());
  const int steps = static_cast<int>(1.0 / (options_.nearest_m * step)) + 1;
  constexpr int kBehindInfinity = 1;
  constexpr int kApart = 3;  // steps between two places
  constexpr float kNone = -1.0F;
  std::vector<float> scores;
  scores.reserve(static_cast<std::size_t>(steps + kBehindInfinity) + 1);
  for (int i = -kBehindInfinity; i <= steps; ++i) {
    const auto pixel = expect(query.m, i * step);
    Patch seen;
    const bool readable = pixel && read_patch(right.picture(kSearchLevel), at_search_level(*pixel), seen);
    scores.push_back(readable ? correlation(wanted, seen) : kNone);
  }
  const auto best = std::max_element(scores.begin(), scores.end());
  if (*best < options_.min_correlation) return std::nullopt;
  const auto best_index = static_cast<int>(best - scores.begin());
  for (int i = 0; i < static_cast<int>(scores.size()); ++i) {
    if (std::abs(i - best_index) < kApart) continue;
    if (scores[static_cast<std::size_t>(i)] > *best - options_.min_margin) return std::nullopt;
  }
  return expect(query.m, (best_index - kBehindInfinity) * step);
}

std::optional<StereoMatch> StereoMatcher::accept(const ImagePyramid& left, const ImagePyramid& right,
                                                 const StereoQuery& query, const cv::Point2f& found) const {
  const auto m = right_.undistort({found.x, found.y});
  if (!m) return std::nullopt;
  // With a = R m_l~ and the unknown r: m (a_z + r t_z) = a_xy + r t_xy, two equations; r from least squares, what is left is
  // the distance from the epipolar line.
  const Eigen::Vector3d a = T_right_left_.rotation * query.m.homogeneous();
  const Eigen::Vector3d& t = T_right_left_.translation;
  const Eigen::Vector2d direction = t.head<2>() - *m * t.z();
  const Eigen::Vector2d offset = *m * a.z() - a.head<2>();
  const double inverse_depth = direction.dot(offset) / direction.squaredNorm();
  const double depth_ratio = a.z() + inverse_depth * t.z();  // z on the right over z on the left
  const double miss_px = right_.fx * (inverse_depth * direction - offset).norm() / depth_ratio;
  const double disparity_px = right_.fx * baseline_m() * inverse_depth;
  if (!(depth_ratio > 0.0) || miss_px > options_.epipolar_px || disparity_px < -options_.infinity_px ||
      inverse_depth * options_.nearest_m > 1.0) {
    return std::nullopt;
  }
  Patch wanted;
  Patch seen;
  if (!read_patch(left.picture(kSearchLevel), at_search_level(query.pixel), wanted) ||
      !read_patch(right.picture(kSearchLevel), at_search_level(found), seen) ||
      correlation(wanted, seen) < options_.min_correlation) {
    return std::nullopt;
  }
  return StereoMatch{*m, inverse_depth};
}

}  // namespace covey
