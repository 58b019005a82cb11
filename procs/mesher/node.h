// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// A robot's mapper, wired to its buses.
//
//   reads   DEPTH (depth bus); STATE, KEYFRAME
//   writes  MESH: blocks that have changed, in their own time (core/mesh/mesh_schedule.h), and all that are left where no image has come
//           for idle_s and at the end; the --ply file at the end; STATUS
//
// An image waits until a STATE is at least as new as it. STATUS: phase `waiting` (for the first image with a pose), `mapping`; counters
// integrated, dropped/DEPTH/REASON: size, late (no newer than the one before), no_pose (older than what is known of the way), gap (in the
// STATEs around it), coasting (odometry had no images), overflow (too many wait); blocks_forgotten; gauges blocks, volume_mb,
// waiting_images, waiting_blocks; samples integrate_ms (an image into the volume), mesh_ms (blocks that are due).

#include <deque>
#include <filesystem>
#include <optional>

#include "core/mesh/keyframe_stamps.h"
#include "core/mesh/mapper.h"
#include "core/mesh/pose_history.h"
#include "procs/common/process.h"
#include "procs/mesher/mesh_file.h"

namespace covey {

struct MesherOptions {
  std::filesystem::path ply;
};

class MesherNode {
 public:
  MesherNode(Process& process, const MesherOptions& options);

 private:
  void on_depth(const depth_t& image);
  void on_state(const state_t& state);
  void work();
  void integrate(const depth_t& image, const mesh::TimedPose& pose);
  void take_due();
  void enqueue(std::vector<mesh_block_t> blocks);
  void publish_some(std::size_t most_bytes);
  void finish();
  void publish_gauges();

  Process& process_;
  std::filesystem::path ply_;
  DepthCamera camera_;
  mesh::MapperOptions options_;
  std::optional<mesh::Mapper> mapper_;
  mesh::PoseHistory poses_;
  mesh::KeyframeStamps keyframes_;
  std::deque<depth_t> images_;  // that wait for their pose
  std::int64_t segment_ = 0;
  Utime newest_image_ = 0;   // of the segment
  Utime integrated_at_ = 0;  // when the newest image was, by the clock
  std::deque<mesh_block_t> to_say_;
  std::int64_t stream_ = 0;
  std::int32_t next_number_ = 0;
  MeshFile file_;
};

}  // namespace covey
