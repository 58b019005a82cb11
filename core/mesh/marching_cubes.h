// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The surface of one block of a volume, as the message that says it. A block has the cells whose lowest corner is one of its voxels; the
// other corners are partly its neighbours'. Vertices are shared inside the block; on borders the neighbour computes the same vertex from
// the same two voxels, to the last bit, so the blocks of an unchanging volume fit together without gaps.
//
// A cell needs all eight corners observed. Where the distance jumps by more than `most_jump_voxels` along an edge it has no surface: a
// distance field changes by no more than one voxel from one to the next, so that is the border of what was seen (free space beside the
// unseen back of something).

#include <covey/mesh_block_t.hpp>

#include "core/mesh/tsdf_volume.h"

namespace covey::mesh {

struct SurfaceOptions {
  double least_weight = 1e-3;  // 1/m^2, of a voxel that counts as observed
  double most_jump_voxels = 3.0;
  double least_posterior = 0.5;  // of a vertex's label; unknown below
  LabelModel labels;
};
void read_surface(ConfigSection& section, SurfaceOptions& options);

// Vertices, faces, block and utime; who says it (robot, segment, stream, number) is left to the caller. Empty where there is no block.
mesh_block_t extract_block(const TsdfVolume& volume, const BlockIndex& index, const SurfaceOptions& options);

// Of a changed block: itself, and the existing ones whose cells reach into it.
std::vector<BlockIndex> blocks_to_extract(const TsdfVolume& volume, const std::vector<BlockIndex>& changed);

}  // namespace covey::mesh
