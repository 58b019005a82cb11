// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// A corridor along x, 3 m wide, with a floor and two walls, seen by keyframes that pass through it; and the same as odometry
// that drifts would have measured it. Drift is a motion of everything that a keyframe saw: T_O_K = D(t) T_W_K, and a vertex
// that was last seen at time t lies at D(t) p_W.

#include <cmath>
#include <functional>
#include <vector>

#include "core/mesh/measured_mesh.h"

namespace covey::testing {

using Drift = std::function<SE3(double seconds)>;

// Odometry that loses 1 % of the way and turns by 0.4 degrees per metre, as the robot drives on at 1 m/s: after 30 m it is 3 m
// aside and 12 degrees turned.
inline SE3 bend(double seconds) {
  const SE3 T_W_first{SO3{}, {0.0, 1.5, 1.0}};
  const SE3 T_W_now{SO3{}, {seconds, 1.5, 1.0}};
  Vector6d body_velocity;
  body_velocity << 0.99, 0.005, 0.02, 0.001, -0.002, 0.007;
  return T_W_first * SE3::exp(seconds * body_velocity) * T_W_now.inverse();
}

struct CorridorOptions {
  double length_m = 30.0;
  double step_m = 0.1;   // between vertices
  double start_s = 0.0;  // when the robot enters
  double back_m = 1.5;   // a vertex is last seen from so far before it
  Utime segment = 7;
};

struct Corridor {
  mesh::MeasuredMesh mesh;
  std::vector<mesh::PlacedKeyframe> keyframes;  // one every 0.5 m, at 1 m/s
  std::vector<Eigen::Vector3f> p_W;             // where the vertices truly are
};

inline double keyframe_seconds(int index) { return 0.5 * index; }

// Appends a passage; its keyframes and vertices come after those that are there.
inline void add_passage(Corridor& corridor, const Drift& drift, const CorridorOptions& options = {}) {
  const auto first_keyframe = static_cast<int>(corridor.keyframes.size());
  const int keyframes = static_cast<int>(options.length_m / 0.5) + 1;
  for (int k = 0; k < keyframes; ++k) {
    const double seconds = options.start_s + keyframe_seconds(k);
    const SE3 T_W_K{SO3{}, {0.5 * k, 1.5, 1.0}};
    corridor.keyframes.push_back({from_seconds(seconds), options.segment, k, drift(seconds) * T_W_K, T_W_K});
  }
  const int along = static_cast<int>(options.length_m / options.step_m);
  const std::vector<std::array<double, 2>> profile =
      [&] {  // y, z: down the left wall, over the floor, up the right wall
        std::vector<std::array<double, 2>> points;
        for (double z = 2.0; z > 0.0; z -= options.step_m) points.push_back({3.0, z});
        for (double y = 3.0; y > 0.0; y -= options.step_m) points.push_back({y, 0.0});
        for (double z = 0.0; z < 2.0; z += options.step_m) points.push_back({0.0, z});
        return points;
      }();
  const auto across = static_cast<int>(profile.size());
  const auto first_vertex = static_cast<std::uint32_t>(corridor.p_W.size());
  for (int i = 0; i <= along; ++i) {
    const double x = options.step_m * i;
    const int seen_by =
        std::clamp(static_cast<int>(std::lround((x - options.back_m) / 0.5)), 0, keyframes - 1);
    // Drift is smooth in the truth, though seen_by is not: a vertex is fused from what was seen before and after.
    const double seconds = options.start_s + std::clamp(x - options.back_m, 0.0, options.length_m);
    for (const auto& [y, z] : profile) {
      const Eigen::Vector3d p_W(x, y, z);
      corridor.p_W.push_back(p_W.cast<float>());
      corridor.mesh.p_O.push_back((drift(seconds) * p_W).cast<float>());
      corridor.mesh.seen_by.push_back(first_keyframe + seen_by);
    }
  }
  for (int i = 0; i < along; ++i) {
    for (int j = 0; j + 1 < across; ++j) {
      const std::uint32_t a = first_vertex + i * across + j;
      const std::uint32_t b = a + across;
      corridor.mesh.faces.push_back({a, a + 1, b});
      corridor.mesh.faces.push_back({b, a + 1, b + 1});
    }
  }
}

inline Corridor make_corridor(const Drift& drift, const CorridorOptions& options = {}) {
  Corridor corridor;
  add_passage(corridor, drift, options);
  return corridor;
}

struct Distances {
  double mean_m = 0.0;
  double max_m = 0.0;
};

inline Distances distances(const std::vector<Eigen::Vector3f>& a, const std::vector<Eigen::Vector3f>& b) {
  Distances result;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const double d = (a[i] - b[i]).cast<double>().norm();
    result.mean_m += d / static_cast<double>(a.size());
    result.max_m = std::max(result.max_m, d);
  }
  return result;
}

}  // namespace covey::testing
