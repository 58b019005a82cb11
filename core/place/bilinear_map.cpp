// SPDX-License-Identifier: BSD-3-Clause
#include "core/place/bilinear_map.h"

#include <bit>
#include <cmath>
#include <cstring>

#include "core/base/error.h"

namespace covey::place {
namespace {

constexpr int kParts = 32;  // of a pixel
static_assert(std::endian::native == std::endian::little, "the lower half of a pair is the left pixel");

// A pixel and its right neighbour, in the lower and the upper half.
std::uint32_t pair_at(const std::uint8_t* pixel) {
  std::uint16_t both = 0;
  std::memcpy(&both, pixel, sizeof(both));
  return (both & 0xFFU) | (both & 0xFF00U) << 8;
}

}  // namespace

BilinearMap::BilinearMap(const cv::Mat& u, const cv::Mat& v, cv::Size from) : from_(from), to_(u.size()) {
  const auto is_small = [](int step) { return step == static_cast<std::int8_t>(step); };
  for (int row = 0; row < to_.height; ++row) {
    cv::Point last;
    bool is_open = false;
    for (int column = 0; column < to_.width; ++column) {
      const cv::Point here(cvRound(u.at<float>(row, column) * kParts),
                           cvRound(v.at<float>(row, column) * kParts));
      if (here.x < 0 || here.y < 0 || here.x >= (from.width - 1) * kParts ||
          here.y >= (from.height - 1) * kParts) {
        is_open = false;
        continue;
      }
      const cv::Point step = here - last - cv::Point(kParts, 0);
      if (is_open && is_small(step.x) && is_small(step.y)) {
        steps_.back() = {static_cast<std::int8_t>(step.x), static_cast<std::int8_t>(step.y)};
      } else {
        spans_.push_back({row, column, 0, here.x, here.y});
        is_open = true;
      }
      ++spans_.back().length;
      steps_.push_back({});
      last = here;
    }
  }
}

cv::Mat BilinearMap::apply(const cv::Mat& image) const {
  COVEY_CHECK(image.size() == from_ && image.type() == CV_8U);
  cv::Mat drawn = cv::Mat::zeros(to_, CV_8U);
  const std::uint8_t* pixels = image.ptr<std::uint8_t>();
  const std::size_t stride = image.step[0];
  const Step* step = steps_.data();
  for (const Span& span : spans_) {
    std::uint8_t* out = drawn.ptr<std::uint8_t>(span.row) + span.column;
    auto x = static_cast<std::uint32_t>(span.x);
    auto y = static_cast<std::uint32_t>(span.y);
    for (int k = 0; k < span.length; ++k, ++step) {
      const std::uint8_t* at = pixels + y / kParts * stride + x / kParts;
      const std::uint32_t right = x % kParts;
      const std::uint32_t down = y % kParts;
      // a + (b - a) part: downwards for both columns at once (a half holds 255 * 32), then to the right.
      const std::uint32_t top = pair_at(at);
      const std::uint32_t both = top * kParts + (pair_at(at + stride) - top) * down;
      const std::uint32_t left = both & 0xFFFFU;
      const std::uint32_t sum = left * kParts + ((both >> 16) - left) * right;
      out[k] = static_cast<std::uint8_t>((sum + kParts * kParts / 2) / (kParts * kParts));
      x += static_cast<std::uint32_t>(kParts + step->x);
      y += static_cast<std::uint32_t>(step->y);
    }
  }
  return drawn;
}

}  // namespace covey::place
