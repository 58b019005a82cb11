// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// From depth images with poses to the blocks of a mesh that have changed: a volume for the current segment of odometry (another segment
// has another frame O; the last one's volume is closed, what it had left to say is said), and a schedule of what to say when. A block
// that comes out as it was said before is not said again, nor is an empty one that never was anything else.

#include <covey/mesh_block_t.hpp>
#include <cstdint>
#include <optional>
#include <unordered_map>
#include <vector>

#include "core/mesh/marching_cubes.h"
#include "core/mesh/mesh_schedule.h"
#include "core/mesh/tsdf_volume.h"

namespace covey::mesh {

struct MapperOptions {
  TsdfOptions tsdf;
  SurfaceOptions surface;
  ScheduleOptions schedule;
};
void read_mapper(ConfigSection& section, MapperOptions& options);

class Mapper {
 public:
  Mapper(const MapperOptions& options, const DepthCamera& camera) : options_(options), camera_(camera) {}

  // T_O_B: of the body; keyframe: newest of the segment, -1 for none yet. The image has the camera's size.
  Integration add(const depth_t& image, std::int64_t segment, const SE3& T_O_B, int keyframe);

  // Blocks with segment and surface; robot, stream and number are the caller's. Time is that of the newest image.
  std::vector<mesh_block_t> take_due();
  std::vector<mesh_block_t> take_all();

  std::size_t waiting() const { return schedule_.waiting() + rest_.size(); }  // blocks not said yet
  const TsdfVolume* volume() const { return volume_ ? &*volume_ : nullptr; }

 private:
  void say(const std::vector<BlockIndex>& indices, std::vector<mesh_block_t>& out);

  MapperOptions options_;
  DepthCamera camera_;
  std::optional<TsdfVolume> volume_;
  MeshSchedule schedule_;
  std::int64_t segment_ = 0;
  Utime now_ = 0;
  std::unordered_map<BlockIndex, std::uint64_t, BlockIndexHash> said_;  // digest of what was said
  std::vector<mesh_block_t> rest_;                                      // of the last segment
};

}  // namespace covey::mesh
