// SPDX-License-Identifier: BSD-3-Clause
#include "core/mesh/marching_cubes.h"

#include <algorithm>
#include <cmath>

#include "core/mesh/cube_cases.h"

namespace covey::mesh {
namespace {

constexpr int kLatticeSide = kBlockSide + 1;  // a block's voxels and the first of its neighbours
constexpr int kLattice = kLatticeSide * kLatticeSide * kLatticeSide;
// Vertices keep off the voxels themselves, so that no triangle shrinks to nothing: 0.5 mm at voxels of 5 cm.
constexpr float kClearance = 0.01F;

constexpr int lattice_number(int i, int j, int k) { return (k * kLatticeSide + j) * kLatticeSide + i; }

constexpr int corner_offset(int corner) {
  return lattice_number(corner & 1, corner >> 1 & 1, corner >> 2 & 1);
}

// The voxels that a block's cells have as corners.
class Lattice {
 public:
  Lattice(const TsdfVolume& volume, const Block& block) {
    std::array<const Block*, 8> blocks;
    for (int n = 0; n < 8; ++n) {
      blocks[static_cast<std::size_t>(n)] =
          n == 0 ? &block
                 : volume.find(
                       {block.index.x + (n & 1), block.index.y + (n >> 1 & 1), block.index.z + (n >> 2)});
    }
    constexpr int kLow = kBlockSide - 1;  // as a mask
    for (int k = 0; k < kLatticeSide; ++k) {
      for (int j = 0; j < kLatticeSide; ++j) {
        for (int i = 0; i < kLatticeSide; ++i) {
          const auto at = static_cast<std::size_t>(lattice_number(i, j, k));
          const int n = (i / kBlockSide) | (j / kBlockSide) << 1 | (k / kBlockSide) << 2;
          blocks_[at] = blocks[static_cast<std::size_t>(n)];
          numbers_[at] = voxel_number(i & kLow, j & kLow, k & kLow);
          voxels_[at] = blocks_[at] ? blocks_[at]->voxels[static_cast<std::size_t>(numbers_[at])] : Voxel{};
        }
      }
    }
  }

  const Voxel& voxel(int at) const { return voxels_[static_cast<std::size_t>(at)]; }
  const SurfaceVoxel* surface(int at) const {
    const Block* block = blocks_[static_cast<std::size_t>(at)];
    if (!block || !block->surface) return nullptr;
    return &(*block->surface)[static_cast<std::size_t>(numbers_[static_cast<std::size_t>(at)])];
  }

 private:
  std::array<Voxel, kLattice> voxels_;
  std::array<const Block*, kLattice> blocks_;
  std::array<int, kLattice> numbers_;
};

// -1 where the cell has no surface.
int case_of(const Lattice& lattice, int lowest, float least_weight, float most_jump_m) {
  int cube_case = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const Voxel& voxel = lattice.voxel(lowest + corner_offset(corner));
    if (voxel.weight < least_weight) return -1;
    if (voxel.distance < 0.0F) cube_case |= 1 << corner;
  }
  if (cube_case == 0 || cube_case == 255) return -1;
  for (int edge = 0; edge < kCubeEdges; ++edge) {
    const auto [low, high] = edge_corners(edge);
    const float jump = lattice.voxel(lowest + corner_offset(low)).distance -
                       lattice.voxel(lowest + corner_offset(high)).distance;
    if (std::abs(jump) > most_jump_m) return -1;
  }
  return cube_case;
}

std::uint8_t label_of(const SurfaceVoxel& voxel, const SurfaceOptions& options) {
  const std::uint8_t label = voxel.labels.likeliest();
  if (label == kUnknownLabel) return label;
  return voxel.labels.posterior(label, options.labels) > options.least_posterior ? label : kUnknownLabel;
}

// What is said of a vertex besides its place: from the nearer voxel, or the other where that one has not been seen near a surface.
void append_attributes(mesh_block_t& block, const SurfaceVoxel* nearer, const SurfaceVoxel* other,
                       const SurfaceOptions& options) {
  static const SurfaceVoxel kNone;
  if (!nearer) nearer = other ? other : &kNone;
  if (!other) other = nearer;
  const std::uint8_t label = label_of(*nearer, options);
  block.labels.push_back(label == kUnknownLabel ? label_of(*other, options) : label);
  const SurfaceVoxel& coloured = nearer->colours > 0 ? *nearer : *other;
  for (const std::uint16_t channel : coloured.colour)
    block.colours.push_back(static_cast<std::uint8_t>(channel >> 8));
  block.keyframes.push_back(std::max(nearer->keyframe, other->keyframe));
}

class BlockSurface {
 public:
  BlockSurface(const TsdfVolume& volume, const Block& block, const SurfaceOptions& options)
      : lattice_(volume, block),
        options_(options),
        voxel_m_(static_cast<float>(volume.options().voxel_m)),
        origin_(block.index.x * kBlockSide, block.index.y * kBlockSide, block.index.z * kBlockSide) {
    vertex_on_.fill(-1);
  }

  void extract(mesh_block_t& out) {
    const auto least_weight = static_cast<float>(options_.least_weight);
    const float most_jump_m = static_cast<float>(options_.most_jump_voxels) * voxel_m_;
    for (int k = 0; k < kBlockSide; ++k) {
      for (int j = 0; j < kBlockSide; ++j) {
        for (int i = 0; i < kBlockSide; ++i) {
          const int lowest = lattice_number(i, j, k);
          const int cube_case = case_of(lattice_, lowest, least_weight, most_jump_m);
          if (cube_case < 0) continue;
          for (const CubeTriangle& triangle : cube_triangles(cube_case)) {
            for (const std::uint8_t edge : triangle) out.corners.push_back(vertex(lowest, edge, out));
          }
        }
      }
    }
  }

 private:
  int vertex(int lowest, int edge, mesh_block_t& out) {
    const auto [low_corner, high_corner] = edge_corners(edge);
    const int low = lowest + corner_offset(low_corner);
    const int axis = edge / 4;
    int& known = vertex_on_[static_cast<std::size_t>(3 * low + axis)];
    if (known >= 0) return known;
    known = static_cast<int>(out.labels.size());
    const int high = lowest + corner_offset(high_corner);
    const float d_low = lattice_.voxel(low).distance;
    const float t =
        std::clamp(d_low / (d_low - lattice_.voxel(high).distance), kClearance, 1.0F - kClearance);
    const Eigen::Vector3i at(low % kLatticeSide, low / kLatticeSide % kLatticeSide,
                             low / (kLatticeSide * kLatticeSide));
    Eigen::Vector3f p_O = (origin_ + at).cast<float>();
    p_O[axis] += t;
    p_O *= voxel_m_;
    out.p_O.insert(out.p_O.end(), {p_O.x(), p_O.y(), p_O.z()});
    const SurfaceVoxel* of_low = lattice_.surface(low);
    const SurfaceVoxel* of_high = lattice_.surface(high);
    if (t < 0.5F) {
      append_attributes(out, of_low, of_high, options_);
    } else {
      append_attributes(out, of_high, of_low, options_);
    }
    return known;
  }

  Lattice lattice_;
  const SurfaceOptions& options_;
  float voxel_m_;
  Eigen::Vector3i origin_;
  std::array<int, 3 * kLattice> vertex_on_;
};

}  // namespace

void read_surface(ConfigSection& section, SurfaceOptions& options) {
  section.read("least_weight", options.least_weight, 1e-6, 1e3);
  section.read("most_jump_voxels", options.most_jump_voxels, 1.0, 8.0);
  section.read("least_posterior", options.least_posterior, 0.0, 1.0);
  section.read("label_accuracy", options.labels.accuracy, 0.05, 0.999);
  section.read("classes", options.labels.classes, 2, 255);
}

mesh_block_t extract_block(const TsdfVolume& volume, const BlockIndex& index, const SurfaceOptions& options) {
  mesh_block_t out{};
  out.x = index.x;
  out.y = index.y;
  out.z = index.z;
  if (const Block* block = volume.find(index)) {
    out.utime = block->utime;
    BlockSurface(volume, *block, options).extract(out);
  }
  out.n_vertices = static_cast<std::int32_t>(out.labels.size());
  out.n_values = static_cast<std::int32_t>(out.p_O.size());
  out.n_corners = static_cast<std::int32_t>(out.corners.size());
  return out;
}

std::vector<BlockIndex> blocks_to_extract(const TsdfVolume& volume, const std::vector<BlockIndex>& changed) {
  std::vector<BlockIndex> indices;
  indices.reserve(8 * changed.size());
  for (const BlockIndex& index : changed) {
    for (int n = 0; n < 8; ++n) {
      indices.push_back({index.x - (n & 1), index.y - (n >> 1 & 1), index.z - (n >> 2)});
    }
  }
  std::sort(indices.begin(), indices.end());
  indices.erase(std::unique(indices.begin(), indices.end()), indices.end());
  std::erase_if(indices, [&volume](const BlockIndex& index) { return !volume.find(index); });
  return indices;
}

}  // namespace covey::mesh
