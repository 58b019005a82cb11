// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// What one robot knows of the team's pose graph: its own keyframes, chained by odometry within each segment, and the loop
// closures that have one of them at an end. Covariances are kept as they come; the precisions that decide what is an outlier
// follow from them by edge_noise.h.
//
// A GraphSnapshot is the part that a round can use: the segments, loops with both ends among them (private), and loops
// with the own end among them and the other at another robot (shared). A loop is named by a hash of its ends and its
// measurement, which is the same at both robots; the snapshot's hash changes with every keyframe and usable loop.

#include <compare>
#include <cstdint>
#include <map>
#include <set>
#include <vector>

#include "core/base/time.h"
#include "core/geometry/se3.h"
#include "core/pgo/edge_noise.h"

namespace covey::pgo {

struct KeyframeName {
  int robot = 0;
  Utime segment = 0;
  int id = 0;
  auto operator<=>(const KeyframeName&) const = default;
};

struct Keyframe {
  KeyframeName name;
  Utime utime = 0;
  SE3 T_O_K;
  SE3 T_P_K;                               // from the keyframe before; not used for id 0
  Matrix6d covariance = Matrix6d::Zero();  // of T_P_K, [rho; phi]; not used for id 0
  Gravity gravity{};
};

struct Loop {
  KeyframeName a;
  KeyframeName b;
  SE3 T_A_B;
  Matrix6d covariance = Matrix6d::Identity();
};

struct OdometryPose {
  Utime utime = 0;
  SE3 T_O_K;
  SE3 T_P_K;
  Precision precision;
  Matrix6d covariance = Matrix6d::Zero();  // of T_P_K as measured; zero: not known
  Gravity gravity{};
};

struct Segment {
  Utime name = 0;
  std::vector<OdometryPose> poses;
};

struct GraphLoop {
  std::uint64_t key = 0;
  KeyframeName a;
  KeyframeName b;
  SE3 T_A_B;
  Precision precision;
  bool known_inlier = false;               // its weight stays 1
  Matrix6d covariance = Matrix6d::Zero();  // of T_A_B as measured; zero: not known
};

struct GraphSnapshot {
  int robot = 0;
  std::vector<Segment> segments;                       // ascending by name, none empty
  std::vector<GraphLoop> private_loops;                // ascending by key, as the following
  std::map<int, std::vector<GraphLoop>> shared_loops;  // by the other robot
  std::uint64_t hash = 0;

  int poses() const;
  int loops() const;
};

class RobotGraph {
 public:
  explicit RobotGraph(int robot, const NoiseOptions& noise = {}) : robot_(robot), noise_(noise) {}

  // Null when taken, else why not: "robot", "duplicate", "gap", "values" (not finite, beyond any
  // measure, not a rotation, not positive).
  const char* add(const Keyframe& keyframe);
  const char* add(const Loop& loop);

  GraphSnapshot snapshot() const;

 private:
  int robot_;
  NoiseOptions noise_;
  std::map<Utime, std::vector<OdometryPose>> segments_;
  std::map<std::uint64_t, GraphLoop> loops_;
};

}  // namespace covey::pgo
