// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// What of the estimator is chosen and not derived: one set of values for all sequences and robots. Units are in the names, the rest are counts and ratios; the
// keys of section `vio` are the members' names (procs/vio/README.md).

#include "core/base/config.h"

namespace covey::vio {

struct VioOptions {
  // The smoother's window.
  int window = 10;                       // keyframes
  int landmarks = 90;                    // seen from the newest keyframe, at most
  int iterations = 4;                    // of Levenberg-Marquardt per keyframe
  double keyframe_interval_s = 0.25;     // at the latest
  double keyframe_min_interval_s = 0.1;  // at the earliest
  double keyframe_parallax = 0.06;  // on the plane z = 1, median since the last keyframe, rotation taken out
  double keyframe_overlap = 0.6;    // share of the last keyframe's landmarks that are still seen
  double robust_width = 2.0;        // of the Huber kernel of image coordinates, in sigmas
  double gate = 8.0;                // sigmas beyond which an image coordinate is not used
  // How wrong views are, for covariances (core/graph/reduced.h; measured in DECISIONS.md). Of one track: the variance of a coordinate against the front end's, the
  // share of it that lasts, and how long.
  double view_variance = 0.8;
  double view_lasting = 0.9;
  double view_memory_s = 0.9;
  // All together: as if the camera stood off by this share of the way through the window.
  double way_share = 0.0042;

  // Keyframes for the team: when one of these is reached.
  double team_distance_m = 0.5;
  double team_angle_deg = 15.0;
  double team_interval_s = 1.0;
  // Their relative poses are at least this uncertain, per axis, and by this share of the angle turned: what a calibration and the tracking of turning
  // pictures are off by is not in the images' noise.
  double team_sigma_m = 0.00025;
  double team_sigma_deg = 0.005;
  double team_turn_share = 0.002;

  // Start and end of a segment.
  double start_s = 0.7;       // of images that a segment starts from
  double mono_start_s = 2.0;  // with one camera
  int min_tracks = 8;         // that agree with the map; with fewer the IMU is on its own
  double coast_s = 3.0;       // on its own for longer: a new segment
  double imu_gap_s = 0.6;     // without samples and pictures for longer: a new segment
  double imu_bridge_s = 2.0;  // without samples, but with pictures, for longer: a new segment
};

VioOptions read_vio_options(ConfigSection& section);

}  // namespace covey::vio
