// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// A truncated signed distance field in sparse blocks (Curless and Levoy, SIGGRAPH 1996), filled from depth images.
//
// Integration is projective: blocks are made where the image has surfaces, and every voxel of the blocks in view looks up the pixel that
// it projects to. Its distance is that to the pixel's tangent plane (tangent_planes.h), averaged with weight 1/z^2 of the measured depth,
// which falls linearly to zero behind the surface, from one voxel to the truncation. A ray that passes through by more than the truncation
// carves what was taken to be inside of something free, in the blocks that exist; to what is free already it says nothing. Labels, colours and keyframes are touched within `surface_voxels` of the surface
// only. Memory is bounded: where the blocks exceed it, those that were not seen for longest are forgotten; their meshes have been
// said and stay.
//
// Frame O everywhere; T_O_C is the pose of the depth camera. The same calls give the same bits.

#include <covey/depth_t.hpp>
#include <memory>
#include <unordered_map>
#include <vector>

#include "core/base/config.h"
#include "core/geometry/rig.h"
#include "core/geometry/se3.h"
#include "core/mesh/block.h"
#include "core/mesh/tangent_planes.h"

namespace covey::mesh {

struct TsdfOptions {
  double voxel_m = 0.1;
  double truncation_voxels = 4.0;
  double surface_voxels =
      2.0;  // labels and colours so near to a surface only; marching cubes reads no farther than 1
  double most_weight = 50.0;     // 1/m^2: what was seen long ago can still be changed
  double depth_noise_m = 0.002;  // sigma at 1 m; grows with the square of depth
  double memory_mb = 400.0;      // of blocks
};
void read_tsdf(ConfigSection& section, TsdfOptions& options);

struct Integration {
  int blocks_in_view = 0;
  int new_blocks = 0;
  int forgotten_blocks = 0;
  std::vector<BlockIndex> changed;  // blocks whose distances near a surface, labels or colours have changed
};

class TsdfVolume {
 public:
  explicit TsdfVolume(const TsdfOptions& options = {});

  Integration integrate(const depth_t& image, const DepthCamera& camera, const SE3& T_O_C, int keyframe);

  const Block* find(const BlockIndex& index) const;
  // In the order in which they were made (but for places of forgotten ones).
  const std::vector<std::unique_ptr<Block>>& blocks() const { return blocks_; }
  const TsdfOptions& options() const { return options_; }
  std::size_t bytes() const;

 private:
  struct View;

  void allocate(const View& view, Integration& result);
  Block& find_or_make(const BlockIndex& index, Integration& result);
  bool update(Block& block, const View& view);
  bool average_in(Voxel& voxel, float distance, float weight) const;
  void update_surface(Block& block, int number, const View& view, int pixel);
  void forget_oldest(Integration& result);

  TsdfOptions options_;
  float voxel_m_ = 0.0F;
  float truncation_m_ = 0.0F;
  std::vector<std::unique_ptr<Block>> blocks_;
  std::unordered_map<BlockIndex, Block*, BlockIndexHash> by_index_;
  std::size_t surfaces_ = 0;  // blocks with surface voxels
  TangentPlanes planes_;
};

}  // namespace covey::mesh
