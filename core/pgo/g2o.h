// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The text format of g2o, gzipped or not, as far as pose graphs use it: VERTEX_SE2, EDGE_SE2, VERTEX_SE3:QUAT,
// EDGE_SE3:QUAT.
// FIX is ignored, since the gauge is ours to choose; other tags are ignored and counted.
//
// Vertices are renumbered 0, 1, ... in the order of their ids; ids may have gaps. The edges from each pose to
// the next are the odometry (known inliers), all others are loops; doubled edges are kept. Precisions come
// from the information matrix by CONVENTIONS.md, Pose-graph cost.
//
// Refused, as InputError with file and line: a tag with the wrong number of fields, what is not a finite
// number, a quaternion that is not of norm 1 within 1 %, an information matrix whose translation or rotation
// block is not positive definite (cross terms are ignored), an edge from a vertex to itself or to one that
// the file does not declare (when it declares any), a vertex declared twice, 2D and 3D in one file, a file
// without edges.

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/pgo/pose_graph.h"

namespace covey::pgo {

struct G2oFile {
  PoseGraph graph;                          // of one robot
  std::vector<long> ids;                    // per pose: its id in the file
  std::optional<Poses> start;               // the VERTEX poses, if the file has one for every pose
  std::map<std::string, int> unknown_tags;  // how often each ignored tag stands in the file
};
G2oFile read_g2o(const std::filesystem::path& file);

// One file for all robots, poses numbered by their flat index. Information matrices are isotropic: tau I and
// 2 kappa I in 3D, kappa in 2D, so that reading returns the same kappa and tau. Without poses no VERTEX lines
// are written.
void write_g2o(const std::filesystem::path& file, const PoseGraph& graph,
               const std::optional<Poses>& poses = {});

}  // namespace covey::pgo
