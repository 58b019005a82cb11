// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The plane that touches the surface at each pixel of a depth image.
//
// With m = (mx, my, 1), z = 1 of a pixel's ray, a plane n . p = d gives 1/z = (n . m) / d: inverse depth is affine in the pixel's
// coordinates, however steeply the plane is seen. So with a = n / d,
//
//   d(1/z)/dmx = ax,   d(1/z)/dmy = ay,   az = 1/z - ax mx - ay my,   and a point's distance to the plane is (1 - a . p) / |a|,
//
// positive on the camera's side. That is the distance along the normal: the usual one along the ray is too large by one over the cosine
// of the angle of incidence, so that a street that is seen at grazing angles would pass for free space from one voxel to the next.
//
// The plane is the least-squares one of the pixel and up to three symmetric pairs of neighbours in each direction, which takes noise of the
// single pixel down to a third. A pair counts where the depths bend from it to the pixel by less than a tolerance: at depth discontinuities it does not, and where no pair does the plane is taken as facing the
// image. A pixel that hangs in the air between what is on both sides of it (a mixture at a silhouette) has no plane.

#include <Eigen/Core>
#include <covey/depth_t.hpp>
#include <vector>

#include "core/geometry/rig.h"

namespace covey::mesh {

struct PlaneOptions {
  float bend_m = 0.2F;     // tolerance, and three sigmas of noise on top of it
  float noise_m = 0.002F;  // sigma of a depth of 1 m; it grows with the square of depth, as stereo's does
};

struct TangentPlane {
  Eigen::Vector3f a = Eigen::Vector3f::Zero();  // 1/m, in the depth camera's frame
  float distance = 0.0F;                        // 1 / |a|: of the plane from the camera, m; 0: no plane here
};

// Row by row. COVEY_CHECK: the image has the camera's size.
class TangentPlanes {
 public:
  void compute(const depth_t& image, const DepthCamera& camera, const PlaneOptions& options = {});

  const TangentPlane& at(int u, int v) const { return planes_[static_cast<std::size_t>(v * width_ + u)]; }
  const Eigen::Vector3f& point(int u, int v) const {
    return points_[static_cast<std::size_t>(v * width_ + u)];
  }
  float farthest_m() const { return farthest_m_; }

 private:
  int width_ = 0;
  float farthest_m_ = 0.0F;
  std::vector<float> inverse_depth_;
  std::vector<TangentPlane> planes_;
  std::vector<Eigen::Vector3f> points_;
};

}  // namespace covey::mesh
