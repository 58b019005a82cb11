// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// What dpgo says after a round, for tests of its readers.

#include <Eigen/Core>
#include <covey/loop_weights_t.hpp>
#include <covey/trajectory_t.hpp>
#include <vector>

#include "core/base/time.h"

namespace covey::viewer {

constexpr Utime kSegment = 1'000'000;

// One keyframe per point, ids from `first_id` on; identity rotations.
inline trajectory_t trajectory_part(int robot, Utime utime, const std::vector<Eigen::Vector3d>& points_W,
                                    int part = 0, int parts = 1, int first_id = 0) {
  trajectory_t message{};
  message.utime = utime;
  message.robot = robot;
  message.part = part;
  message.parts = parts;
  for (const Eigen::Vector3d& p : points_W) {
    message.segments.push_back(kSegment);
    message.ids.push_back(first_id + message.n);
    message.utimes.push_back(kSegment);
    message.T_W_K.insert(message.T_W_K.end(), {1.0, 0.0, 0.0, 0.0, p.x(), p.y(), p.z()});
    ++message.n;
  }
  message.n_values = 7 * message.n;
  return message;
}

struct SaidLoop {
  int robot_a;
  int id_a;
  int robot_b;
  int id_b;
  double weight;
};

inline loop_weights_t weights_part(int robot, Utime utime, const std::vector<SaidLoop>& loops) {
  loop_weights_t message{};
  message.utime = utime;
  message.robot = robot;
  message.parts = 1;
  for (const SaidLoop& loop : loops) {
    message.robots_a.push_back(loop.robot_a);
    message.segments_a.push_back(kSegment);
    message.ids_a.push_back(loop.id_a);
    message.robots_b.push_back(loop.robot_b);
    message.segments_b.push_back(kSegment);
    message.ids_b.push_back(loop.id_b);
    message.weights.push_back(loop.weight);
    message.residuals_sq.push_back(0.0);
    ++message.n;
  }
  return message;
}

}  // namespace covey::viewer
