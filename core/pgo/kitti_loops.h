// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Graphs with real wrong loops: the layout in which KITTI sequences come from ylatif/dataset-RobustSLAM, SE(2), gzipped.
//
//   kitti_SEQ_alpha_A.g2o.gz        odometry of a stereo camera, and loops as a place recogniser reported them at threshold A
//                                   (lower: more of them, and more of them wrong); edges only
//   kitti_SEQ_alpha_A_GT_LC.txt.gz  the true ones among these loops, one `from to` of vertex ids to a line
//   kitti_SEQ_GT.g2o.gz             ground truth, as the chain of motions from each pose to the next; edges only
//
// The wrong loops measure no motion at all (0 0 0). One information matrix, that of the odometry, stands on every edge.
// Source: Latif, Cadena, Neira, "Robust loop closing over time for pose graph SLAM", IJRR 2013.

#include <filesystem>
#include <vector>

#include "core/pgo/g2o.h"

namespace covey::pgo {

// Per edge of the graph: odometry, and the loops that the file lists. InputError with file and line where it lists what is no
// loop of the graph.
std::vector<bool> read_true_loops(const std::filesystem::path& file, const G2oFile& graph);

// The poses of a g2o file, by its vertices or, where it has none, by its edges, which then must be one chain; the first pose
// is identity. InputError where it is neither.
Poses read_truth(const std::filesystem::path& file);

}  // namespace covey::pgo
