// SPDX-License-Identifier: BSD-3-Clause
#include "core/place/descriptor_matcher.h"

#include <algorithm>
#include <opencv2/features2d.hpp>

namespace covey::place {
namespace {

// The descriptors' memory as OpenCV sees it; only read.
cv::Mat as_matrix(const std::vector<Descriptor>& descriptors) {
  return {static_cast<int>(descriptors.size()), static_cast<int>(kDescriptorBytes), CV_8U,
          const_cast<Descriptor*>(descriptors.data())};
}

}  // namespace

std::vector<std::pair<int, int>> match_descriptors(const std::vector<Descriptor>& a,
                                                   const std::vector<Descriptor>& b,
                                                   const MatchOptions& options) {
  std::vector<std::pair<int, int>> matches;
  if (a.size() < 2 || b.size() < 2) return matches;
  if (a.size() > b.size()) {
    for (const auto& [in_b, in_a] : match_descriptors(b, a, options)) matches.emplace_back(in_a, in_b);
    std::sort(matches.begin(), matches.end());
    return matches;
  }
  const cv::BFMatcher matcher(cv::NORM_HAMMING);
  std::vector<std::vector<cv::DMatch>> there;
  std::vector<std::vector<cv::DMatch>> back;
  matcher.knnMatch(as_matrix(a), as_matrix(b), there, 2);
  matcher.knnMatch(as_matrix(b), as_matrix(a), back, 1);
  for (const auto& nearest : there) {
    if (nearest.size() < 2 || nearest[0].distance > static_cast<float>(options.most_distance)) continue;
    if (nearest[0].distance > options.ratio * nearest[1].distance) continue;
    const auto& other = back[static_cast<std::size_t>(nearest[0].trainIdx)];
    if (other.empty() || other[0].trainIdx != nearest[0].queryIdx) continue;
    matches.emplace_back(nearest[0].queryIdx, nearest[0].trainIdx);
  }
  return matches;
}

}  // namespace covey::place
