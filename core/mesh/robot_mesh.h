// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// What a robot knows of its own mesh: the blocks that mesher said last (MESH), the keyframes that saw them (KEYFRAME) and
// where the team has these now (TRAJECTORY, of the newest round that came whole). From it comes the mesh as measured, ready to
// be deformed.
//
//  - A block replaces the one of the same stream, segment and place.
//  - A vertex without a keyframe, or with one that is not known, takes the last keyframe before its block's newest depth image.
//  - A keyframe that is newer than the round goes on from the newest older one of its segment by odometry.
//  - A segment that no round has placed has no place in W: it is left out of the team's mesh.

#include <covey/keyframe_t.hpp>
#include <covey/mesh_block_t.hpp>
#include <covey/trajectory_t.hpp>
#include <map>
#include <optional>
#include <tuple>
#include <utility>
#include <vector>

#include "core/mesh/measured_mesh.h"

namespace covey::mesh {

struct BlockName {
  Utime stream = 0;
  Utime segment = 0;
  std::int32_t x = 0;
  std::int32_t y = 0;
  std::int32_t z = 0;

  auto operator<=>(const BlockName&) const = default;
};

// The mesh of several blocks with what rides along.
struct MeshSnapshot {
  MeasuredMesh mesh;
  std::vector<std::uint8_t> colours;  // red, green, blue of vertex after vertex
  std::vector<std::uint8_t> labels;   // 255: unknown
  std::vector<PlacedKeyframe> keyframes;
  int left_out = 0;  // vertices of segments that have no place
};

class RobotMesh {
 public:
  explicit RobotMesh(int robot) : robot_(robot) {}

  // Null, or why the message is of no use: "robot", "values", "duplicate", "old".
  const char* take(const mesh_block_t& block);
  const char* take(const keyframe_t& keyframe);
  const char* take(const trajectory_t& part);

  // In W as the keyframes have it: rigid block by block, to be deformed. Empty before the first round.
  MeshSnapshot team() const;
  // In O of the first segment that has a mesh; T_W_K of its keyframes is T_O_K. Other segments have other frames, and where
  // they lie to each other only the team's rounds know: they are left out.
  MeshSnapshot odometry() const;

  // Of the newest round that came whole; none before the first.
  const std::vector<trajectory_t>& round() const { return round_; }
  const std::map<BlockName, mesh_block_t>& blocks() const { return blocks_; }
  const std::map<std::pair<Utime, int>, keyframe_t>& keyframes() const { return keyframes_; }
  std::int64_t vertices() const { return vertices_; }

 private:
  using KeyframeName = std::pair<Utime, int>;  // segment, id

  std::map<KeyframeName, SE3> poses_of_round() const;
  std::vector<PlacedKeyframe> placed_keyframes() const;
  MeshSnapshot snapshot(std::vector<PlacedKeyframe> keyframes, std::optional<Utime> only_segment) const;

  int robot_;
  std::map<BlockName, mesh_block_t> blocks_;
  std::map<KeyframeName, keyframe_t> keyframes_;
  std::map<int, trajectory_t> parts_;  // of the round that is coming in
  std::vector<trajectory_t> round_;
  std::int64_t vertices_ = 0;
};

}  // namespace covey::mesh
