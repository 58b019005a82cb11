// SPDX-License-Identifier: BSD-3-Clause
#include "core/place/point_code.h"

#include <algorithm>
#include <cmath>

#include "core/place/naturals.h"

namespace covey::place {
namespace {

constexpr double kUnitsPerSigma = 4.0;
constexpr double kWidest = 100.0;  // of a direction: 89.4 deg off the axis
constexpr double kFarthestPointM = 1e4;

struct PointModels {
  pgo::NumberModel direction[2];
  pgo::NumberModel inverse_depth;
};

std::int32_t in_units(double value, double unit, std::int32_t least, std::int32_t most) {
  return static_cast<std::int32_t>(std::clamp<double>(std::round(value / unit), least, most));
}

}  // namespace

std::vector<std::uint8_t> encode_points(const FrameFeatures& features) {
  const double direction_unit = features.noise.direction / kUnitsPerSigma;
  const double depth_unit = features.noise.inverse_depth / kUnitsPerSigma;
  pgo::RangeWriter writer;
  PointModels models;
  for (std::size_t k = 0; k < features.size(); ++k) {
    const Eigen::Vector2d direction = features.direction(k);
    for (int c = 0; c < 2; ++c) {
      writer.put(in_units(direction[c], direction_unit, -pgo::kLargestCoded, pgo::kLargestCoded),
                 models.direction[c]);
    }
    const double inverse = 1.0 / static_cast<double>(features.depths_m[k]);
    put_natural(writer, features.has_depth(k) ? in_units(inverse, depth_unit, 1, kLargestNatural) : 0,
                models.inverse_depth);
  }
  return writer.finish();
}

const char* decode_points(const std::vector<std::uint8_t>& code, int n, FrameFeatures& features) {
  const double direction_unit = features.noise.direction / kUnitsPerSigma;
  const double depth_unit = features.noise.inverse_depth / kUnitsPerSigma;
  pgo::RangeReader reader(code);
  PointModels models;
  for (int k = 0; k < n; ++k) {
    Eigen::Vector2d direction;
    for (int c = 0; c < 2; ++c) direction[c] = direction_unit * reader.get(models.direction[c]);
    const std::int32_t inverse = get_natural(reader, models.inverse_depth);
    const double depth = inverse > 0 ? 1.0 / (depth_unit * inverse) : 0.0;
    if (!(direction.norm() < kWidest)) return "bearings";
    if (!(depth < kFarthestPointM)) return "depths";
    features.bearings_C.emplace_back(direction.homogeneous().normalized().cast<float>());
    features.depths_m.push_back(static_cast<float>(depth));
  }
  return reader.ended_well() ? nullptr : "code";
}

}  // namespace covey::place
