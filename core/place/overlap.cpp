// SPDX-License-Identifier: BSD-3-Clause
#include "core/place/overlap.h"

#include <Eigen/Geometry>

namespace covey::place {
namespace {

constexpr double kNearest = 0.3;  // m in front of a camera

using Box = Eigen::AlignedBox2d;

// Features are spread over the picture, so that they fill it.
Box picture_of(const FrameFeatures& features) {
  Box box;
  for (std::size_t k = 0; k < features.size(); ++k) box.extend(features.direction(k));
  return box;
}

bool is_there(const FrameFeatures& features, const Eigen::Vector2d& m, const Descriptor& descriptor,
              double direction, int bits) {
  for (std::size_t k = 0; k < features.size(); ++k) {
    if ((features.direction(k) - m).squaredNorm() > direction * direction) continue;
    if (hamming(features.descriptors[k], descriptor) <= bits) return true;
  }
  return false;
}

void look(const FrameFeatures& from, const FrameFeatures& into, const SE3& T_into_from, double direction,
          int bits, Overlap& overlap) {
  const Box picture = picture_of(into);
  for (std::size_t k = 0; k < from.size(); ++k) {
    if (!from.has_depth(k)) continue;
    const Eigen::Vector3d p = T_into_from * from.point(k);
    if (p.z() < kNearest || !picture.contains(p.hnormalized())) continue;
    ++overlap.foretold;
    if (is_there(into, p.hnormalized(), from.descriptors[k], direction, bits)) ++overlap.found;
  }
}

}  // namespace

Overlap overlap_of(const FrameFeatures& c, const FrameFeatures& d, const SE3& T_C_D, double direction,
                   int bits) {
  Overlap overlap;
  look(c, d, T_C_D.inverse(), direction, bits, overlap);
  look(d, c, T_C_D, direction, bits, overlap);
  return overlap;
}

}  // namespace covey::place
