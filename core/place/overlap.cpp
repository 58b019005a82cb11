// SPDX-License-Identifier: BSD-3-Clause
#include "core/place/overlap.h"

#include <Eigen/Geometry>
#include <cmath>

namespace covey::place {
namespace {

constexpr double kNearest = 0.3;  // m in front of a camera
constexpr int kBest = 150;  // points of a camera that are looked for: weaker ones often are not found again
constexpr double kAlike = 0.3;  // rad between two lines of sight; logarithm of the ratio of two distances

using Box = Eigen::AlignedBox2d;

// Features are spread over the picture, so that they fill it.
Box picture_of(const FrameFeatures& features) {
  Box box;
  for (std::size_t k = 0; k < features.size(); ++k) box.extend(features.direction(k));
  return box;
}

// A corner is found again, and described alike, where it is seen from the same side and as large.
bool looks_alike(const Eigen::Vector3d& sight, const Eigen::Vector3d& other) {
  const double near = sight.norm();
  const double far = other.norm();
  return std::abs(std::log(near / far)) < kAlike && sight.dot(other) > std::cos(kAlike) * near * far;
}

bool is_there(const FrameFeatures& features, const Eigen::Vector2d& m, const Descriptor& descriptor,
              double direction, int bits) {
  for (std::size_t k = 0; k < features.size(); ++k) {
    if ((features.direction(k) - m).squaredNorm() > direction * direction) continue;
    if (hamming(features.descriptors[k], descriptor) <= bits) return true;
  }
  return false;
}

// Next to the other, of which as many are detected.
bool is_whole(const FrameFeatures& features, const FrameFeatures& other) {
  return 2 * features.size() > other.size();
}

void look(const FrameFeatures& from, const FrameFeatures& into, const SE3& T_into_from, double direction,
          int bits, Overlap& overlap) {
  const Box picture = picture_of(into);
  int looked_for = 0;
  for (std::size_t k = 0; k < from.size() && looked_for < kBest; ++k) {
    if (!from.has_depth(k)) continue;
    ++looked_for;
    const Eigen::Vector3d p = T_into_from * from.point(k);
    if (p.z() < kNearest || !picture.contains(p.hnormalized())) continue;
    if (!looks_alike(p - T_into_from.translation, p)) continue;
    ++overlap.foretold;
    if (is_there(into, p.hnormalized(), from.descriptors[k], direction, bits)) ++overlap.found;
  }
}

}  // namespace

Overlap overlap_of(const FrameFeatures& c, const FrameFeatures& d, const SE3& T_C_D, double direction,
                   int bits) {
  Overlap overlap;
  if (is_whole(d, c)) look(c, d, T_C_D.inverse(), direction, bits, overlap);
  if (is_whole(c, d)) look(d, c, T_C_D, direction, bits, overlap);
  return overlap;
}

}  // namespace covey::place
