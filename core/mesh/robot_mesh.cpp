// SPDX-License-Identifier: BSD-3-Clause
#include "core/mesh/robot_mesh.h"

#include <algorithm>
#include <cmath>

namespace covey::mesh {
namespace {

constexpr float kFurthest = 1e5F;  // m from a robot's start: beyond it a float has no centimetres

std::optional<SE3> pose_from(const double* q_wxyz, const double* t) {
  const Eigen::Quaterniond q(q_wxyz[0], q_wxyz[1], q_wxyz[2], q_wxyz[3]);
  const Eigen::Vector3d translation(t[0], t[1], t[2]);
  if (!(std::abs(q.norm() - 1.0) < 0.01) || !translation.allFinite()) return std::nullopt;
  return SE3{SO3::from_quaternion(q), translation};
}

bool is_good(const mesh_block_t& block) {
  if (block.n_vertices < 0 || block.n_values != 3 * block.n_vertices || block.n_corners % 3 != 0)
    return false;
  const auto near = [](float value) { return std::abs(value) < kFurthest; };
  const auto known = [&](std::int32_t corner) { return corner >= 0 && corner < block.n_vertices; };
  return std::all_of(block.p_O.begin(), block.p_O.end(), near) &&
         std::all_of(block.corners.begin(), block.corners.end(), known);
}

bool is_good(const trajectory_t& part) {
  if (part.n_values != 7 * part.n || part.parts < 1 || part.part < 0 || part.part >= part.parts) return false;
  for (int k = 0; k < part.n; ++k) {
    if (!pose_from(&part.T_W_K[7 * k], &part.T_W_K[7 * k + 4])) return false;
  }
  return true;
}

// The keyframes of one segment: where they stand in the list, by id and by time.
class SegmentKeyframes {
 public:
  void add(int id, Utime utime, int index) {
    by_id_[id] = index;
    by_time_.emplace(utime, index);
  }
  // Of a vertex: the keyframe that saw it, or the last one before its block was seen.
  int index_of(int id, Utime block_utime) const {
    const auto found = by_id_.find(id);
    if (found != by_id_.end()) return found->second;
    const auto after = by_time_.upper_bound(block_utime);
    return after == by_time_.begin() ? after->second : std::prev(after)->second;
  }

 private:
  std::map<int, int> by_id_;
  std::map<Utime, int> by_time_;
};

void append(const mesh_block_t& block, const SegmentKeyframes& keyframes, MeshSnapshot& snapshot) {
  const auto first = static_cast<std::uint32_t>(snapshot.mesh.p_O.size());
  int known_id = -2;  // neighbours are mostly seen by the same keyframe
  int index = -1;
  for (int v = 0; v < block.n_vertices; ++v) {
    snapshot.mesh.p_O.emplace_back(block.p_O[3 * v], block.p_O[3 * v + 1], block.p_O[3 * v + 2]);
    if (block.keyframes[v] != known_id) {
      known_id = block.keyframes[v];
      index = keyframes.index_of(known_id, block.utime);
    }
    snapshot.mesh.seen_by.push_back(index);
  }
  snapshot.colours.insert(snapshot.colours.end(), block.colours.begin(), block.colours.end());
  snapshot.labels.insert(snapshot.labels.end(), block.labels.begin(), block.labels.end());
  for (int c = 0; c + 2 < block.n_corners; c += 3) {
    Face face;
    for (int i = 0; i < 3; ++i) face[i] = first + static_cast<std::uint32_t>(block.corners[c + i]);
    snapshot.mesh.faces.push_back(face);
  }
}

}  // namespace

const char* RobotMesh::take(const mesh_block_t& block) {
  if (block.robot != robot_) return "robot";
  if (!is_good(block)) return "values";
  mesh_block_t& kept = blocks_[{block.stream, block.segment, block.x, block.y, block.z}];
  vertices_ += block.n_vertices - kept.n_vertices;
  kept = block;
  return nullptr;
}

const char* RobotMesh::take(const keyframe_t& keyframe) {
  if (keyframe.robot != robot_) return "robot";
  if (!pose_from(keyframe.q_O_K, keyframe.t_O_K)) return "values";
  const bool is_new = keyframes_.try_emplace({keyframe.segment, keyframe.id}, keyframe).second;
  return is_new ? nullptr : "duplicate";
}

const char* RobotMesh::take(const trajectory_t& part) {
  if (part.robot != robot_) return "robot";
  if (!is_good(part)) return "values";
  if (!round_.empty() && part.utime < round_.front().utime) return "old";
  if (!round_.empty() && part.utime == round_.front().utime) return "duplicate";
  if (!parts_.empty() && part.utime < parts_.begin()->second.utime) return "old";
  if (!parts_.empty() && part.utime > parts_.begin()->second.utime) parts_.clear();
  if (!parts_.try_emplace(part.part, part).second) return "duplicate";
  if (static_cast<int>(parts_.size()) < part.parts) return nullptr;
  round_.clear();
  for (auto& [number, whole] : parts_) round_.push_back(std::move(whole));
  parts_.clear();
  return nullptr;
}

std::map<RobotMesh::KeyframeName, SE3> RobotMesh::poses_of_round() const {
  std::map<KeyframeName, SE3> poses;
  for (const trajectory_t& part : round_) {
    for (int k = 0; k < part.n; ++k) {
      poses[{part.segments[k], part.ids[k]}] = *pose_from(&part.T_W_K[7 * k], &part.T_W_K[7 * k + 4]);
    }
  }
  return poses;
}

std::vector<PlacedKeyframe> RobotMesh::placed_keyframes() const {
  const std::map<KeyframeName, SE3> poses = poses_of_round();
  std::vector<PlacedKeyframe> placed;
  std::vector<PlacedKeyframe> before_first;  // of the segment, known before anything of it has a place
  for (const auto& [name, message] : keyframes_) {
    PlacedKeyframe keyframe{
        message.utime, message.segment, message.id, *pose_from(message.q_O_K, message.t_O_K), {}};
    if (!before_first.empty() && before_first.front().segment != keyframe.segment) before_first.clear();
    const auto pose = poses.find(name);
    if (pose != poses.end()) {
      keyframe.T_W_K = pose->second;
      for (PlacedKeyframe& earlier : before_first) {
        earlier.T_W_K = keyframe.correction() * earlier.T_O_K;
        placed.push_back(earlier);
      }
      before_first.clear();
    } else if (!placed.empty() && placed.back().segment == keyframe.segment) {
      keyframe.T_W_K = placed.back().correction() * keyframe.T_O_K;
    } else {
      before_first.push_back(keyframe);
      continue;
    }
    placed.push_back(keyframe);
  }
  return placed;
}

MeshSnapshot RobotMesh::snapshot(std::vector<PlacedKeyframe> keyframes,
                                 std::optional<Utime> only_segment) const {
  MeshSnapshot snapshot;
  snapshot.keyframes = std::move(keyframes);
  std::map<Utime, SegmentKeyframes> segments;
  for (std::size_t k = 0; k < snapshot.keyframes.size(); ++k) {
    const PlacedKeyframe& keyframe = snapshot.keyframes[k];
    segments[keyframe.segment].add(keyframe.id, keyframe.utime, static_cast<int>(k));
  }
  snapshot.mesh.p_O.reserve(static_cast<std::size_t>(vertices_));
  snapshot.mesh.seen_by.reserve(static_cast<std::size_t>(vertices_));
  for (const auto& [name, block] : blocks_) {
    const auto found = segments.find(name.segment);
    if (found == segments.end() || (only_segment && name.segment != *only_segment)) {
      snapshot.left_out += block.n_vertices;
    } else {
      append(block, found->second, snapshot);
    }
  }
  return snapshot;
}

MeshSnapshot RobotMesh::team() const {
  if (round_.empty()) return {};
  return snapshot(placed_keyframes(), std::nullopt);
}

MeshSnapshot RobotMesh::odometry() const {
  std::vector<PlacedKeyframe> keyframes;
  for (const auto& [name, message] : keyframes_) {
    const SE3 T_O_K = *pose_from(message.q_O_K, message.t_O_K);
    keyframes.push_back({message.utime, message.segment, message.id, T_O_K, T_O_K});
  }
  std::optional<Utime> first;
  for (const auto& [name, block] : blocks_) {
    if (block.n_vertices > 0 && (!first || name.segment < *first)) first = name.segment;
  }
  return snapshot(std::move(keyframes), first);
}

}  // namespace covey::mesh
