// SPDX-License-Identifier: BSD-3-Clause
#include "core/eval/seen_surface.h"

#include <cmath>
#include <optional>

namespace covey {
namespace {

viewer::Camera camera_at(const SE3& T_W_B, const DepthCamera& mounted) {
  const PinholeCamera& lens = mounted.camera;
  viewer::Camera camera;
  camera.T_C_W = (T_W_B * mounted.T_B_C).inverse();
  camera.fx = lens.fx;
  camera.fy = lens.fy;
  camera.cx = lens.cx;
  camera.cy = lens.cy;
  camera.near = 0.02;
  camera.far = 2.0 * mounted.far_m;
  camera.width = lens.width;
  camera.height = lens.height;
  return camera;
}

bool differ(const SE3& a, const SE3& b, const SeenOptions& options) {
  const SE3 way = a.inverse() * b;
  return way.translation.norm() >= options.every_m || way.rotation.log().norm() >= options.every_rad;
}

void mark_seen(const std::vector<SurfacePoint>& points, const viewer::Camera& camera,
               const std::vector<float>& depth, const DepthCamera& mounted, const SeenOptions& options,
               std::vector<bool>& seen) {
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (seen[i]) continue;
    const Eigen::Vector3d p_C = camera.T_C_W * Eigen::Vector3d(points[i].p.cast<double>());
    if (p_C.z() < mounted.near_m || p_C.z() > mounted.far_m) continue;
    const long column = std::lround(camera.fx * p_C.x() / p_C.z() + camera.cx);
    const long row = std::lround(camera.fy * p_C.y() / p_C.z() + camera.cy);
    if (column < 0 || row < 0 || column >= camera.width || row >= camera.height) continue;
    const double drawn = depth[static_cast<std::size_t>(row * camera.width + column)];
    seen[i] = drawn > 0.0 && p_C.z() <= drawn + options.tolerance_m + 0.02 * drawn;
  }
}

}  // namespace

std::vector<bool> seen_points(viewer::Renderer& renderer, const viewer::Mesh& world,
                              const std::vector<SurfacePoint>& points, const std::vector<Trajectory>& ways,
                              const DepthCamera& camera, const SeenOptions& options) {
  viewer::Scene scene(renderer.context());
  scene.add(world);
  std::vector<bool> seen(points.size(), false);
  for (const Trajectory& way : ways) {
    std::optional<SE3> last;
    for (const StampedPose& stamped : way) {
      if (last && !differ(*last, stamped.pose, options)) continue;
      last = stamped.pose;
      const viewer::Camera view = camera_at(stamped.pose, camera);
      const viewer::Rendering drawn =
          renderer.render(scene, view, {.colour = false, .depth = true, .samples = 1});
      mark_seen(points, view, drawn.depth, camera, options, seen);
    }
  }
  return seen;
}

}  // namespace covey
