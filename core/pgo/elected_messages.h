// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// What goes to the elected robot and comes back (elected.h), packed as tightly as it can be without losing accuracy that counts:
//
//   dpgo_graph_t  of every other robot: odometry with ids implied by the order, own loops, and loops with higher robots; those with
//                 the elected itself, the lowest, are known there. Six 32-bit floats for a measurement (three in the plane), two for
//                 its precisions, sent once where they are all alike; or 21 for its covariance, and four for a keyframe's gravity.
//   dpgo_poses_t  of the elected, once for all: six (three) floats for a pose, one bit for a loop.

#include <covey/dpgo_graph_t.hpp>
#include <covey/dpgo_poses_t.hpp>
#include <map>
#include <vector>

#include "core/pgo/robot_graph.h"

namespace covey::pgo {

// Of every member of the team: the names of its segments, ascending.
using SegmentNames = std::map<int, std::vector<Utime>>;

// A loop as its owner, the lower robot at its ends, counts it. Segments by their place in SegmentNames.
struct OwnedLoop {
  const GraphLoop* loop = nullptr;
  int robot_b = 0;
  int segment_a = 0;  // the owner's
  int segment_b = 0;
  bool reversed = false;  // the loop measures T_B_A
  int id_a = 0;
  int id_b = 0;
};
// The loops between the owner and one peer (or itself), in the order of dpgo_graph_t, which both ends know. Those with an end in
// no segment of `names` are left out.
std::vector<OwnedLoop> in_message_order(const std::vector<GraphLoop>& loops, int owner,
                                        const SegmentNames& names);

// What a robot sends; with precisions, or with covariances and gravity.
struct PackingOptions {
  int dimension = 3;  // 2: all poses are rigid motions in the plane z = 0
  bool full_covariances = false;
};
dpgo_graph_t part_of(const GraphSnapshot& graph, const SegmentNames& names, const PackingOptions& options);

// Rigid motions as floats.
int floats_per_pose(int dimension);
void append_floats(const SE3& T, int dimension, std::vector<float>& values);
SE3 pose_from_floats(const std::vector<float>& values, int k, int dimension);

// Of measurement k.
Precision precision_at(const dpgo_graph_t& message, int k);
Matrix6d covariance_at(const dpgo_graph_t& message, int k);
// Of the sender's keyframe k, counted over its segments.
Gravity gravity_at(const dpgo_graph_t& message, int k);

// A bit for each flag, the lowest first.
std::vector<std::int8_t> pack_bits(const std::vector<bool>& flags);
bool bit_at(const std::vector<std::int8_t>& bytes, int k);

// Whether a message is what its counts say, and finite. It may be empty.
bool values_are_good(const dpgo_graph_t& message);
bool values_are_good(const dpgo_poses_t& message);

}  // namespace covey::pgo
