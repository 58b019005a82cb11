// SPDX-License-Identifier: BSD-3-Clause
#include "core/place/orb.h"

#include <algorithm>
#include <cmath>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>

#include "core/place/patch_measures.h"

namespace covey::place {
namespace {

constexpr int kSurplus = 10;  // corners looked for, for each that is kept
constexpr int kEdgePx = 31;   // of each level: what a turned descriptor sees
constexpr int kFastPx = 4;    // a corner's circle, and the neighbours that it must be stronger than
constexpr int kDescribedPx = 31;

struct Level {
  cv::Mat image;
  float scale = 1.0F;  // px of the full image
  int share = 0;       // of the corners that are looked for
};

struct Corner {
  cv::Point2f pixel;  // of the full image
  cv::Point at;       // of its level
  int level = 0;
  float strength = 0.0F;
};

// Strongest first, equal ones by place: the detector's order is not promised.
bool goes_before(const Corner& a, const Corner& b) {
  if (a.strength != b.strength) return a.strength > b.strength;
  if (a.pixel.y != b.pixel.y) return a.pixel.y < b.pixel.y;
  if (a.pixel.x != b.pixel.x) return a.pixel.x < b.pixel.x;
  return a.level < b.level;
}

// Each level has fewer corners than the one below by the ratio of their sides.
std::vector<Level> make_levels(const cv::Mat& image, const OrbOptions& options) {
  const auto ratio = static_cast<double>(static_cast<float>(options.scale));
  const auto shrink = static_cast<float>(1.0 / ratio);
  const double wanted = kSurplus * options.features;
  double share = wanted * (1.0F - shrink) / (1.0F - std::pow(shrink, options.levels));
  int left = kSurplus * options.features;
  std::vector<Level> levels;
  for (int k = 0; k < options.levels; ++k, share *= shrink) {
    Level level;
    level.scale = static_cast<float>(std::pow(ratio, k));
    level.share = k + 1 < options.levels ? cvRound(share) : std::max(left, 0);
    left -= level.share;
    const cv::Size size(cvRound(static_cast<float>(image.cols) / level.scale),
                        cvRound(static_cast<float>(image.rows) / level.scale));
    if (std::min(size.width, size.height) <= 2 * kEdgePx) break;
    if (k == 0) {
      level.image = image;
    } else {
      cv::resize(levels.back().image, level.image, size, 0, 0, cv::INTER_LINEAR_EXACT);
    }
    levels.push_back(std::move(level));
  }
  return levels;
}

void find_corners(const std::vector<Level>& levels, int number, const cv::Mat& mask,
                  const OrbOptions& options, std::vector<Corner>& corners) {
  const Level& level = levels[static_cast<std::size_t>(number)];
  const cv::Rect inner(kEdgePx, kEdgePx, level.image.cols - 2 * kEdgePx, level.image.rows - 2 * kEdgePx);
  const cv::Rect seen(inner.tl() - cv::Point(kFastPx, kFastPx),
                      inner.size() + cv::Size(2 * kFastPx, 2 * kFastPx));
  std::vector<cv::KeyPoint> found;
  cv::FAST(level.image(seen), found, options.fast_threshold, true);
  std::erase_if(found, [&](cv::KeyPoint& point) {
    point.pt += cv::Point2f(seen.tl());
    if (!inner.contains(point.pt)) return true;
    return !mask.empty() &&
           mask.at<std::uint8_t>(cvRound(point.pt.y * level.scale), cvRound(point.pt.x * level.scale)) == 0;
  });
  cv::KeyPointsFilter::retainBest(found, 2 * level.share);
  for (cv::KeyPoint& point : found)
    point.response = corner_strength(level.image, static_cast<int>(point.pt.x), static_cast<int>(point.pt.y));
  cv::KeyPointsFilter::retainBest(found, level.share);
  for (const cv::KeyPoint& point : found)
    corners.push_back({point.pt * level.scale, point.pt, number, point.response});
}

// Round after round each cell gives its next strongest, of a round the strongest first, until there are enough.
std::vector<Corner> spread(const std::vector<Corner>& corners, cv::Size size, const OrbOptions& options) {
  std::vector<std::vector<Corner>> cells(static_cast<std::size_t>(options.columns * options.rows));
  for (const Corner& corner : corners) {
    const int column =
        std::clamp(static_cast<int>(corner.pixel.x * options.columns / size.width), 0, options.columns - 1);
    const int row =
        std::clamp(static_cast<int>(corner.pixel.y * options.rows / size.height), 0, options.rows - 1);
    cells[static_cast<std::size_t>(row * options.columns + column)].push_back(corner);
  }
  for (auto& cell : cells) std::sort(cell.begin(), cell.end(), goes_before);
  const std::size_t wanted = std::min(corners.size(), static_cast<std::size_t>(options.features));
  std::vector<Corner> kept;
  for (std::size_t round = 0; kept.size() < wanted; ++round) {
    std::vector<Corner> next;
    for (const auto& cell : cells) {
      if (round < cell.size()) next.push_back(cell[round]);
    }
    std::sort(next.begin(), next.end(), goes_before);
    next.resize(std::min(next.size(), wanted - kept.size()));
    kept.insert(kept.end(), next.begin(), next.end());
  }
  return kept;
}

// OpenCV describes the corners of one level, as of a picture of its own.
void describe(const std::vector<Level>& levels, const std::vector<Corner>& corners, OrbFeatures& features) {
  const auto orb = cv::ORB::create(static_cast<int>(corners.size()), 1.2F, 1, kEdgePx, 0, 2,
                                   cv::ORB::HARRIS_SCORE, kDescribedPx);
  features.descriptors.resize(corners.size());
  for (std::size_t level = 0; level < levels.size(); ++level) {
    const cv::Mat& image = levels[level].image;
    std::vector<cv::KeyPoint> points;
    for (std::size_t k = 0; k < corners.size(); ++k) {
      const Corner& corner = corners[k];
      if (corner.level != static_cast<int>(level)) continue;
      const float angle_deg = orientation_deg(image, corner.at.x, corner.at.y);
      points.emplace_back(corner.at, kDescribedPx, angle_deg, corner.strength, 0, static_cast<int>(k));
    }
    if (points.empty()) continue;
    cv::Mat descriptors;
    orb->compute(image, points, descriptors);
    for (std::size_t row = 0; row < points.size(); ++row)
      features.descriptors[static_cast<std::size_t>(points[row].class_id)] =
          descriptor_from(descriptors.ptr<std::uint8_t>(static_cast<int>(row)));
  }
}

}  // namespace

OrbFeatures detect_orb(const cv::Mat& image, const OrbOptions& options, const cv::Mat& mask) {
  const std::vector<Level> levels = make_levels(image, options);
  std::vector<Corner> corners;
  for (int level = 0; level < static_cast<int>(levels.size()); ++level)
    find_corners(levels, level, mask, options, corners);
  const std::vector<Corner> kept = spread(corners, image.size(), options);
  OrbFeatures features;
  for (const Corner& corner : kept) features.pixels.push_back(corner.pixel);
  describe(levels, kept, features);
  return features;
}

}  // namespace covey::place
