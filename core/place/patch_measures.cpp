// SPDX-License-Identifier: BSD-3-Clause
#include "core/place/patch_measures.h"

#include <array>
#include <cstdint>
#include <opencv2/core/hal/intrin.hpp>

namespace covey::place {
namespace {

constexpr int kWindow = 7;
constexpr int kRadius = kWindow / 2;
constexpr float kHarris = 0.04F;

// How far the disc of radius 15 reaches to either side, by row: round(sqrt(15^2 - row^2)), and the same mirrored where the circle is steep,
// so that the disc is its own mirror image along the diagonal too.
constexpr std::array<int, 16> kDisc{15, 15, 15, 15, 14, 14, 14, 13, 13, 12, 11, 10, 9, 8, 6, 3};

// Eight neighbouring pixels.
cv::v_int16x8 eight(const std::uint8_t* pixels) {
  return cv::v_reinterpret_as_s16(cv::v_load_expand(pixels));
}

}  // namespace

float corner_strength(const cv::Mat& image, int x, int y) {
  // One window's row is seven pixels: of the eight that a register holds the last does not count.
  const cv::v_int16x8 seven(-1, -1, -1, -1, -1, -1, -1, 0);
  std::array<cv::v_int16x8, kWindow + 2> across;  // right less left
  std::array<cv::v_int16x8, kWindow + 2> along;   // left, twice the middle, right
  for (int row = 0; row < kWindow + 2; ++row) {
    const std::uint8_t* from = image.ptr<std::uint8_t>(y - kRadius - 1 + row) + x - kRadius;
    const cv::v_int16x8 left = eight(from - 1);
    const cv::v_int16x8 middle = eight(from);
    const cv::v_int16x8 right = eight(from + 1);
    across[static_cast<std::size_t>(row)] = right - left;
    along[static_cast<std::size_t>(row)] = left + middle + middle + right;
  }
  cv::v_int32x4 xx = cv::v_setzero_s32();
  cv::v_int32x4 yy = cv::v_setzero_s32();
  cv::v_int32x4 xy = cv::v_setzero_s32();
  for (std::size_t row = 1; row + 1 < across.size(); ++row) {
    const cv::v_int16x8 dx = (across[row - 1] + across[row] + across[row] + across[row + 1]) & seven;
    const cv::v_int16x8 dy = (along[row + 1] - along[row - 1]) & seven;
    xx = cv::v_dotprod(dx, dx, xx);
    yy = cv::v_dotprod(dy, dy, yy);
    xy = cv::v_dotprod(dx, dy, xy);
  }
  const auto a = static_cast<float>(cv::v_reduce_sum(xx));
  const auto b = static_cast<float>(cv::v_reduce_sum(yy));
  const auto c = static_cast<float>(cv::v_reduce_sum(xy));
  constexpr float kScale = 1.0F / (4.0F * kWindow * 255.0F);
  return (a * b - c * c - kHarris * (a + b) * (a + b)) * (kScale * kScale * kScale * kScale);
}

float orientation_deg(const cv::Mat& image, int x, int y) {
  int along_x = 0;
  int along_y = 0;
  const std::uint8_t* middle = image.ptr<std::uint8_t>(y) + x;
  for (int column = 1; column <= kDisc[0]; ++column) along_x += column * (middle[column] - middle[-column]);
  for (int row = 1; row < static_cast<int>(kDisc.size()); ++row) {
    const std::uint8_t* above = image.ptr<std::uint8_t>(y - row) + x;
    const std::uint8_t* below = image.ptr<std::uint8_t>(y + row) + x;
    int down = 0;
    const int reach = kDisc[static_cast<std::size_t>(row)];
    for (int column = -reach; column <= reach; ++column) {
      along_x += column * (below[column] + above[column]);
      down += below[column] - above[column];
    }
    along_y += row * down;
  }
  return cv::fastAtan2(static_cast<float>(along_y), static_cast<float>(along_x));
}

}  // namespace covey::place
