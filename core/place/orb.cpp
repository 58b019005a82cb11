// SPDX-License-Identifier: BSD-3-Clause
#include "core/place/orb.h"

#include <algorithm>
#include <numeric>
#include <opencv2/features2d.hpp>

namespace covey::place {
namespace {

constexpr int kSurplus = 10;  // corners detected for each that is kept

// Strongest first, equal ones by place: the detector's order is not promised.
bool goes_before(const cv::KeyPoint& a, const cv::KeyPoint& b) {
  if (a.response != b.response) return a.response > b.response;
  if (a.pt.y != b.pt.y) return a.pt.y < b.pt.y;
  if (a.pt.x != b.pt.x) return a.pt.x < b.pt.x;
  return a.octave < b.octave;
}

// Round after round each cell gives its next strongest, of a round the strongest first, until there are enough.
std::vector<cv::KeyPoint> spread(std::vector<cv::KeyPoint> corners, cv::Size size,
                                 const OrbOptions& options) {
  std::sort(corners.begin(), corners.end(), goes_before);
  std::vector<std::vector<cv::KeyPoint>> cells(static_cast<std::size_t>(options.columns * options.rows));
  for (const cv::KeyPoint& corner : corners) {
    const int column =
        std::clamp(static_cast<int>(corner.pt.x * options.columns / size.width), 0, options.columns - 1);
    const int row =
        std::clamp(static_cast<int>(corner.pt.y * options.rows / size.height), 0, options.rows - 1);
    cells[static_cast<std::size_t>(row * options.columns + column)].push_back(corner);
  }
  const std::size_t wanted = std::min(corners.size(), static_cast<std::size_t>(options.features));
  std::vector<cv::KeyPoint> kept;
  for (std::size_t round = 0; kept.size() < wanted; ++round) {
    std::vector<cv::KeyPoint> next;
    for (const auto& cell : cells) {
      if (round < cell.size()) next.push_back(cell[round]);
    }
    std::sort(next.begin(), next.end(), goes_before);
    next.resize(std::min(next.size(), wanted - kept.size()));
    kept.insert(kept.end(), next.begin(), next.end());
  }
  return kept;
}

// OpenCV describes level by level and leaves out what it cannot describe.
void describe(cv::ORB& orb, const cv::Mat& image, std::vector<cv::KeyPoint> corners, OrbFeatures& features) {
  for (std::size_t k = 0; k < corners.size(); ++k) corners[k].class_id = static_cast<int>(k);
  cv::Mat descriptors;
  orb.compute(image, corners, descriptors);
  std::vector<int> order(corners.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&corners](int a, int b) {
    return corners[static_cast<std::size_t>(a)].class_id < corners[static_cast<std::size_t>(b)].class_id;
  });
  for (const int row : order) {
    features.pixels.push_back(corners[static_cast<std::size_t>(row)].pt);
    features.descriptors.push_back(descriptor_from(descriptors.ptr<std::uint8_t>(row)));
  }
}

}  // namespace

OrbFeatures detect_orb(const cv::Mat& image, const OrbOptions& options, const cv::Mat& mask) {
  const auto orb =
      cv::ORB::create(kSurplus * options.features, static_cast<float>(options.scale), options.levels, 31, 0,
                      2, cv::ORB::HARRIS_SCORE, 31, options.fast_threshold);
  std::vector<cv::KeyPoint> corners;
  orb->detect(image, corners, mask);
  OrbFeatures features;
  describe(*orb, image, spread(std::move(corners), image.size(), options), features);
  return features;
}

}  // namespace covey::place
