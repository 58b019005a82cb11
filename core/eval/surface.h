// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// A mesh as a surface that can be measured: points spread evenly over it, and for any place the nearest point of it.
//
// The nearest point is looked for on the triangles of the nearest 8 sites, and every triangle has a site: near the surface it is
// exact but for rare cases, far from it it may be too far by the spacing of the sites (0.1 m). So no figure depends on how densely the
// surface is sampled, as it would where points are compared with points.

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "core/geometry/kd_tree.h"
#include "viewer_offscreen/mesh.h"

namespace covey {

struct SurfacePoint {
  Eigen::Vector3f p = Eigen::Vector3f::Zero();
  std::uint32_t face = 0;
  std::uint16_t label = viewer::kNoLabel;  // of the corner that is nearest
};

struct NearestPoint {
  double distance_m = 0.0;
  SurfacePoint point;
};

class Surface {
 public:
  // COVEY_CHECK: the mesh has a face.
  explicit Surface(viewer::Mesh mesh, std::uint64_t seed = 1);

  const viewer::Mesh& mesh() const { return mesh_; }
  double area_m2() const { return area_m2_; }

  // One point for every 1 / per_m2 of area, at random places; the same each time.
  std::vector<SurfacePoint> sample(double per_m2) const;

  NearestPoint nearest(const Eigen::Vector3f& p) const;

 private:
  SurfacePoint point_on(std::uint32_t face, const Eigen::Vector3f& weights) const;
  std::vector<SurfacePoint> spread(double per_m2, bool on_every_face) const;
  Eigen::Vector3f nearest_weights(std::uint32_t face, const Eigen::Vector3f& p) const;

  viewer::Mesh mesh_;
  std::uint64_t seed_;
  double area_m2_ = 0.0;
  std::vector<std::uint32_t> face_of_site_;
  KdTree sites_;
};

}  // namespace covey
