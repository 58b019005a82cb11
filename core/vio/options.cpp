// SPDX-License-Identifier: BSD-3-Clause
#include "core/vio/options.h"

namespace covey::vio {

VioOptions read_vio_options(ConfigSection& section) {
  VioOptions options;
  section.read("window", options.window, 4, 40);
  section.read("landmarks", options.landmarks, 20, 400);
  section.read("iterations", options.iterations, 1, 50);
  section.read("keyframe_interval_s", options.keyframe_interval_s, 0.02, 1.0);
  section.read("keyframe_min_interval_s", options.keyframe_min_interval_s, 0.0, 1.0);
  section.read("keyframe_parallax", options.keyframe_parallax, 0.0, 1.0);
  section.read("keyframe_overlap", options.keyframe_overlap, 0.0, 1.0);
  section.read("robust_width", options.robust_width, 0.1, 100.0);
  section.read("gate", options.gate, 1.0, 100.0);
  section.read("view_variance", options.view_variance, 0.0, 1000.0);
  section.read("view_lasting", options.view_lasting, 0.0, 1.0);
  section.read("view_memory_s", options.view_memory_s, 0.001, 1000.0);
  section.read("way_share", options.way_share, 0.0, 1.0);
  section.read("team_distance_m", options.team_distance_m, 0.01, 100.0);
  section.read("team_angle_deg", options.team_angle_deg, 1.0, 180.0);
  section.read("team_interval_s", options.team_interval_s, 0.1, 60.0);
  section.read("team_sigma_m", options.team_sigma_m, 0.0, 1.0);
  section.read("team_sigma_deg", options.team_sigma_deg, 0.0, 10.0);
  section.read("team_turn_share", options.team_turn_share, 0.0, 1.0);
  section.read("start_s", options.start_s, 0.2, 10.0);
  section.read("mono_start_s", options.mono_start_s, 0.5, 10.0);
  section.read("min_tracks", options.min_tracks, 4, 100);
  section.read("coast_s", options.coast_s, 0.0, 60.0);
  section.read("imu_gap_s", options.imu_gap_s, 0.005, 10.0);
  section.read("imu_bridge_s", options.imu_bridge_s, 0.0, 60.0);
  return options;
}

}  // namespace covey::vio
