// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Pose graphs of a team as one CSV file per robot, robot<i>.csv, with the header
//
//   robot_src,pose_src,robot_dst,pose_dst,qx,qy,qz,qw,tx,ty,tz,kappa,tau,is_known_inlier,weight
//
// as mit-acl/dpgo_ros writes them (3D; m; kappa in 1/rad^2, tau in 1/m^2). A robot's file holds the edges
// that touch the robot, so a loop between two robots stands in both files; it counts once. Copies are told by
// equal ends and equal measurement; the column `weight` is a solver's output and is not read.
//
// Edges from a pose to the next of the same robot that are known inliers are the odometry, the others are
// loops. A robot has as many poses as the largest index that any file names says.
//
// Refused, as InputError with file and line: another header, a line with the wrong number of fields, what is
// not a finite number, a quaternion that is not of norm 1 within 1 %, kappa or tau that is not positive, an
// edge from a pose to itself; a folder without robot<i>.csv; pose indices that make more than 10,000 poses and 100 for
// each edge, or more than 10 million.

#include <filesystem>
#include <optional>

#include "core/pgo/pose_graph.h"

namespace covey::pgo {

// One robot<i>.csv, or all those of a folder.
PoseGraph read_robot_csv(const std::filesystem::path& file_or_folder);

// Writes robot<i>.csv for each robot, or for one only, into the folder, which is created.
void write_robot_csv(const std::filesystem::path& folder, const PoseGraph& graph,
                     std::optional<int> only_robot = std::nullopt);

}  // namespace covey::pgo
