// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// What a sparse volume is made of. Space is cut into blocks of 8 x 8 x 8 voxels; block (x, y, z) holds the voxels (8 x ... 8 x + 7, ...).
// A voxel is a point of the lattice: voxel (i, j, k) stands at p_O = size (i, j, k). Only blocks near a surface exist.
//
// A voxel's signed distance to the nearest surface is positive on the free side and cut off at the truncation. What only surfaces have
// (labels, colour, the keyframe that saw it last) stands apart, and only in blocks that a surface has been near.

#include <Eigen/Core>
#include <array>
#include <compare>
#include <cstdint>
#include <memory>

#include "core/base/time.h"
#include "core/mesh/label_votes.h"

namespace covey::mesh {

constexpr int kBlockSide = 8;
constexpr int kBlockVoxels = kBlockSide * kBlockSide * kBlockSide;

struct BlockIndex {
  std::int32_t x = 0;
  std::int32_t y = 0;
  std::int32_t z = 0;
  auto operator<=>(const BlockIndex&) const = default;
};

struct BlockIndexHash {
  std::size_t operator()(const BlockIndex& b) const {
    // Large primes (Teschner et al., "Optimized spatial hashing for collision detection of deformable objects", VMV 2003).
    return static_cast<std::size_t>(b.x) * 73856093U ^ static_cast<std::size_t>(b.y) * 19349663U ^
           static_cast<std::size_t>(b.z) * 83492791U;
  }
};

struct Voxel {
  float distance = 0.0F;  // m
  float weight = 0.0F;    // 0: never observed
};

struct SurfaceVoxel {
  LabelVotes labels;
  std::array<std::uint16_t, 3> colour = {};  // red, green, blue in 1/256
  std::uint16_t colours = 0;                 // observations in it
  std::int32_t keyframe = -1;                // newest that saw it
};

struct Block {
  BlockIndex index;
  std::array<Voxel, kBlockVoxels> voxels;
  std::unique_ptr<std::array<SurfaceVoxel, kBlockVoxels>> surface;  // empty: no surface was near
  Utime utime = 0;                                                  // of the newest image that it was in
};

constexpr int voxel_number(int i, int j, int k) { return (k * kBlockSide + j) * kBlockSide + i; }

}  // namespace covey::mesh
