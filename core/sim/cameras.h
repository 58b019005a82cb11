// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The cameras of a rig in a simulated world.
//
// Stereo: grey pictures as the lenses give them (radial-tangential or fisheye), with photon and read-out noise and, if so wished, vignette, wandering
// brightness and motion blur (exposure.h). An ideal pinhole view is drawn and then pulled through the lens.
// Depth: along the optical axis of an ideal pinhole, in mm, with the noise of stereo matching (sigma grows with z^2), without values
// nearer than near_m, beyond far_m and, often, where one thing hides another; classes of world.mesh.labels, some blocks of them wrong if
// so wished; colour. Labels and colour are registered to the depth's pixels.
//
// A frame depends on world, rig, options, pose and utime only: the same again gives the same bytes, in any order of calls. Belongs to
// one thread.

#include <covey/depth_t.hpp>
#include <covey/stereo_t.hpp>
#include <cstdint>
#include <memory>
#include <span>

#include "core/base/config.h"
#include "core/base/time.h"
#include "core/geometry/rig.h"
#include "core/geometry/se3.h"
#include "core/sim/exposure.h"
#include "core/sim/mesh_world.h"

namespace covey::sim {

struct CameraOptions {
  std::uint64_t seed = 1;

  double view_scale = 1.0;  // pixels of the ideal view to one of the camera's, at the middle of the picture
  int samples = 1;          // per pixel of the ideal view: 1 or 4
  double read_noise = 1.2;  // grey levels
  double shot_noise = 0.1;  // grey levels per square root of the grey level
  ExposureOptions exposure = {};

  double depth_noise_m = 0.002;     // sigma at 1 m; grows with the square of depth
  double depth_edge_dropout = 0.7;  // share of the pixels beside a jump in depth that have no value
  double wrong_labels = 0.0;        // share of label blocks that carry another class of this world
  bool labels = true;
  bool colours = true;
};

// Overwrites what the section has; the seed comes from the command line.
void read_cameras(ConfigSection& section, CameraOptions& options);

class SensorCameras {
 public:
  // InputError where a lens cannot be simulated; viewer::EglError where nothing can be drawn.
  SensorCameras(const MeshWorld& world, const Rig& rig, const CameraOptions& options = {});
  ~SensorCameras();

  // The right picture is empty where the rig has none.
  stereo_t stereo(const SE3& T_W_B, Utime utime) { return stereo(std::span(&T_W_B, 1), utime); }
  // Blurred over several poses, those at open_times.
  stereo_t stereo(std::span<const SE3> T_W_B, Utime utime);
  const CameraOptions& options() const;
  // The rig has a depth camera.
  depth_t depth(const SE3& T_W_B, Utime utime);

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace covey::sim
