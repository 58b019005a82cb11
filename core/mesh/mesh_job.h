// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// One optimisation of a robot's mesh in pieces of a fraction of a second, so that a process can listen in between:
// simplification, each step of the solver, and the blending of some 50,000 vertices at a time.

#include <optional>

#include "core/mesh/deformation.h"
#include "core/mesh/robot_mesh.h"

namespace covey::mesh {

class MeshJob {
 public:
  MeshJob(MeshSnapshot snapshot, const DeformationOptions& options);

  // One piece; false when all is done.
  bool advance();

  const MeshSnapshot& snapshot() const { return snapshot_; }
  const std::vector<Eigen::Vector3f>& moved() const { return p_W_; }  // by vertex, once it is done
  const Deformation* deformation() const { return deformation_ ? &*deformation_ : nullptr; }

 private:
  enum class Stage { kSimplify, kSolve, kMove, kDone };

  void move_some();

  MeshSnapshot snapshot_;
  DeformationOptions options_;
  Stage stage_ = Stage::kSimplify;
  std::optional<Deformation> deformation_;
  std::vector<Eigen::Vector3f> p_W_;
  std::size_t next_ = 0;
};

}  // namespace covey::mesh
