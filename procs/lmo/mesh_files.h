// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The files of --mesh DIR, PLY with colours and labels (255: unknown), each replaced as a whole:
//
//   robot<r>_vio.ply   as odometry measured it, in O of the first segment that has a mesh
//   robot<r>_team.ply  deformed, in W

#include <filesystem>
#include <span>

#include "core/mesh/robot_mesh.h"

namespace covey {

class MeshFiles {
 public:
  MeshFiles(std::filesystem::path folder, int robot);  // InputError where the folder cannot be made

  // Failures are warned of: the next optimisation writes again.
  void write_odometry(const mesh::MeshSnapshot& snapshot) const;
  void write_team(const mesh::MeshSnapshot& snapshot, std::span<const Eigen::Vector3f> p_W) const;

 private:
  std::filesystem::path folder_;
  int robot_;
};

}  // namespace covey
