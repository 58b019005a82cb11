// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// STEREO's images as OpenCV sees them.

#include <covey/stereo_t.hpp>
#include <opencv2/core.hpp>
#include <optional>

namespace covey {

struct StereoImages {
  cv::Mat left;   // grey; they look into the message and live as long as it does
  cv::Mat right;  // empty for a single camera
};

// None where the sizes do not agree with each other.
inline std::optional<StereoImages> images_of(const stereo_t& message) {
  const std::int64_t pixels = std::int64_t{message.width} * message.height;
  if (message.width <= 0 || message.height <= 0 || message.n_left != pixels) return std::nullopt;
  if (message.n_right != 0 && message.n_right != pixels) return std::nullopt;
  const auto image = [&message](const std::vector<std::uint8_t>& bytes) {
    return cv::Mat(message.height, message.width, CV_8U, const_cast<std::uint8_t*>(bytes.data()));
  };
  StereoImages images{image(message.left), {}};
  if (message.n_right != 0) images.right = image(message.right);
  return images;
}

}  // namespace covey
