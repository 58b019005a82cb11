// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// One optimisation of a robot's mesh in pieces of a fraction of a second, so that a process can listen in between:
// simplification, each step of the solver, and the blending of some 50,000 vertices at a time. At its end faces that were torn
// are left out: where the surface of one pass ends in that of another, there was never anything between them.

#include <optional>

#include "core/mesh/deformation.h"
#include "core/mesh/robot_mesh.h"

namespace covey::mesh {

// A face is torn where its longest edge has become longer than this many times and that much more than what it was.
struct TearOptions {
  double factor = 2.0;
  double beyond_m = 0.05;
};

// The faces that are not torn, with vertices that were at p_O and are at p_W.
std::vector<Face> whole_faces(const MeasuredMesh& mesh, std::span<const Eigen::Vector3f> p_W,
                              const TearOptions& options = {});

class MeshJob {
 public:
  MeshJob(MeshSnapshot snapshot, const DeformationOptions& options);

  // One piece; false when all is done.
  bool advance();

  const MeshSnapshot& snapshot() const { return snapshot_; }
  // Once it is done: where the vertices are, and how many faces the snapshot has no more.
  const std::vector<Eigen::Vector3f>& moved() const { return p_W_; }
  int torn() const { return torn_; }
  const Deformation* deformation() const { return deformation_ ? &*deformation_ : nullptr; }

 private:
  enum class Stage { kSimplify, kSolve, kMove, kDone };

  void move_some();
  void cut();

  MeshSnapshot snapshot_;
  DeformationOptions options_;
  Stage stage_ = Stage::kSimplify;
  std::optional<Deformation> deformation_;
  std::vector<Eigen::Vector3f> p_W_;
  std::size_t next_ = 0;
  int torn_ = 0;
};

}  // namespace covey::mesh
